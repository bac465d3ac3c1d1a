from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from graft import zoo
from graft.errors import InputError
from graft.graph import build_graph
from graft.library import Library, match
from graft.marking import mark_contact


@pytest.fixture(scope="module")
def library():
    filled = Library()
    filled.extend(zoo.demonstration(category) for category in zoo.demonstrated())
    return filled


def test_the_object_itself_is_its_own_best_match(library):
    for demonstration in library:
        matches = library.retrieve(demonstration.object, k=4)
        assert matches[0].demonstration is demonstration
        assert [m.rank for m in matches] == [0, 1, 2, 3]
        assert [m.cost for m in matches] == sorted(m.cost for m in matches)


def test_retrieving_from_a_library_equals_matching_one_by_one(library):
    target = zoo.make("kettle", 1)
    alone = {d.name: match(d, target).cost for d in library}
    for found in library.retrieve(target, k=4):
        assert found.cost == pytest.approx(alone[found.demonstration.name], rel=1e-12)
        assert found.transport.plan.shape == (len(found.source.object.parts), len(target.parts))


def test_equal_costs_keep_the_order_of_the_library():
    mug = zoo.demonstration("mug")
    library = Library()
    for name in ("b", "a", "c"):
        library.add(mark_contact(mug.object, mug.contact.part, mug.contact.point, name=name))
    assert [m.demonstration.name for m in library.retrieve(zoo.make("jug"), k=3)] == ["b", "a", "c"]


def test_where_filters_and_k_may_exceed_the_library(library):
    found = library.retrieve(zoo.make("kettle"), k=50, where=lambda d: d.object.category == "mug")
    assert [m.demonstration.object.category for m in found] == ["mug"]
    assert library.retrieve(zoo.make("kettle"), where=lambda d: False) == []


def test_a_graph_may_stand_for_the_target(library):
    graph = library.graph(zoo.make("kettle"))
    assert library.retrieve(graph)[0].target is graph


def test_descriptors_of_another_kind_are_refused(library):
    graph = build_graph(zoo.make("kettle"), descriptor=None)
    bare = Library(descriptor=None)
    bare.add(zoo.demonstration("mug"))
    assert np.isfinite(bare.retrieve(graph)[0].cost)


def test_saved_and_opened_it_answers_the_same(library, tmp_path):
    library.save(tmp_path / "demos")
    opened = Library.open(tmp_path / "demos")
    assert sorted(d.name for d in opened) == sorted(d.name for d in library)
    before = {m.demonstration.name: m.cost for m in library.retrieve(zoo.make("handbag"), k=9)}
    after = {m.demonstration.name: m.cost for m in opened.retrieve(zoo.make("handbag"), k=9)}
    # GLB holds single precision, and the descriptor counts on that.
    assert_allclose([after[n] for n in sorted(after)], [before[n] for n in sorted(before)], rtol=1e-2)


@pytest.mark.parametrize("k", [0, -1])
def test_k_must_be_positive(library, k):
    with pytest.raises(InputError, match=r"k: expected at least 1"):
        library.retrieve(zoo.make("kettle"), k=k)


def test_empty_libraries_and_repeated_names_are_errors(library, tmp_path):
    with pytest.raises(InputError, match="empty"):
        Library().retrieve(zoo.make("kettle"))
    with pytest.raises(InputError, match="already"):
        library.add(next(iter(library)))
    with pytest.raises(InputError, match="no demonstration"):
        Library.open(tmp_path)


@pytest.mark.parametrize("name", ["..", "../mug", "a/b", "a\\b", "a\nb"])
def test_a_name_that_leads_out_of_the_folder_is_not_saved(tmp_path, name):
    mug = zoo.demonstration("mug")
    library = Library()
    library.add(mug)
    library.add(mark_contact(mug.object, mug.contact.part, mug.contact.point, name=name))
    with pytest.raises(InputError, match="expected a name that can be a folder's"):
        library.save(tmp_path / "library")
    assert list(tmp_path.iterdir()) == []


def test_a_large_library_is_pruned_and_answers_the_same(monkeypatch):
    library = Library()
    for category in zoo.categories():
        for seed in range(2):
            demonstration = zoo.demonstration(category, seed)
            library.add(replace(demonstration, name=f"{category}_{seed}"))
    target = zoo.make("kettle", 7)
    plain = library.retrieve(target, k=6)
    monkeypatch.setattr("graft.library.library.PRUNED", 2)
    pruned = library.retrieve(target, k=6)
    assert [m.demonstration.name for m in pruned] == [m.demonstration.name for m in plain]
    assert [m.cost for m in pruned] == [m.cost for m in plain]
    library.add(replace(zoo.demonstration("kettle", 7), name="the target itself"))
    assert library.retrieve(target, k=1)[0].demonstration.name == "the target itself"
