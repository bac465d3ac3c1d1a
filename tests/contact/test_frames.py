import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from graft import zoo
from graft.contact.canonical import CUBE_ROTATIONS, CanonicalFrame, box_frame
from graft.contact.frames import align_parts
from graft.graph import build_graph
from graft.objects import Part, PartObject


def part(name, mesh):
    return Part(name, mesh.vertices, mesh.faces)


def moved(mesh, xyz):
    return mesh.apply_translation(xyz)


def dumbbell():
    """A symmetric bar along x with a knob at its far end only: its ends differ by their neighbour alone."""
    bar = trimesh.creation.box((0.30, 0.02, 0.03))
    return PartObject("bar", (part("bar", bar), part("knob", moved(trimesh.creation.box((0.06,) * 3), (0.17, 0, 0)))))


def test_cube_rotations_are_the_24_proper_ones_identity_first():
    assert_allclose(CUBE_ROTATIONS[0], np.eye(3))
    assert len({tuple(r.ravel()) for r in CUBE_ROTATIONS}) == 24
    assert_allclose(np.linalg.det(CUBE_ROTATIONS), 1.0)
    changed = [(np.diag(r) != 1).sum() for r in CUBE_ROTATIONS]
    assert changed == sorted(changed)


def test_frames_map_there_and_back():
    graph = build_graph(zoo.make("kettle", 0), descriptor=None)
    for index in range(len(graph.object.parts)):
        frame = box_frame(graph, index)
        canonical = frame.to_canonical(graph.points[index])
        assert np.abs(canonical).max() <= 1 + 1e-9
        assert_allclose(frame.to_object(canonical), graph.points[index], atol=1e-12)


@pytest.mark.parametrize("category", ["mug", "handbag", "hammer", "kettle"])
def test_an_object_aligns_with_itself(category):
    graph = build_graph(zoo.make(category, 0), descriptor=None)
    plan = np.diag(graph.volumes / graph.volumes.sum())
    for index in range(len(graph.object.parts)):
        pair = align_parts(graph, index, graph, index, plan)
        assert_allclose(pair.target.rotation, pair.source.rotation, atol=1e-9)
        assert pair.score == pytest.approx(0.0, abs=1e-7)
        assert pair.margin >= 0


@pytest.mark.parametrize("seed", range(6))
def test_the_neighbour_tells_the_ends_of_a_symmetric_bar_apart(seed):
    rng = np.random.default_rng(seed)
    rotation = trimesh.transformations.random_rotation_matrix(rng.random(3))
    source = dumbbell()
    target = source.transformed(rotation)
    graphs = build_graph(source, descriptor=None), build_graph(target, descriptor=None)
    plan = np.diag([0.5, 0.5])
    pair = align_parts(graphs[0], 0, graphs[1], 0, plan)
    end = np.array([0.15, 0.0, 0.0])
    carried = pair.target.to_object(pair.source.to_canonical(end))
    assert_allclose(carried, rotation[:3, :3] @ end, atol=1e-3)


def test_up_tells_a_standing_tube_from_its_reverse():
    """A cone frustum alone: shape says which way; a cylinder alone: only up does."""
    cylinder = trimesh.creation.cylinder(radius=0.03, height=0.2)
    upright = PartObject("a", (part("body", cylinder),), up=(0, 0, 1))
    reversed_up = PartObject("b", (part("body", cylinder),), up=(0, 0, -1))
    a, b = build_graph(upright, descriptor=None), build_graph(reversed_up, descriptor=None)
    pair = align_parts(a, 0, b, 0, np.ones((1, 1)))
    top = np.array([0.0, 0.0, 0.1])
    assert_allclose(pair.target.to_object(pair.source.to_canonical(top)), -top, atol=0.01)


def test_directions_keep_their_length_under_a_distorting_box():
    frame = CanonicalFrame(np.eye(3), np.zeros(3), np.array([3.0, 2.0, 1.0]))
    assert_allclose(np.linalg.norm(frame.directions(np.eye(3)), axis=1), 1.0)
