import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from graft import zoo
from graft.contact import dense_map
from graft.contact.dense import _nearest_codes
from graft.library import match


def test_dense_map_of_an_object_onto_itself_is_the_identity():
    demonstration = zoo.demonstration("mug", 1)
    found = match(demonstration, demonstration.object)
    dense = dense_map(found)
    assert len(dense.points) == sum(len(p) for p in found.target.points)
    assert_allclose(dense.source_points, dense.points, atol=1e-9)
    assert (dense.source_part == dense.part).all()
    hottest = dense.points[dense.heat.argmax()]
    assert np.linalg.norm(hottest - demonstration.contact.point) < 0.1 * found.target.diagonal
    assert dense.heat.min() >= 0.0
    assert dense.heat.max() <= 1.0
    assert dense.part[dense.heat.argmax()] == demonstration.contact.part


@pytest.mark.parametrize(("source", "target"), [("mug", "kettle"), ("wine_bottle", "spray"), ("teapot", "phone")])
def test_every_sample_corresponds_to_one_on_the_part_that_sends_it_most(source, target):
    found = match(zoo.demonstration(source, 0), zoo.make(target, 0))
    dense = dense_map(found)
    for array in (dense.points, dense.source_points, dense.heat):
        assert np.isfinite(array).all()
    for part in range(len(found.target)):
        rows = dense.part == part
        sender = int(found.transport.plan[:, part].argmax())
        assert_array_equal(dense.points[rows], found.target.points[part])
        assert (dense.source_part[rows] == sender).all()
        known = {tuple(p) for p in found.source.points[sender]}
        assert all(tuple(p) in known for p in dense.source_points[rows])
    assert 0.0 < dense.heat.max() <= 1.0


def test_nearest_codes_are_the_brute_force_ones_and_the_first_of_equals():
    rng = np.random.default_rng(0)
    codes, others = rng.normal(size=(40, 36)), rng.normal(size=(50, 36))
    others[30] = others[4]
    table = np.linalg.norm(codes[:, None] - others[None], axis=2)
    assert_array_equal(_nearest_codes(codes, others), table.argmin(axis=1))
    assert _nearest_codes(others[[30]], others)[0] == 4
