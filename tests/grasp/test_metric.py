"""Objects in metres, and the plane that they stand on."""

import numpy as np
import pytest

from graft.errors import InputError
from graft.grasp import Support, contact_in_metres, in_metres, metric_scale
from graft.objects import Contact, Joint, Part, PartObject

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2]])


def thing(scale=0.05, size=1.0, up=(0, 0, 1)):
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    parts = (Part("a", size * CORNERS, faces), Part("b", size * (CORNERS + np.array([2.0, 0, 1])), faces))
    joint = Joint(0, 1, "slide", "s", axis=(1, 0, 0), origin=(size, 0, 0), limits=(0.0, size))
    return PartObject("thing", parts, (joint,), up=up, scale_to_metres=scale)


def test_all_lengths_become_metres():
    metric = in_metres(thing())
    np.testing.assert_allclose(metric.bounds, 0.05 * thing().bounds)
    assert metric.scale_to_metres == 1.0
    assert metric.joints[0].limits == pytest.approx((0.0, 0.05))
    again = in_metres(metric)
    np.testing.assert_array_equal(again.bounds, metric.bounds)


def test_a_contact_goes_with_its_object():
    contact = contact_in_metres(Contact((1, 0, 0), (1, 0, 0), 0, approach=(-1, 0, 0)), thing())
    np.testing.assert_allclose(contact.point, (0.05, 0, 0))
    np.testing.assert_allclose(contact.normal, (1, 0, 0))
    np.testing.assert_allclose(contact.approach, (-1, 0, 0))


def test_an_object_that_does_not_say_is_in_metres():
    assert metric_scale(thing(None, 0.05)) == 1.0


@pytest.mark.parametrize(
    ("scale", "size", "message"),
    [
        (None, 50.0, "its unit is unknown and taken to be metres.*give scale_to_metres .0.001 for millimetres"),
        (0.001, 1e-1, "at 0.001 m a unit"),
        (1000.0, 1.0, "at 1000 m a unit"),
    ],
)
def test_a_size_that_no_gripper_takes_is_refused(scale, size, message):
    with pytest.raises(InputError, match=f"'thing': expected a diagonal of 0.005 to 5 m, got .*{message}"):
        in_metres(thing(scale, size))


def test_an_object_stands_on_its_lowest_point_along_its_up_axis():
    support = Support.below(in_metres(thing(up=(0, 1, 0))))
    np.testing.assert_allclose(support.normal, (0, 1, 0))
    assert support.offset == 0.0
    tilted = Support.below(in_metres(thing(up=(1, 0, 1))))
    heights = tilted.height(np.concatenate([part.vertices for part in in_metres(thing()).parts]))
    assert heights.min() == pytest.approx(0.0, abs=1e-15)
    assert Support.below(in_metres(thing(up=None))) is None


@pytest.mark.parametrize(
    ("normal", "offset", "message"),
    [((0, 0, 0), 0.0, "zero vector"), ((0, 0, 1), np.inf, "finite"), ((0, 1), 0.0, "shape")],
)
def test_a_plane_that_is_none_is_refused(normal, offset, message):
    with pytest.raises(InputError, match=message):
        Support(normal, offset)
