"""Building from folders: what can be read is in, what cannot is written down, a stopped build goes on."""

import json
import shutil
from dataclasses import dataclass, replace

import numpy as np
import pytest
import trimesh
from test_disk import assert_same

from graft import zoo
from graft.errors import InputError
from graft.features import GeometricDescriptor
from graft.io import load_object, save_demonstration
from graft.library import Library, LocalExecutor, build, verify
from graft.library.building import FAILURES
from graft.library.executors import Lost
from graft.marking import mark_contact

DESCRIPTOR = GeometricDescriptor()


@dataclass(frozen=True)
class Here:
    """Runs tasks in this process; folders named `deadly` kill the worker."""

    workers: int = 2

    def map(self, work, tasks):
        for task in tasks:
            yield Lost("it died") if any(f.name == "deadly" for f in task.folders) else work(task)


def save_labelled(folder, obj):
    """Write an object as one mesh, a label per face and words that call the first two parts graspable."""
    folder.mkdir(parents=True)
    firsts = np.cumsum([0, *(len(part.vertices) for part in obj.parts)])[:-1]
    faces = np.concatenate([part.faces + first for part, first in zip(obj.parts, firsts, strict=True)])
    vertices = np.concatenate([part.vertices for part in obj.parts])
    trimesh.Trimesh(vertices, faces, process=False).export(folder / "mesh.ply")
    labels = np.repeat(np.arange(len(obj.parts)), [len(part.faces) for part in obj.parts])
    (folder / "parts.seg").write_text("\n".join(map(str, labels)))
    words = {"category": obj.category, "graspable_parts": [0, 1], "part_names": list(obj.part_names)}
    (folder / "object.json").write_text(json.dumps(words))


@pytest.fixture
def folders(tmp_path):
    """Six demonstrations, two labelled objects, three folders that are no good, one that is a copy."""
    root = tmp_path / "objects"
    for seed, category in enumerate(zoo.demonstrated()[:3]):
        for number in range(2):
            shown = replace(zoo.demonstration(category, seed), name=f"{category}-{number}")
            if number:
                shown = mark_contact(zoo.make(category, 9), shown.contact.part, name=shown.name)
            save_demonstration(root / "some" / "where" / shown.name, shown)
    for name in ("mug", "kettle"):
        save_labelled(root / "labelled" / name, zoo.make(name, 3))
    first = next((root / "some" / "where").iterdir())
    for name in ("broken", "empty", "deadly"):
        shutil.copytree(first, root / name)
        words = json.loads((root / name / "demonstration.json").read_text())
        (root / name / "demonstration.json").write_text(json.dumps({**words, "name": name}))
    (root / "broken" / "object.glb").write_bytes(b"glTF, but not really")
    (root / "empty" / "demonstration.json").write_text("{}")
    shutil.copytree(first, root / "again")
    (root / "notes").mkdir()
    return root


def test_what_can_be_read_is_in_and_what_cannot_is_written_down(folders, tmp_path):
    out = tmp_path / "library"
    told = []
    report = build([folders], out, descriptor=DESCRIPTOR, executor=Here(), progress=lambda *three: told.append(three))
    assert (report.folders, report.skipped, report.added) == (12, 0, 10)
    assert told[-1] == (12, 12, 3)
    assert [where.rpartition("/")[2] for where, _ in report.failures] == ["broken", "deadly", "empty"]
    written = [json.loads(line) for line in (out / FAILURES).read_text().splitlines()]
    assert [(w["folder"], w["reason"]) for w in written] == list(report.failures)
    assert "it died" in written[1]["reason"]
    assert "schema: expected 1" in written[2]["reason"]
    # The copy comes first, as its folder does; what it is a copy of is left out.
    assert [name for _, name in report.duplicates] == [next(iter(Library.open(out))).name]
    library = Library.open(out)
    names = [d.name for d in library]
    assert {n for n in names if ":" in n} == {"mug:body", "mug:handle", "kettle:body", "kettle:lid"}
    match = library.retrieve(load_object(folders / "labelled" / "kettle"), 1)[0]
    assert match.demonstration.name.startswith("kettle:")
    assert verify(out).problems == ()


def test_a_second_build_adds_what_is_new_and_tries_what_failed(folders, tmp_path):
    out = tmp_path / "library"
    build([folders], out, descriptor=DESCRIPTOR, executor=Here())
    shutil.rmtree(folders / "empty")
    shutil.copytree(folders / "labelled" / "mug", folders / "labelled" / "cup")
    words = json.loads((folders / "labelled" / "cup" / "object.json").read_text())
    (folders / "labelled" / "cup" / "object.json").write_text(json.dumps({**words, "category": "cup"}))
    report = build([folders], out, descriptor=DESCRIPTOR, executor=Here())
    assert (report.folders, report.skipped, report.added, len(report.failures)) == (12, 8, 2, 2)
    assert len(Library.open(out)) == 12


def test_processes_build_the_same_library_as_shards_and_as_one(folders, tmp_path):
    for name in ("broken", "empty", "deadly", "again"):
        shutil.rmtree(folders / name)
    build([folders], tmp_path / "one", descriptor=DESCRIPTOR, executor=Here(1))
    build([folders], tmp_path / "two", descriptor=DESCRIPTOR, executor=LocalExecutor(2))
    for number in (1, 2, 3):
        build([folders], tmp_path / "shards", descriptor=DESCRIPTOR, executor=Here(1), shard=(number, 3))
    one, two, shards = (tuple(Library.open(tmp_path / name)) for name in ("one", "two", "shards"))
    assert_same(one, two)
    assert_same(one, tuple(sorted(shards, key=lambda d: [e.name for e in one].index(d.name))))
    targets = [load_object(folders / "labelled" / "mug")]
    costs = [
        [[m.cost for m in found] for found in Library.open(tmp_path / name).retrieve_batch(targets, 4)]
        for name in ("one", "two")
    ]
    assert costs[0] == costs[1]


def test_a_stopped_build_goes_on(folders, tmp_path, monkeypatch):
    monkeypatch.setattr("graft.library.building.COMMIT_SECONDS", 0.0)
    out = tmp_path / "library"

    @dataclass(frozen=True)
    class Stopped:
        workers: int = 1

        def map(self, work, tasks):
            for number, task in enumerate(tasks):
                if number == 6:
                    raise KeyboardInterrupt
                yield work(task)

    with pytest.raises(KeyboardInterrupt):
        build([folders], out, descriptor=DESCRIPTOR, executor=Stopped())
    before = len(Library.open(out))
    assert before > 0
    report = build([folders], out, descriptor=DESCRIPTOR, executor=Here())
    assert 0 < report.skipped < report.folders
    assert len(Library.open(out)) == before + report.added == 10


def test_bad_requests_are_named(folders, tmp_path):
    with pytest.raises(InputError, match="expected a folder of demonstrations"):
        build([folders / "nowhere"], tmp_path / "library", descriptor=DESCRIPTOR, executor=Here())
    with pytest.raises(InputError, match=r"shard: expected i/n with 1 <= i <= n, got 3/2"):
        build([folders], tmp_path / "library", descriptor=DESCRIPTOR, executor=Here(), shard=(3, 2))
    Library.create(tmp_path / "library")
    with pytest.raises(InputError, match="descriptors: the library has"):
        build([folders], tmp_path / "library", descriptor=None, executor=Here())
    with pytest.raises(InputError, match="descriptors: the library has"):
        build([folders], tmp_path / "library", descriptor=GeometricDescriptor(families=("hull",)), executor=Here())
