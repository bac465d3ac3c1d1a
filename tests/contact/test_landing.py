"""Where contacts land: ends, walls, symmetric, flat, lone and coincident parts, point clouds."""

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from graft import zoo
from graft.contact import dense_map, transfer_contact
from graft.graph import build_graph
from graft.library import match
from graft.marking import mark_contact
from graft.objects import Part, PartObject


def part(name, mesh):
    return Part(name, mesh.vertices, mesh.faces)


def moved(mesh, xyz):
    return mesh.apply_translation(xyz)


def rotation_of(seed):
    return trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3))


def assert_sound(found, result):
    """Everything finite, the normal of unit length, the transform a similarity that carries the contact."""
    dense = dense_map(found)
    for array in (result.contact.point, result.contact.normal, result.transform, dense.source_points, dense.heat):
        assert np.isfinite(array).all()
    assert np.isfinite(result.frames.score)
    assert result.frames.margin >= 0.0
    assert np.linalg.norm(result.contact.normal) == pytest.approx(1.0)
    demonstrated = found.demonstration.contact
    carried = result.transform @ [*demonstrated.point, 1.0]
    assert_allclose(carried[:3], result.contact.point, atol=1e-9 * found.target.diagonal)
    linear = result.transform[:3, :3]
    scale = np.cbrt(np.linalg.det(linear))
    assert_allclose(linear @ linear.T, scale**2 * np.eye(3), atol=1e-9 * scale**2)


def tool(length, head, width=0.02):
    """A bar along x with a head at its far end."""
    bar = trimesh.creation.box((length, width, 0.8 * width))
    at = (length / 2 + head / 2, 0, 0)
    return PartObject("tool", (part("bar", bar), part("head", moved(trimesh.creation.box((head, 3 * head, head)), at))))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [-0.4, 0.4])
def test_the_end_of_an_elongated_part_stays_the_end(seed, share):
    source, target = tool(0.3, 0.04), tool(0.2, 0.06, width=0.03)
    turn = rotation_of(seed)
    demonstration = mark_contact(source, "bar", (share * 0.3, 0.01, 0.0))
    result = transfer_contact(match(demonstration, target.transformed(turn)))
    along = float(result.contact.point @ turn[:3, 0])
    assert result.target_part == 0
    assert along / 0.2 == pytest.approx(share, abs=0.05)


def tube(radius, height, wall, sections=48):
    return trimesh.creation.annulus(r_min=radius - wall, r_max=radius, height=height, sections=sections)


@pytest.mark.parametrize("outer", [True, False])
def test_a_contact_stays_on_its_side_of_a_thin_wall(outer):
    """Two cups with handles; the wall is 2 % of the width, so its two sides are the same place but for the normal."""

    def cup(radius, height):
        handle = moved(trimesh.creation.box((0.03, 0.01, 0.5 * height)), (radius + 0.015, 0, 0))
        return PartObject(
            "cup", (part("wall", tube(radius, height, 0.04 * radius)), part("handle", handle)), up=(0, 0, 1)
        )

    place = np.array([-0.05 if outer else -0.048, 0.0, 0.01])
    demonstration = mark_contact(cup(0.05, 0.1), "wall", place)
    assert demonstration.contact.normal[0] * (-1 if outer else 1) > 0.9
    found = match(demonstration, cup(0.06, 0.09))
    result = transfer_contact(found)
    radial = result.contact.point * [1, 1, 0]
    outward = float(result.contact.normal @ radial) / np.linalg.norm(radial)
    assert outward > 0.9 if outer else outward < -0.9
    assert result.contact.point[0] < -0.05  # opposite the handle


@pytest.mark.parametrize("seed", range(4))
def test_a_contact_on_a_surface_of_revolution_returns_to_its_orbit(seed):
    """A turned bottle alone looks the same however it is turned about its axis.

    Any point of the contact's circle is right, so the distance to that circle is measured, and the normal's
    components along the axis and away from it. The copy is tessellated otherwise, so that no facet tells.
    """
    profile = np.array([[0, 0], [0.04, 0], [0.04, 0.12], [0.015, 0.16], [0.015, 0.22], [0, 0.22]])

    def bottle(sections):
        body = trimesh.creation.revolve([*profile[:4].tolist(), [0, 0.16]], sections=sections)
        neck = trimesh.creation.revolve([[0, 0.16], *profile[3:].tolist()], sections=sections)
        return PartObject("bottle", (part("body", body), part("neck", neck)), up=(0, 0, 1))

    demonstration = mark_contact(bottle(64), "body", (0.04, 0.0, 0.03))
    turn = rotation_of(seed)
    found = match(demonstration, bottle(90).transformed(turn))
    result = transfer_contact(found)
    assert result.target_part == 0
    assert result.frames.ambiguous
    point, normal = result.contact.point @ turn[:3, :3], result.contact.normal @ turn[:3, :3]
    orbit = np.hypot(np.hypot(point[0], point[1]) - 0.04, point[2] - 0.03)
    assert orbit < 0.01 * found.target.diagonal
    assert normal[:2] @ point[:2] / np.hypot(*point[:2]) > 0.98


