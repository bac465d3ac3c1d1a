from itertools import pairwise

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from graft import zoo
from graft.contact.frames import _candidates, _cues, _faced, _search, align_parts
from graft.graph import build_graph
from graft.marking import mark_contact
from graft.objects import Part, PartObject

ROUNDNESS = 0.02
"""A turn that lands a rim point within this share of the diagonal has been found."""


def part(name, mesh):
    return Part(name, mesh.vertices, mesh.faces)


def moved(mesh, xyz):
    return mesh.apply_translation(xyz)


def alone(mesh, **kwargs):
    return PartObject("alone", (part("body", mesh),), **kwargs)


def dumbbell():
    """A symmetric bar along x with a knob at its far end only: its ends differ by their neighbour alone."""
    bar = trimesh.creation.box((0.30, 0.02, 0.03))
    return PartObject("bar", (part("bar", bar), part("knob", moved(trimesh.creation.box((0.06,) * 3), (0.17, 0, 0)))))


def bucket():
    """A round body with an arch whose centre is on its axis: only the arch's surface tells how it is turned."""
    body = trimesh.creation.cylinder(radius=0.1, height=0.2, sections=64)
    angles = np.linspace(0, np.pi, 25)
    joints = np.stack([0.1 * np.cos(angles), 0 * angles, 0.1 + 0.1 * np.sin(angles)], axis=1)
    bars = [trimesh.creation.cylinder(radius=0.006, segment=pair) for pair in pairwise(joints)]
    arch = trimesh.util.concatenate(bars)
    return PartObject("bucket", (part("body", body), part("arch", arch)), up=(0, 0, 1))


def rotated(obj, seed):
    rotation = trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3))
    return rotation, obj.transformed(rotation)


def align(a, b, index=0, *, seed=0):
    graphs = build_graph(a, descriptor=None), build_graph(b, descriptor=None, seed=seed)
    return align_parts(graphs[0], index, graphs[1], index, np.eye(len(a.parts)) / len(a.parts))


@pytest.mark.parametrize("category", ["mug", "handbag", "hammer", "kettle"])
def test_an_object_aligns_with_itself(category):
    obj = zoo.make(category, 0)
    for index in range(len(obj.parts)):
        pair = align(obj, obj, index)
        assert_allclose(pair.target.rotation, pair.source.rotation, atol=1e-9)
        assert pair.score == pytest.approx(0.0, abs=1e-6)
        assert pair.margin >= 0


@pytest.mark.parametrize("seed", range(6))
def test_the_neighbour_tells_the_ends_of_a_symmetric_bar_apart(seed):
    rotation, target = rotated(dumbbell(), seed)
    pair = align(dumbbell(), target)
    for x in (0.15, -0.15):
        end = np.array([x, 0.0, 0.0])
        carried = pair.target.to_object(pair.source.to_canonical(end))
        assert_allclose(carried, rotation[:3, :3] @ end, atol=1e-3)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("draw", [0, 1])
def test_the_surface_of_a_centred_handle_tells_how_a_bucket_is_turned(seed, draw):
    rotation, target = rotated(bucket(), seed)
    pair = align(bucket(), target, seed=draw)
    carried = pair.target.to_object(pair.source.to_canonical(np.array([0.1, 0.0, 0.1])))
    # The bucket is its own image after half a turn about its axis: either rim point below the arch is right.
    rim = np.array([[0.1, 0.0, 0.1], [-0.1, 0.0, 0.1]]) @ rotation[:3, :3].T
    diagonal = build_graph(target, descriptor=None).diagonal
    assert np.linalg.norm(carried - rim, axis=1).min() < ROUNDNESS * diagonal


def test_up_tells_a_standing_tube_from_its_reverse():
    cylinder = trimesh.creation.cylinder(radius=0.03, height=0.2)
    pair = align(alone(cylinder, up=(0, 0, 1)), alone(cylinder, up=(0, 0, -1)))
    top = np.array([0.0, 0.0, 0.1])
    assert_allclose(pair.target.to_object(pair.source.to_canonical(top)), -top, atol=0.01)


@pytest.mark.parametrize("draw", [0, 1])
def test_what_is_symmetric_is_ambiguous(draw):
    cylinder = trimesh.creation.cylinder(radius=0.03, height=0.2, sections=64)
    block = trimesh.creation.box((0.3, 0.2, 0.1))
    for mesh in (cylinder, block, trimesh.creation.icosphere(radius=0.1)):
        assert align(alone(mesh), alone(mesh), seed=draw).ambiguous
    assert align(alone(cylinder, up=(0, 0, 1)), alone(cylinder, up=(0, 0, 1)), seed=draw).ambiguous


@pytest.mark.parametrize("draw", [0, 1])
def test_what_is_not_symmetric_is_not_ambiguous(draw):
    for category in ("mug", "teapot", "jug", "pan"):
        obj = zoo.make(category, 0)
        pair = align(obj, obj, obj.part_index("handle"), seed=draw)
        assert not pair.ambiguous
        assert pair.margin > 0.1


@pytest.mark.parametrize(
    ("source", "target", "name"),
    [("kettle", "teapot", "body"), ("wine_bottle", "shampoo", "neck"), ("mug", "jug", "body")],
)
def test_the_search_finds_the_best_candidate_without_judging_them_all(source, target, name):
    a, b = zoo.make(source, 1), zoo.make(target, 1)
    graphs = build_graph(a, descriptor=None), build_graph(b, descriptor=None)
    i, j = a.part_index(name), b.part_index(name)
    plan = np.ones((len(a.parts), len(b.parts)))
    cues = _cues(graphs[0], i, graphs[1], j, _faced(graphs[0], i), plan, None)
    candidates = _candidates(graphs[1], j)
    best, scores = _search(cues, candidates)
    every = cues.scores(candidates)
    assert best == int(np.argmax(every <= every.min() + 1e-9))
    judged = np.isfinite(scores)
    assert judged.sum() < len(candidates)
    assert_allclose(scores[judged], every[judged], atol=1e-9)


def test_the_contact_tells_how_to_turn_what_nothing_else_does():
    """A stem alone on its axis says nothing of a turn; the bar it goes to has a jar on one side.

    Without the contact, the side of the stem that was taken may face the jar; with it, it never does.
    """
    stem = trimesh.creation.cylinder(radius=0.005, height=0.08)
    foot = moved(trimesh.creation.cylinder(radius=0.03, height=0.005), (0, 0, -0.0425))
    goblet = PartObject("goblet", (part("stem", stem), part("foot", foot)), up=(0, 0, 1))
    bar = moved(trimesh.creation.cylinder(radius=0.006, height=0.1), (0.07, 0, 0))
    vessel = trimesh.creation.cylinder(radius=0.05, height=0.15)
    jar = PartObject("jar", (part("bar", bar), part("jar", vessel)), up=(0, 0, 1))
    graphs = build_graph(goblet, descriptor=None), build_graph(jar, descriptor=None)
    without, given = [], []
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        place = 0.005 * np.array([np.cos(angle), np.sin(angle), 0.0])
        contact = mark_contact(goblet, "stem", place).contact
        for found, argument in ((without, None), (given, contact)):
            pair = align_parts(graphs[0], 0, graphs[1], 0, np.eye(2) / 2, argument)
            found.append(float((pair.target.rotation @ pair.source.directions(contact.normal))[0]))
    assert min(without) < -0.9
    assert min(given) > -0.75
