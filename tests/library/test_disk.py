"""Libraries on disk give back what was put in, to the last bit, and answer as in memory."""

import dataclasses
import re
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from graft import zoo
from graft.errors import InputError, MissingExtraError
from graft.features import GeometricDescriptor
from graft.graph import build_graph
from graft.library import Filter, Library, checkout, compact, export_table, vacuum, verify, versions
from graft.marking import mark_contact
from graft.objects import Joint, Part, PartObject
from graft.transport import UFGW


def assert_same(left, right):
    """Compare dataclasses, tuples and arrays to the last bit."""
    if dataclasses.is_dataclass(left):
        for field in dataclasses.fields(left):
            assert_same(getattr(left, field.name), getattr(right, field.name))
    elif isinstance(left, np.ndarray):
        assert left.dtype == right.dtype
        np.testing.assert_array_equal(left, right)
    elif isinstance(left, tuple):
        assert len(left) == len(right)
        for a, b in zip(left, right, strict=True):
            assert_same(a, b)
    else:
        assert left == right


def answers(library, target, k=6, **flags):
    return [(m.demonstration.name, m.cost) for m in library.retrieve(target, k, **flags)]


def test_objects_and_graphs_come_back_to_the_last_bit(made, pairs, targets):
    opened = Library.open(made)
    assert_same(tuple(opened), tuple(shown for shown, _ in pairs))
    graphs = {shown.name: graph for shown, graph in pairs}
    for match in opened.retrieve(targets[0], 10):
        assert_same(match.source, graphs[match.demonstration.name])


def test_joints_clouds_notes_and_directions_come_back(tmp_path):
    cloud = np.random.default_rng(0).random((50, 3))
    normals = np.random.default_rng(1).normal(size=(50, 3))
    mug = zoo.make("mug")
    parts = (*mug.parts, Part("cloud", cloud, normals=normals, label="blob", notes=("3 dropped",)), Part("dots", cloud))
    joints = (
        Joint(0, 1, "hinge", "lid", np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3]), (-np.inf, 1 / 3)),
        Joint(1, 2),
    )
    up = np.array([0.3, 0.2, 0.9])
    obj = PartObject("odd", parts, joints, None, up, None, (1,), ("a note",), "file.glb")
    shown = mark_contact(obj, 1, approach=np.array([0.1, 0.7, 0.3]), metadata={"x": [1, {"y": 0.1}]})
    library = Library.create(tmp_path / "library")
    library.add(shown)
    opened = Library.open(tmp_path / "library")
    assert_same(tuple(opened), (shown,))
    assert_same(opened.retrieve(mug, 1)[0].source, build_graph(obj))


@pytest.mark.parametrize(
    "solver",
    [UFGW(), UFGW(saliency=0.9, tau_s=0.2), UFGW(cost="debiased"), UFGW(part_weight=0.0, lambda_relation=0.0)],
)
def test_it_answers_as_in_memory_and_as_brute_force(made, pairs, targets, solver):
    memory = Library(solver=solver)
    memory.extend_graphs(*zip(*pairs, strict=True))
    opened = Library.open(made, solver=solver)
    for target in targets:
        costs = [t.cost for t in solver.batch([g for _, g in pairs], [d.contact.part for d, _ in pairs], target)]
        brute = [(pairs[i][0].name, costs[i]) for i in np.argsort(costs, kind="stable")[:6]]
        assert answers(opened, target) == answers(memory, target) == brute


def test_samples_that_are_not_stored_are_made_again(tmp_path, pairs, targets):
    library = Library.create(tmp_path / "lean", samples=False)
    library.extend_graphs(*zip(*pairs[:3], strict=True))
    match = Library.open(tmp_path / "lean").retrieve(targets[0], 1)[0]
    assert_same(match.source, next(g for d, g in pairs if d.name == match.demonstration.name))


FILTERS = [
    Filter(category=("mug", "kettle")),
    Filter(tags=("kitchen",)),
    Filter(tags=("kitchen", "left"), licence=("CC0",)),
    Filter(max_gripper_width=0.04),
    Filter(category=("nothing of the kind",)),
]


@pytest.mark.parametrize("only", FILTERS)
def test_filters_choose_the_same_on_disk_and_in_memory(made, memory, targets, only):
    opened = Library.open(made)
    found = opened.retrieve(targets[0], 50, only=only)
    assert [m.demonstration.name for m in found] == [n for n, _ in answers(memory, targets[0], 50, only=only)]
    assert all(only.accepts(m.demonstration) for m in found)
    assert len(found) == sum(only.accepts(d) for d in memory)
    expected = answers(memory, targets[0], 3, where=only.accepts)
    assert answers(opened, targets[0], 3, where=only.accepts) == expected == answers(opened, targets[0], 3, only=only)


def test_costs_above_the_bar_are_left_out(made, memory, targets):
    every = answers(memory, targets[1], 50)
    bar = every[7][1]
    assert answers(Library.open(made), targets[1], 50, max_cost=bar) == every[:8]
    assert answers(memory, targets[1], 50, max_cost=bar) == every[:8]
    assert answers(memory, targets[1], 50, max_cost=every[0][1] / 2) == []


def test_equal_costs_keep_the_order_of_the_library_across_segments(tmp_path, pairs, targets):
    library = Library.create(tmp_path / "equal", samples=False)
    shown, graph = pairs[0]
    for name in ("c", "a", "b", "d"):
        library.extend_graphs([dataclasses.replace(shown, name=name)], [graph])
    assert [name for name, _ in answers(library, targets[0], 3)] == ["c", "a", "b"]


