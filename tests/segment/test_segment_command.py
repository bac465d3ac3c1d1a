"""`graft segment`, `load_object(parts="segment")` and `graft evaluate segmentation` as they are called."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from grid_solids import dumbbell, voxel_mesh

import graft
import graft.viz.ply
from graft.cli import EXIT_BAD_INPUT, EXIT_OK, main
from graft.evaluate.automatic import automatic_parts
from graft.evaluate.protocols import Posing, from_objects
from graft.io.save import save_object
from graft.objects import Part, PartObject


@pytest.fixture(scope="module")
def drawn() -> PartObject:
    vertices, faces, labels = voxel_mesh(dumbbell, cells=40)
    parts = []
    for name, number in (("ball", 0), ("other", 1), ("bar", 2)):
        used, index = np.unique(faces[labels == number], return_inverse=True)
        parts.append(Part(name, vertices[used], index.reshape(-1, 3)))
    return PartObject("dumbbell", tuple(parts), graspable=(2,))


@pytest.fixture
def stl(tmp_path: Path) -> Path:
    vertices, faces, _ = voxel_mesh(dumbbell, cells=40)
    path = tmp_path / "dumbbell.obj"
    save_object(path, PartObject("dumbbell", (Part("all", vertices, faces),)))
    return path


def test_files_of_one_part_are_cut_only_when_asked(stl: Path) -> None:
    assert len(graft.load_object(stl).parts) == 1
    assert len(graft.load_object(stl, parts="segment").parts) == 3


def test_labels_come_back_from_the_ply(stl: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "parts.ply"
    assert main(["segment", str(stl), "--out", str(out), "--json"]) == EXIT_OK
    told = [part["faces"] for part in json.loads(capsys.readouterr().out)["parts"]]
    back = graft.load_object(out)
    assert [len(part.faces) for part in back.parts] == told
    assert back.part_names == ("part_0", "part_1", "part_2")


def test_a_hierarchy_is_printed_and_written_level_by_level(
    stl: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["segment", str(stl), "--hierarchy", "--out", str(tmp_path / "h.glb")]) == EXIT_OK
    assert "3 *" in capsys.readouterr().out
    assert len(graft.load_object(tmp_path / "h.2.glb").parts) == 2


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--parts", "0"], "--parts: expected at least 1, got 0"),
        (["--seed", "-1"], "--seed: expected at least 0"),
        (["--hierarchy", "--parts", "2"], "--hierarchy"),
        (["--out", "x.stl"], "--out: expected a file ending in .png, .html, .glb, .ply"),
    ],
)
def test_mistakes_are_one_line(stl: Path, flags: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["segment", str(stl), *flags]) == EXIT_BAD_INPUT
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_automatic_parts_keep_the_mask(drawn: PartObject) -> None:
    obj = automatic_parts(drawn)
    assert len(obj.parts) == 3
    assert len(obj.graspable) == 1
    middle = obj.parts[obj.graspable[0]].vertices
    assert np.abs(middle[:, 0]).max() < 0.4


def test_a_benchmark_shows_automatic_parts_of_targets_only(drawn: PartObject) -> None:
    objects = [PartObject(name, drawn.parts, category=name, graspable=drawn.graspable) for name in ("first", "second")]
    benchmark = from_objects("leave-category-out", objects, Posing(parts="auto-target"))
    for query in benchmark.queries:
        subject = benchmark.subjects[query.target]
        assert subject.object.part_names == ("part_0", "part_1", "part_2")
        assert subject.truth.part_names == ("ball", "other", "bar")
        assert benchmark.category(query.target) == query.key
        for i in query.sources:
            assert benchmark.sources[i].demonstration.object.part_names == ("ball", "other", "bar")
            assert benchmark.category(benchmark.sources[i].subject) != query.key


def test_an_evaluation_goes_on_and_measures_people(
    stl: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    vertices, faces, labels = voxel_mesh(dumbbell, cells=40)
    folder = tmp_path / "objects" / "one"
    folder.mkdir(parents=True)
    graft.viz.ply.save_ply(folder / "mesh.ply", PartObject("one", (Part("all", vertices, faces),)))
    np.savez(folder / "human_segmentations.npz", labels=np.stack([labels, labels, np.minimum(labels, 1)]))
    command = ["evaluate", "segmentation", str(tmp_path / "objects"), "--workers", "1", "--out", str(tmp_path / "out")]
    command += ["--only", "graft", "connected components", "k-means, told k", "--json"]
    assert main(command) == EXIT_OK
    first = json.loads(capsys.readouterr().out)
    rows = {row["method"]: row for row in first["rows"]}
    assert list(rows) == ["people", "graft", "connected components", "k-means, told k"]
    assert rows["graft"]["rand"] < rows["connected components"]["rand"]
    assert rows["connected components"]["cut"] is None
    assert rows["people"]["parts"] == pytest.approx(8 / 3)
    assert main(command) == EXIT_OK
    assert json.loads(capsys.readouterr().out) == first


def test_labels_of_another_mesh_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    vertices, faces, labels = voxel_mesh(dumbbell, cells=24)
    folder = tmp_path / "one"
    folder.mkdir()
    graft.viz.ply.save_ply(folder / "mesh.ply", PartObject("one", (Part("all", vertices, faces),)))
    np.savez(folder / "human_segmentations.npz", labels=np.stack([labels, labels])[:, 1:])
    assert main(["evaluate", "segmentation", str(tmp_path)]) == EXIT_BAD_INPUT
    assert f"{len(faces) - 1} labels for {len(faces)} faces" in capsys.readouterr().err