def as_cloud(obj, count=600, normals=False):
    """The object as points, without faces."""
    parts = []
    for index, old in enumerate(obj.parts):
        mesh = trimesh.Trimesh(old.vertices, old.faces, process=False)
        points, faces = trimesh.sample.sample_surface(mesh, count, seed=index)
        parts.append(Part(old.name, points, normals=mesh.face_normals[faces] if normals else None))
    return PartObject(obj.name, tuple(parts), up=obj.up, scale_to_metres=obj.scale_to_metres)


@pytest.mark.parametrize("normals", [True, False])
def test_a_contact_lands_on_a_point_cloud(normals):
    demonstration = zoo.demonstration("mug", 0)
    cloud = as_cloud(demonstration.object, normals=normals)
    found = match(demonstration, cloud)
    result = transfer_contact(found)
    assert_sound(found, result)
    assert result.target_part == demonstration.contact.part
    offset = np.linalg.norm(result.contact.point - demonstration.contact.point)
    assert offset < 0.05 * found.target.diagonal  # samples are about 3 % apart
    assert result.contact.normal @ demonstration.contact.normal > 0.7


def test_flat_parts():
    sheet = Part("sheet", [[0, 0, 0], [0.3, 0, 0], [0.3, 0.2, 0], [0, 0.2, 0]], [[0, 1, 2], [0, 2, 3]])
    knob = part("knob", moved(trimesh.creation.box((0.02,) * 3), (0.28, 0.1, 0.02)))
    tray = PartObject("tray", (sheet, knob))
    demonstration = mark_contact(tray, "sheet", (0.05, 0.1, 0.0))
    for seed in range(3):
        turn = rotation_of(seed)
        found = match(demonstration, tray.transformed(turn))
        result = transfer_contact(found)
        assert_sound(found, result)
        assert_allclose(result.contact.point, turn[:3, :3] @ [0.05, 0.1, 0.0], atol=0.01 * found.target.diagonal)


@pytest.mark.parametrize(
    "obj",
    [
        PartObject("block", (part("all", trimesh.creation.box((0.3, 0.2, 0.1))),)),
        PartObject("cube", (part("all", trimesh.creation.box((0.1, 0.1, 0.1))),)),
        PartObject("ball", (part("all", trimesh.creation.icosphere(radius=0.1)),)),
        PartObject("one face", (Part("all", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),)),
        PartObject("three points", (Part("all", [[0, 0, 0], [1, 0, 0], [0, 1, 0]]),)),
        PartObject("one point", (Part("all", [[1.0, 2.0, 3.0]]),)),
    ],
    ids=lambda obj: obj.name,
)
def test_objects_of_a_single_part(obj):
    demonstration = zoo.demonstration("phone", 0)
    found = match(demonstration, obj)
    assert_sound(found, transfer_contact(found))


def test_parts_with_coincident_centres():
    shells = [trimesh.creation.icosphere(radius=r) for r in (0.1, 0.08, 0.06)]
    nested = PartObject("nested", tuple(part(f"shell{k}", mesh) for k, mesh in enumerate(shells)))
    for index in range(3):
        demonstration = mark_contact(nested, index, (0.0, 0.0, 0.2))
        found = match(demonstration, nested.transformed(rotation_of(index)))
        result = transfer_contact(found)
        assert_sound(found, result)
        assert result.frames.ambiguous
        found = match(zoo.demonstration("mug", 0), nested)
        assert_sound(found, transfer_contact(found))


def test_the_gripper_comes_from_outside():
    """The approach keeps its angle to the surface: it points into the side from which the demonstration came."""
    for source, target in (("mug", "kettle"), ("teapot", "watering_can"), ("water_bucket", "basket"), ("mug", "jug")):
        demonstration = zoo.demonstration(source, 0)
        result = transfer_contact(match(demonstration, zoo.make(target, 1)))
        before = float(demonstration.contact.approach @ demonstration.contact.normal)
        after = float(result.contact.approach @ result.contact.normal)
        assert before < -0.9
        assert after == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize("category", ["mug", "jug", "wine_bottle", "pan", "handbag", "scissors"])
def test_a_contact_returns_under_another_draw_of_the_samples(category):
    demonstration = zoo.demonstration(category, 1)
    turn = rotation_of(5)
    graph = build_graph(demonstration.object.transformed(turn), seed=3)
    result = transfer_contact(match(demonstration, graph))
    expected = demonstration.contact.transformed(turn)
    assert result.target_part == demonstration.contact.part
    assert np.linalg.norm(result.contact.point - expected.point) < 0.01 * graph.diagonal
