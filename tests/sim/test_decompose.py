"""Decompositions: what they cover, what they leave open, how they are kept."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from sim_scenes import channel
from test_pieces import outside

from graft.errors import InputError, MissingExtraError
from graft.objects import Floats
from graft.sim.capping import capped, enclosed
from graft.sim.decompose import DecompositionConfig, decompose
from graft.sim.pieces import collision_pieces

QUICK = DecompositionConfig(mcts_nodes=4, mcts_iterations=10, mcts_max_depth=1)


@pytest.fixture
def channel_pieces(tmp_path: Path) -> tuple[Floats, ...]:
    pytest.importorskip("coacd")
    return collision_pieces(channel(), QUICK, cache=tmp_path)


def test_a_channel_is_covered_and_stays_open(channel_pieces: tuple[Floats, ...]) -> None:
    assert outside(channel().parts[0].vertices, channel_pieces).max() < 1e-3
    assert outside(np.array([(0.0, 0, z) for z in (0.04, 0.06, 0.079)]), channel_pieces).min() > 0.01


def test_the_second_time_comes_from_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("coacd")
    part = channel().parts[0]
    first = decompose(part.vertices, part.faces, QUICK, cache=tmp_path)
    monkeypatch.setitem(sys.modules, "coacd", None)
    second = decompose(part.vertices, part.faces, QUICK, cache=tmp_path)
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    (kept,) = (tmp_path / "pieces").iterdir()
    # Half a file, as a full disk leaves it, is no cache; another setting is another key.
    kept.write_bytes(kept.read_bytes()[:50])
    for config in (QUICK, DecompositionConfig()):
        with pytest.raises(MissingExtraError, match=r"coacd: pip install 'graft-robotics\[sim\]'"):
            decompose(part.vertices, part.faces, config, cache=tmp_path)


def test_a_folder_that_cannot_be_written_is_done_without(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("coacd")
    part = channel().parts[0]
    (tmp_path / "pieces").write_text("in the way")
    assert len(decompose(part.vertices, part.faces, QUICK, cache=tmp_path)) > 1
    assert "are not kept" in capsys.readouterr().err


@pytest.mark.parametrize(("field", "value"), [("threshold", 0.0), ("threshold", 2.0), ("mcts_nodes", 0), ("faces", 0)])
def test_settings_out_of_range(field: str, value: float) -> None:
    with pytest.raises(InputError, match=f"decomposition {field}: expected"):
        DecompositionConfig(**{field: value})


def test_a_hole_is_closed_by_a_fan() -> None:
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    vertices, faces = capped(mesh.vertices, mesh.faces[:-2])
    assert enclosed(vertices, faces) == pytest.approx(0.006)


def test_a_cut_through_a_wall_is_closed_by_a_strip() -> None:
    mesh = trimesh.creation.annulus(r_min=0.03, r_max=0.04, height=0.1)
    flat = np.abs(mesh.face_normals[:, 2]) > 0.9
    low = mesh.triangles_center[:, 2] < 0
    vertices, faces = capped(mesh.vertices, mesh.faces[~(flat & low)])
    assert enclosed(vertices, faces) == pytest.approx(mesh.volume, rel=1e-9)


def test_a_closed_surface_stays_as_it_is() -> None:
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    _, faces = capped(mesh.vertices, mesh.faces)
    assert len(faces) == 12
