import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from graft import InputError, Part, PartObject, as_object, mark_contact, zoo
from graft.marking import closest_surface_point, middle_point

TORUS = trimesh.creation.torus(major_radius=0.04, minor_radius=0.008, major_sections=48, minor_sections=16)
coordinates = st.floats(-0.1, 0.1, allow_nan=False)


def part_of(mesh, name="handle"):
    return Part(name, mesh.vertices, mesh.faces)


def arch():
    """Half a torus: a handle whose middle, as the mean of its points, is empty space; open at both ends."""
    keep = TORUS.triangles_center[:, 0] > 0
    return part_of(trimesh.Trimesh(TORUS.vertices, TORUS.faces[keep], process=False))


def cup():
    body = trimesh.creation.cylinder(radius=0.03, height=0.1, sections=48)
    body.apply_translation((-0.03, 0, 0))
    return PartObject("cup", (part_of(body, "body"), arch()))


@given(st.tuples(coordinates, coordinates, coordinates))
@settings(max_examples=60, deadline=None)
def test_as_close_as_trimesh_finds(point):
    place, normal, distance = closest_surface_point(part_of(TORUS), point)
    _, theirs, _ = trimesh.proximity.closest_point_naive(TORUS, [point])
    assert distance == pytest.approx(theirs[0], abs=1e-12)
    assert np.linalg.norm(place - point) == pytest.approx(distance, abs=1e-12)
    assert np.linalg.norm(normal) == pytest.approx(1)


def test_corners_edges_and_faces():
    box = part_of(trimesh.creation.box((2, 2, 2)))
    for point, place in (
        ((3, 0.2, 0.1), (1, 0.2, 0.1)),
        ((3, 3, 0.1), (1, 1, 0.1)),
        ((3, 3, -3), (1, 1, -1)),
    ):
        found, normal, _ = closest_surface_point(box, point)
        assert_allclose(found, place)
        assert normal @ np.subtract(point, place) > 0
    # On a corner six triangles tie: the lowest face wins, whatever the rounding.
    same = [closest_surface_point(box, np.array((1, 1, 1)) * (1 + e))[1].tolist() for e in (0, 1e-15, 1e-14)]
    assert same[0] == same[1] == same[2]


def test_normals_point_outwards_also_where_the_winding_does_not():
    mesh = trimesh.creation.icosphere()
    for faces in (mesh.faces, mesh.faces[:, ::-1]):
        _, normal, _ = closest_surface_point(Part("ball", mesh.vertices, faces), (3, 0, 0))
        assert normal[0] > 0.9


def test_the_middle_of_a_bent_bar_is_on_the_bar():
    obj = cup()
    point = middle_point(obj, "handle")
    # The axis of the bar is the half circle of radius 0.04 about the origin, its middle is at (0.04, 0, 0).
    assert np.hypot(np.hypot(point[0], point[1]) - 0.04, point[2]) == pytest.approx(0.008, rel=0.05)
    assert abs(np.arctan2(point[1], point[0])) < 0.2
    contact = mark_contact(obj, "handle").contact
    assert contact.part == 1
    assert closest_surface_point(obj.parts[1], contact.point)[2] < 1e-9
    assert contact.normal[0] > 0.8  # away from the cup


def test_the_middle_moves_with_the_object():
    obj = cup()
    turn = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3)) @ np.diag([2.0, 2.0, 2.0, 1.0])
    expected = turn[:3, :3] @ mark_contact(obj, 1).contact.point + turn[:3, 3]
    found = mark_contact(obj.transformed(turn), 1).contact.point
    assert np.linalg.norm(found - expected) < 0.01 * 2 * 0.12


def test_marking_is_deterministic():
    assert mark_contact(cup(), 1).contact.point.tolist() == mark_contact(cup(), 1).contact.point.tolist()


def test_a_point_is_snapped_to_its_part():
    obj = cup()
    demo = mark_contact(obj, "handle", (0.06, 0, 0), approach=(-2, 0, 0), name="mine", metadata={"by": "me"})
    assert_allclose(demo.contact.point, [0.048, 0, 0], atol=1e-9)
    assert demo.contact.normal[0] > 0.9
    assert demo.contact.approach.tolist() == [-1, 0, 0]
    assert demo.name == "mine"
    assert demo.metadata == {"by": "me"}
    assert demo.object is obj


def test_clouds():
    points = np.random.default_rng(0).normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for normals in (points, None):
        ball = Part("ball", points, normals=normals)
        place, normal, distance = closest_surface_point(ball, (0, 0, 3))
        index = int(np.argmin(np.linalg.norm(points - (0, 0, 3), axis=1)))
        assert place.tolist() == points[index].tolist()
        assert normal @ place > 0.95
        assert distance == pytest.approx(np.linalg.norm(place - (0, 0, 3)))
        contact = mark_contact(PartObject("ball", (ball,)), 0).contact
        assert contact.normal @ contact.point > 0.9


def test_tiny_parts():
    triangle = as_object(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    contact = mark_contact(triangle, 0).contact
    assert contact.normal.tolist() == [0, 0, 1]
    assert contact.point[2] == 0
    single = PartObject("point", (Part("p", [[1, 2, 3]]),))
    assert mark_contact(single, 0).contact.point.tolist() == [1, 2, 3]


def test_refusals():
    obj = cup()
    with pytest.raises(InputError, match=r"no part called 'lid'; the parts are body, handle"):
        mark_contact(obj, "lid")
    with pytest.raises(InputError, match="part index 2 out of range"):
        mark_contact(obj, 2)
    with pytest.raises(InputError, match=r"point: \[48, 0, 0\] is 47.95 away from part 'handle'"):
        mark_contact(obj, "handle", (48, 0, 0))
    for point in ((0, 0), (0, 0, np.nan), "x"):
        with pytest.raises(InputError, match="point: expected three"):
            mark_contact(obj, "handle", point)
    with pytest.raises(InputError, match="approach"):
        mark_contact(obj, "handle", approach=(0, 0, 0))


def test_the_middle_of_a_handle_that_points_away_from_the_object():
    head = part_of(trimesh.creation.box((0.1, 0.03, 0.03)), "head")
    bar = trimesh.creation.cylinder(radius=0.012, height=0.12).subdivide()
    bar.apply_translation((0.01, 0, -0.075))
    obj = PartObject("hammer", (head, part_of(bar)))
    contact = mark_contact(obj, "handle").contact
    assert contact.point[2] == pytest.approx(-0.075, abs=0.006)
    assert abs(contact.normal[2]) < 0.1


@pytest.mark.parametrize("category", ["wine_bottle", "shampoo", "flashlight"])
def test_the_middle_of_an_upright_body_is_on_its_wall(category):
    for seed in range(3):
        obj = zoo.make(category, seed)
        contact = mark_contact(obj, "body").contact
        long_axis = np.ptp(obj.parts[contact.part].vertices, axis=0).argmax()
        assert abs(contact.normal[long_axis]) < 0.5, "not on the base or the top"
        low, high = (
            obj.parts[contact.part].vertices[:, long_axis].min(),
            obj.parts[contact.part].vertices[:, long_axis].max(),
        )
        assert 0.2 < (contact.point[long_axis] - low) / (high - low) < 0.8
