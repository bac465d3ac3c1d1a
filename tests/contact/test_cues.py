import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from graft import zoo
from graft._core import chamfer_distances
from graft.contact.canonical import CanonicalFrame, CanonicalFrames, box_frame, turns_about
from graft.contact.cues import Cues, View, companion
from graft.graph import build_graph
from graft.objects import Part, PartObject


def part(name, mesh):
    return Part(name, mesh.vertices, mesh.faces)


def own_cues(graph, index):
    """The cues of an object against itself, without a plan and without a contact."""
    frame = box_frame(graph, index)
    view = View.of(graph, index)
    none = np.zeros((len(graph), len(graph)))
    return frame, Cues(frame.half_extents, view.within(frame), view, none, None)


def test_chamfer_is_the_mean_of_the_brute_force_distances():
    rng = np.random.default_rng(0)
    cloud, candidates = rng.normal(size=(7, 3)), rng.normal(size=(4, 9, 3))
    found = chamfer_distances(cloud, candidates)
    for distance, other in zip(found, candidates, strict=True):
        table = np.linalg.norm(cloud[:, None] - other[None], axis=2)
        assert distance == pytest.approx((table.min(axis=0).mean() + table.min(axis=1).mean()) / 2)


@pytest.mark.parametrize("category", ["mug", "kettle", "phone", "scissors"])
def test_an_object_scores_zero_against_itself(category):
    graph = build_graph(zoo.make(category, 0), descriptor=None)
    for index in range(len(graph)):
        frame, cues = own_cues(graph, index)
        assert cues.scores(CanonicalFrames.of([frame]))[0] == pytest.approx(0.0, abs=1e-6)


def test_distances_are_never_negative():
    """The pruning of the search rests on it: the quick score bounds the whole one from below."""
    graph = build_graph(zoo.make("teapot", 0), descriptor=None)
    frame, cues = own_cues(graph, 0)
    assert (cues.dear(CanonicalFrames.of([frame]).permuted()) >= 0).all()


def handle_over_plate():
    """A bar one unit above a plate, and nothing on its other side."""
    plate = trimesh.creation.box((2.0, 2.0, 0.1))
    bar = trimesh.creation.box((1.0, 0.1, 0.1)).apply_translation((0, 0, 1.0))
    return build_graph(PartObject("o", (part("plate", plate), part("bar", bar))), descriptor=None)


def test_outlook_is_the_share_of_the_surroundings_in_the_cone():
    graph = handle_over_plate()
    view = View.of(graph, 1)
    points = np.array([[0.0, 0, 0.95], [0.0, 0, 1.05], [0.0, 0.05, 1.0]])
    normals = np.array([[0.0, 0, -1], [0.0, 0, 1], [0.0, 1, 0]])
    inner, outer, side = view.outlook(points, normals)
    # The cone of 45 degrees meets the plate, a unit below, in a circle of radius .9: pi .81 / 4 of its two faces.
    assert inner == pytest.approx(np.pi * 0.81 / 4, abs=0.1)
    assert outer == 0.0
    assert side < 0.1


def test_outlook_of_a_part_alone_is_zero():
    graph = build_graph(PartObject("o", (part("bar", trimesh.creation.box((3.0, 2.0, 1.0))),)), descriptor=None)
    assert_allclose(View.of(graph, 0).outlook(np.zeros((2, 3)), np.eye(3)[:2]), 0.0)
    assert_allclose(companion(graph, 0), 0.0)


def test_closest_points_turn_a_frame_back():
    graph = build_graph(zoo.make("mug", 0), descriptor=None)
    handle = graph.object.part_index("handle")
    frame, cues = own_cues(graph, handle)
    turn = turns_about(0, np.array([0.1]))[0]
    off = CanonicalFrame(frame.rotation @ turn, frame.center, frame.half_extents)
    for _ in range(30):
        off = CanonicalFrame(cues.closest_turn(off), frame.center, frame.half_extents)
        assert_allclose(off.rotation @ off.rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(off.rotation) > 0
    assert_allclose(off.rotation, frame.rotation, atol=1e-3)
