"""What objects, parts, joints and contacts accept, what they refuse by name, and how they move."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.objects import Contact, Demonstration, Joint, Part, PartObject, joint_pairs, unique_names

TRIANGLE = np.eye(3)


def make_part(**changes) -> Part:
    return Part(**{"name": "a", "vertices": TRIANGLE, "faces": [[0, 1, 2]], **changes})


def make_object(**changes) -> PartObject:
    parts = (make_part(), make_part(name="b", label="lid"), make_part(name="c", label="lid"))
    return PartObject(**{"name": "o", "parts": parts, **changes})


def similarity(scale: float, seed: int = 0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = scale * Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    matrix[:3, 3] = scale * np.array([1.0, -2.0, 0.5])
    return matrix


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": ""}, "part name: expected a name"),
        ({"vertices": np.empty((0, 3))}, "part 'a' vertices: expected at least one"),
        ({"vertices": np.zeros((3, 2))}, r"part 'a' vertices: expected shape \(n, 3\), got \(3, 2\)"),
        ({"vertices": "corners"}, "part 'a' vertices: expected an array of numbers, got str"),
        ({"vertices": [[0, 0, np.nan]] * 3}, r"part 'a' vertices: expected finite numbers, got nan at \[0, 2\]"),
        ({"faces": [[0.0, 1.0, 2.0]]}, "part 'a' faces: expected integers, got float64"),
        ({"faces": [[0, 1, 2], [0, 1, 3]]}, r"part 'a' face 1: vertex index out of range, \[0, 1, 3\] of 3"),
        ({"faces": [[0, 1, -1]]}, "part 'a' face 0: vertex index out of range"),
        ({"normals": np.zeros((2, 3))}, r"part 'a' normals: expected shape \(3, 3\)"),
    ],
)
def test_bad_parts_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        make_part(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parts": ()}, "object 'o': expected at least one part"),
        ({"parts": (make_part(), make_part())}, "object 'o': duplicate part name 'a'"),
        ({"graspable": (3,)}, "object 'o' graspable: part index 3 out of range, the object has 3 parts"),
        ({"joints": (Joint(5, 0, name="j"),)}, "object 'o' joint 'j' parent: part index 5"),
        ({"joints": (Joint(0, -1, name="j"),)}, "object 'o' joint 'j' child: part index -1"),
        ({"up": np.zeros(3)}, "object 'o' up: expected a direction, got the zero vector"),
        ({"up": np.ones(2)}, r"object 'o' up: expected shape \(3\)"),
        ({"scale_to_metres": 0.0}, "object 'o' scale_to_metres: expected a positive number, got 0.0"),
        ({"scale_to_metres": np.inf}, "object 'o' scale_to_metres: expected a positive number, got inf"),
    ],
)
def test_bad_objects_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        make_object(**changes)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Joint(0, 1, kind="screw", name="j"), "joint 'j' kind: expected one of fixed, .*, got 'screw'"),
        (lambda: Joint(0, 1, name="j", axis=np.zeros(3)), "joint 'j' axis: expected a direction"),
        (lambda: Joint(0, 1, name="j", origin=np.zeros(2)), "joint 'j' origin: expected shape"),
        (lambda: Contact(np.zeros(3), np.zeros(3), 0), "contact normal: expected a direction"),
        (lambda: Contact(np.full(3, np.inf), np.ones(3), 0), "contact point: expected finite numbers"),
        (lambda: Contact(np.zeros(3), np.ones(3), 0, np.zeros(3)), "contact approach: expected a direction"),
        (lambda: Demonstration(make_object(), Contact(np.zeros(3), np.ones(3), 7)), "part index 7 out of range"),
    ],
)
def test_bad_joints_contacts_and_demonstrations_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_parts_are_found_by_index_name_and_unique_label():
    found = make_object()
    assert [found.part_index(key) for key in (1, "c", np.int64(2))] == [1, 2, 2]
    with pytest.raises(InputError, match="2 parts called 'lid'; the parts are a, b, c"):
        found.part_index("lid")
    with pytest.raises(InputError, match="no part called 'spout'; the parts are a, b, c"):
        found.part_index("spout")
    with pytest.raises(InputError, match="part index 3 out of range"):
        found.part_index(3)


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1.0, 1e6, 1e9])
def test_similarities_of_any_scale_move_everything_along(scale):
    joints = (Joint(0, 1, "slide", "rail", axis=[0, 0, 2.0], origin=[1, 0, 0], limits=(0.0, 2.0)),)
    still = make_object(joints=joints, up=[0, 0, 1], scale_to_metres=0.5)
    matrix = similarity(scale)
    moved = still.transformed(matrix)
    rotation = matrix[:3, :3] / scale
    assert_allclose(moved.parts[0].vertices, TRIANGLE @ matrix[:3, :3].T + matrix[:3, 3], rtol=1e-12)
    assert_allclose(moved.up, rotation[:, 2], atol=1e-12)
    assert_allclose(moved.joints[0].axis, rotation[:, 2], atol=1e-12)
    assert_allclose(moved.joints[0].origin, matrix[:3, 0] + matrix[:3, 3], rtol=1e-12)
    assert_allclose(moved.joints[0].limits, (0.0, 2.0 * scale))
    assert_allclose(moved.scale_to_metres, 0.5 / scale)
    contact = Contact([1, 0, 0], [1, 0, 0], 0, approach=[0, 1, 0]).transformed(matrix)
    assert_allclose(contact.normal, rotation[:, 0], atol=1e-12)
    assert_allclose(contact.approach, rotation[:, 1], atol=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(
    "flaw", [np.diag([1, 1, -1.0]), np.diag([1, 1, 1.001]), np.array([[1, 1e-3, 0], [0, 1, 0], [0, 0, 1]])]
)
def test_mirrors_stretches_and_shears_are_refused_at_any_scale(scale, flaw):
    matrix = similarity(scale)
    matrix[:3, :3] = matrix[:3, :3] @ flaw
    with pytest.raises(InputError, match="transform: expected a rotation"):
        make_object().transformed(matrix)


def test_transforms_without_scale_or_of_another_shape_are_refused():
    with pytest.raises(InputError, match="transform: expected a rotation"):
        make_object().transformed(np.zeros((4, 4)))
    with pytest.raises(InputError, match=r"transform: expected shape \(4, 4\)"):
        make_object().transformed(np.eye(3))


def test_cloud_normals_turn_without_growing():
    normals = np.eye(3)
    cloud = PartObject("o", (Part("a", TRIANGLE, normals=normals),)).transformed(similarity(1e-3))
    assert cloud.parts[0].is_point_cloud
    assert_allclose(np.linalg.norm(cloud.parts[0].normals, axis=1), 1.0)


def test_arrays_are_copies_that_cannot_be_written():
    vertices = TRIANGLE.copy()
    part = make_part(vertices=vertices)
    vertices[0] = 9.0
    assert_allclose(part.vertices, TRIANGLE)
    with pytest.raises(ValueError, match="read-only"):
        part.vertices[0] = 1.0


def test_repeated_names_are_numbered_and_joints_listed_as_pairs():
    assert unique_names(["leg", "leg_2", "leg", "leg"]) == ("leg", "leg_2", "leg_3", "leg_4")
    assert joint_pairs((Joint(0, 1), Joint(1, 2))).tolist() == [[0, 1], [1, 2]]
    assert joint_pairs(()).shape == (0, 2)
