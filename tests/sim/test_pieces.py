"""Convex pieces cover the surface, leave cavities and handles open; masses against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from sim_scenes import box, mesh_object

from graft import zoo
from graft.objects import Floats, Part, PartObject
from graft.sim.pieces import collision_pieces, hull_corners, mass_properties


def outside(points: Floats, pieces: tuple[Floats, ...]) -> Floats:
    """Return how far points (p, 3) lie outside all pieces; negative inside one."""
    planes = [ConvexHull(piece).equations for piece in pieces]
    gaps: Floats = np.min([(points @ e[:, :3].T + e[:, 3]).max(axis=1) for e in planes], axis=0)
    return gaps


@pytest.mark.parametrize("category", zoo.categories())
def test_pieces_cover_the_surface_of_zoo_objects(category: str) -> None:
    obj = zoo.make(category, 1)
    assert all(part.sweeps for part in obj.parts)
    pieces = collision_pieces(obj)
    assert len(pieces) < 300
    gaps = outside(np.vstack([part.vertices[::17] for part in obj.parts]), pieces)
    assert gaps.max() < 1.3e-3


@pytest.mark.parametrize(("category", "height"), [("mug", 0.6), ("water_bucket", 0.5), ("pan", 0.7), ("jug", 0.5)])
def test_vessels_stay_open(category: str, height: float) -> None:
    for seed in range(3):
        obj = zoo.make(category, seed)
        body = obj.parts[obj.part_index("body")]
        low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
        axis = np.array([0.0, 0.0, low[2] + height * (high[2] - low[2])])
        assert outside(axis[None], collision_pieces(obj))[0] > 0.015


def test_handles_stay_open() -> None:
    for seed in range(6):
        shown = zoo.demonstration("mug", seed)
        obj = shown.object
        handle = obj.parts[obj.part_index("handle")].vertices
        body = obj.parts[obj.part_index("body")].vertices
        # Midway between the wall and where the handle is held, a finger finds room.
        hole = np.array([(body[:, 0].max() + handle[:, 0].max()) / 2 - 0.003, 0.0, handle[:, 2].mean()])
        assert outside(hole[None], collision_pieces(obj))[0] > 0.003


def test_pieces_follow_the_object() -> None:
    obj = zoo.make("mug", 3)
    turn = np.eye(4)
    turn[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    turn[:3, 3] = (1, 2, 3)
    moved = collision_pieces(obj.transformed(turn))
    for piece, other in zip(collision_pieces(obj), moved, strict=True):
        there = piece @ turn[:3, :3].T + turn[:3, 3]
        assert np.allclose(there.mean(axis=0), other.mean(axis=0), atol=1e-6)


def test_convex_parts_are_their_hull() -> None:
    pieces = collision_pieces(box(0.1, 0.2, 0.3))
    assert len(pieces) == 1
    assert len(pieces[0]) == 8


def test_flat_points_have_no_hull() -> None:
    assert hull_corners(np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])) is None


def test_mass_of_a_box_and_of_two() -> None:
    obj = box(0.1, 0.2, 0.3)
    volume, center, inertia = mass_properties(obj, collision_pieces(obj))
    assert volume == pytest.approx(0.006)
    assert np.allclose(center, (0, 0, 0.15))
    assert np.allclose(inertia, np.diag([0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2]) / 12)
    far = trimesh.creation.box((0.1, 0.2, 0.3))
    far.apply_translation((1.0, 0, 0.15))
    near = trimesh.creation.box((0.1, 0.2, 0.3))
    near.apply_translation((0, 0, 0.15))
    two = mesh_object("two", near, far)
    volume, center, inertia = mass_properties(two, collision_pieces(two))
    assert volume == pytest.approx(0.012)
    assert np.allclose(center, (0.5, 0, 0.15))
    assert inertia[2, 2] == pytest.approx((0.1**2 + 0.2**2) / 12 + 0.25)


def test_an_open_surface_takes_its_mass_from_its_pieces() -> None:
    whole = box(0.1, 0.1, 0.1)
    part = whole.parts[0]
    lidless = PartObject("lidless", (Part("a", part.vertices, part.faces[:-2]),), scale_to_metres=1.0)
    expected = mass_properties(whole, collision_pieces(whole))
    found = mass_properties(lidless, collision_pieces(lidless))
    assert found[0] == pytest.approx(expected[0])
    assert np.allclose(found[2], expected[2])