def test_removed_objects_do_not_answer_and_compacting_changes_nothing(store, memory, targets):
    gone = [d.name for d in memory][1::3]
    left = Library()
    left.extend(d for d in memory if d.name not in gone)
    library = Library.open(store)
    library.remove(gone[:2])
    library.remove(gone[2:])
    assert len(library) == len(left)
    for target in targets:
        assert answers(library, target) == answers(left, target)
        assert answers(library, target, only=FILTERS[0]) == answers(left, target, only=FILTERS[0])
    assert [d.name for d in library] == [d.name for d in left]
    small = compact(store, objects=20)
    assert max(s.objects for s in small.manifest.segments) <= 20
    whole = compact(store)
    assert [s.objects for s in whole.manifest.segments] == [len(left)]
    for target in targets:
        assert answers(Library.open(store), target) == answers(left, target)
    assert_same(tuple(Library.open(store)), tuple(left))
    assert compact(store).manifest.version == whole.manifest.version
    assert verify(store).problems == ()


def test_old_versions_answer_until_they_are_vacuumed(store, targets):
    newest = Library.open(store)
    numbers = [m.version for m in versions(store)]
    assert numbers == [1, 2, 3, 4, 5]
    assert [m.objects for m in versions(store)] == sorted(m.objects for m in versions(store))
    old = Library.open(store, version=3)
    assert len(old) < len(newest)
    before = answers(old, targets[0])
    checkout(store, 3)
    again = Library.open(store)
    assert (again.version, len(again), answers(again, targets[0])) == (6, len(old), before)
    files, size = vacuum(store, grace=0)
    assert (files, size > 100_000) == (5 + 8, True)
    assert [m.version for m in versions(store)] == [6]
    assert answers(Library.open(store), targets[0]) == before
    report = verify(store)
    assert (report.problems, report.foreign) == ((), ())
    with pytest.raises(InputError, match="no such version"):
        Library.open(store, version=3)


def test_another_descriptor_is_refused_with_both_names(store, pairs):
    other = GeometricDescriptor(families=("hull",))
    with pytest.raises(
        InputError, match=re.escape(f"has {GeometricDescriptor().name} (") + ".*" + re.escape(f"got {other.name} (")
    ):
        Library.open(store, descriptor=other)
    blind = Library.open(store, descriptor=None)
    assert blind.retrieve(pairs[0][0].object, 1)[0].demonstration.name == pairs[0][0].name
    with pytest.raises(InputError, match="opened without any"):
        blind.add(dataclasses.replace(pairs[0][0], name="new"))
    with pytest.raises(InputError, match="the library has"):
        blind.extend_graphs(
            [dataclasses.replace(pairs[0][0], name="new")], [build_graph(zoo.make("mug"), descriptor=None)]
        )


def test_a_library_without_descriptors_takes_none(tmp_path, pairs, targets):
    library = Library.create(tmp_path / "bare", descriptor=None)
    library.add(pairs[0][0])
    opened = Library.open(tmp_path / "bare")
    opened.add(pairs[1][0])
    assert len(opened.retrieve(targets[0], 5)) == 2


def test_bad_requests_change_nothing(store, pairs):
    library = Library.open(store)
    shown, graph = pairs[0]
    for change, message in (
        (lambda: library.extend_graphs([shown], [graph]), "already"),
        (lambda: library.extend_graphs([dataclasses.replace(shown, name="x")] * 2, [graph] * 2), "'x' already"),
        (lambda: library.remove(["nobody", shown.name]), "no demonstration called 'nobody'"),
        (lambda: Library.create(store), "it holds files"),
        (lambda: checkout(store, 99), "no such version"),
        (lambda: vacuum(store, keep=0), "keep: expected at least 1"),
        (lambda: Library().snapshot, "in memory"),
        (lambda: Filter(category="mug"), "expected a tuple"),
    ):
        with pytest.raises(InputError, match=message):
            change()
    odd = dataclasses.replace(shown, name="odd", metadata={"x": object()})
    with pytest.raises(InputError, match="metadata of 'odd'"):
        library.extend_graphs([odd], [graph])
    assert [m.version for m in versions(store)] == [1, 2, 3, 4, 5]
    assert verify(store).foreign == ()


def test_exported_tables_hold_every_object(store, pairs, tmp_path, monkeypatch):
    library = Library.open(store)
    library.remove([pairs[0][0].name])
    assert export_table(library.snapshot, tmp_path / "x" / "table.parquet", "parquet") == len(pairs) - 1
    table = pq.read_table(tmp_path / "x" / "table.parquet")
    assert table["name"].to_pylist() == [shown.name for shown, _ in pairs[1:]]
    vertices = np.concatenate([part.vertices for part in pairs[1][0].object.parts])
    np.testing.assert_array_equal(np.reshape(table["vertices"][0].as_py(), (-1, 3)), vertices)
    np.testing.assert_array_equal(np.reshape(table["relations"][0].as_py(), (-1, 34)), pairs[1][1].relations)
    with pytest.raises(InputError, match="it exists, nothing is written"):
        export_table(library.snapshot, tmp_path / "x", "parquet")
    monkeypatch.setitem(sys.modules, "lance", None)
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[lance\]"):
        export_table(library.snapshot, tmp_path / "table.lance", "lance")
    assert [p.name for p in (tmp_path / "x").iterdir()] == ["table.parquet"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_lance_reads_what_was_exported(store, pairs, tmp_path):
    lance = pytest.importorskip("lance")
    export_table(Library.open(store).snapshot, tmp_path / "table.lance", "lance")
    table = lance.dataset(str(tmp_path / "table.lance")).to_table(columns=["name"])
    assert table["name"].to_pylist() == [shown.name for shown, _ in pairs]
