import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from graft import zoo
from graft.contact import transfer_contact
from graft.contact.transfer import _shortest_turn
from graft.library import match
from graft.marking import closest_surface_point

CATEGORIES = zoo.categories()
RETURN_TOLERANCE = 0.01
"""A contact carried onto its own object comes back to within this share of the diagonal."""


def random_similarity(seed):
    rng = np.random.default_rng(seed)
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation = q * np.sign(np.diag(r))
    if np.linalg.det(rotation) < 0:
        rotation[:, 0] *= -1
    transform = np.eye(4)
    transform[:3, :3] = rng.uniform(0.3, 3.0) * rotation
    transform[:3, 3] = rng.normal(size=3)
    return transform


@pytest.mark.parametrize("category", CATEGORIES)
def test_contact_returns_to_its_own_object(category):
    demonstration = zoo.demonstration(category, 1)
    found = match(demonstration, demonstration.object)
    result = transfer_contact(found)
    assert result.target_part == demonstration.contact.part
    offset = np.linalg.norm(result.contact.point - demonstration.contact.point)
    assert offset < RETURN_TOLERANCE * found.target.diagonal


@pytest.mark.parametrize("category", CATEGORIES)
def test_contact_follows_a_turned_and_scaled_copy(category):
    demonstration = zoo.demonstration(category, 2)
    transform = random_similarity(7)
    found = match(demonstration, demonstration.object.transformed(transform))
    result = transfer_contact(found)
    expected = demonstration.contact.transformed(transform)
    assert result.target_part == demonstration.contact.part
    assert np.linalg.norm(result.contact.point - expected.point) < RETURN_TOLERANCE * found.target.diagonal
    # The gripper comes from the same side: the transform is the copy's rotation.
    assert_allclose(result.contact.normal, expected.normal, atol=0.05)


@pytest.mark.parametrize("target", ["kettle", "handbag", "spray"])
def test_transfer_lands_on_the_surface_and_its_transform_agrees(target):
    demonstration = zoo.demonstration("mug", 3)
    found = match(demonstration, zoo.make(target, 4))
    result = transfer_contact(found)
    part = found.target.object.parts[result.target_part]
    _, _, distance = closest_surface_point(part, result.contact.point)
    assert distance < 1e-9 * found.target.diagonal + 1e-12

    carried = demonstration.contact.transformed(result.transform)
    assert_allclose(carried.point, result.contact.point, atol=1e-9)
    assert_allclose(carried.normal, result.contact.normal, atol=1e-9)
    rotation = result.transform[:3, :3]  # both objects are in metres
    assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) > 0
    assert 0.0 <= result.confidence <= result.share <= 1.0


def test_units_go_into_the_transform():
    demonstration = zoo.demonstration("mug", 0)
    millimetres = demonstration.object.transformed(np.diag([1000.0, 1000.0, 1000.0, 1.0]))
    result = transfer_contact(match(demonstration, millimetres))
    assert np.cbrt(np.linalg.det(result.transform[:3, :3])) == pytest.approx(1000.0)


unit = st.tuples(*[st.floats(-1, 1) for _ in range(3)]).filter(lambda v: np.linalg.norm(v) > 0.1)


@given(start=unit, end=unit)
def test_shortest_turn(start, end):
    a, b = np.array(start) / np.linalg.norm(start), np.array(end) / np.linalg.norm(end)
    turn = _shortest_turn(a, b)
    assert_allclose(turn @ a, b, atol=1e-7)
    assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    # No turn that takes a to b is smaller: its angle is the angle between them.
    assert (np.trace(turn) - 1) / 2 == pytest.approx(float(a @ b), abs=1e-6)


def test_shortest_turn_of_opposite_directions():
    for axis in np.eye(3):
        turn = _shortest_turn(axis, -axis)
        assert_allclose(turn @ axis, -axis, atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
