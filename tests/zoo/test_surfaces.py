"""Curves and surfaces against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from graft.zoo.curves import loop, rectangle, resampled, rounded, smooth, spaced, spline, superellipse
from graft.zoo.surfaces import Mesh, facing, lathe, merged, ring, seated, side, slab, tube, turned, vessel


def volume(mesh: Mesh) -> float:
    return float(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume)


def polygon(count: int) -> float:
    """Return the area of a regular polygon with `count` corners on the unit circle."""
    return count / 2 * np.sin(2 * np.pi / count)


def test_lathe_of_a_rectangle_is_a_prism() -> None:
    mesh = lathe([(0.5, 0.0), (0.5, 2.0)], section=superellipse(40))
    # The section's corners are resampled by arc length along a finer polygon: not exactly on the circle.
    assert volume(mesh) == pytest.approx(polygon(40) * 0.25 * 2, rel=1e-3)


def test_ring_has_the_volume_of_pappus() -> None:
    section = superellipse(14, 0.05, 0.05, 2.6)
    x, y = section.T
    area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert volume(ring(1.0, 0.0, 0.1, 0.1)) == pytest.approx(2 * polygon(40) * area, rel=5e-3)


def test_straight_tube_has_the_volume_of_its_section_times_its_length() -> None:
    path = np.stack([np.linspace(0, 1, 20), np.zeros(20), np.zeros(20)], axis=1)
    mesh = tube(path, (0, 1, 0), 0.2, 0.1, dome=False)
    assert volume(mesh) == pytest.approx(polygon(20) * 0.1 * 0.05, rel=1e-2)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (1, 0.2, 0.1))


def test_bore_takes_volume_away() -> None:
    path = np.stack([np.linspace(0, 1, 20), np.zeros(20), np.zeros(20)], axis=1)
    solid = volume(tube(path, (0, 1, 0), 0.2, dome=False))
    bored = volume(tube(path, (0, 1, 0), 0.2, dome=False, bore=0.3))
    assert solid - bored == pytest.approx(polygon(20) * (0.1 * 0.74) ** 2 * 0.3, rel=2e-2)


def test_slab_reaches_exactly_its_outline_and_thickness() -> None:
    mesh = slab(rectangle(80, 0.2, 0.1, 0.02), 0.03, 0.005)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (0.2, 0.1, 0.03))
    assert mesh.vertices[:, 2].min() == 0


def test_vessel_has_a_wall_of_the_given_thickness_and_a_hollow() -> None:
    outline = side(0.1, (0.05, 0.05))
    mesh = vessel(outline, 0.004, 0.006)
    outer, inner = polygon(40) * 0.05**2, polygon(40) * 0.046**2
    assert volume(mesh) == pytest.approx(outer * 0.1 - inner * 0.094, rel=2e-2)
    level = np.abs(mesh.vertices[:, 2] - 0.05) < 0.01
    radii = np.linalg.norm(mesh.vertices[level, :2], axis=1)
    assert np.allclose(np.abs(radii - 0.048), 0.002, atol=3e-4)


def test_merged_meshes_keep_their_volumes() -> None:
    one = lathe([(0.1, 0.0), (0.1, 0.3)])
    assert volume(merged(one, one.moved((1, 0, 0)))) == pytest.approx(2 * volume(one))


def test_seated_handle_ends_in_the_wall() -> None:
    outline = side(0.1, (0.04, 0.05))
    path = loop((0.03, 0, 0.08), (0.03, 0, 0.02), (1, 0, 0), 0.04)
    mesh = seated(tube(path, (0, 1, 0), 0.012), outline, 0.002)
    radius = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    depth = np.interp(mesh.vertices[:, 2], outline[:, 1], outline[:, 0]) - radius
    assert depth.max() == pytest.approx(0.002, abs=1e-12)


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.1))
def test_facing_is_a_rotation_that_carries_z_to_the_direction(direction: list[float]) -> None:
    rotation = facing(direction)
    assert np.allclose(rotation @ rotation.T, np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert np.allclose(rotation[:, 2], np.array(direction) / np.linalg.norm(direction))


@given(st.floats(-3, 3))
def test_turned_about_z_turns_the_plane(angle: float) -> None:
    assert np.allclose(turned((0, 0, 2), angle) @ (1, 0, 0), (np.cos(angle), np.sin(angle), 0))


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=8))
def test_spline_goes_through_its_values_and_reproduces_lines(values: list[float]) -> None:
    at = np.linspace(0, 1, len(values))
    assert np.allclose(spline(values, at), values)
    line = 2 - 3 * at
    fine = np.linspace(0, 1, 33)
    assert np.allclose(spline(line, fine), 2 - 3 * fine)


@settings(max_examples=30)
@given(st.floats(1.6, 8), st.floats(0.3, 1))
def test_superellipse_is_centred_spans_its_axes_and_is_evenly_spaced(exponent: float, squeeze: float) -> None:
    points = superellipse(48, 1.0, squeeze, exponent)
    assert np.allclose(points.mean(axis=0), 0, atol=1e-9)
    assert points[:, 0].max() == pytest.approx(1, rel=1e-9)
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    assert steps.max() / steps.min() < 1.8


def test_loop_starts_and_ends_where_told_and_stands_off_by_its_depth() -> None:
    path = loop((0, 0, 1), (0, 0, 0), (1, 0, 0), 0.4, exponent=3.0)
    assert np.allclose(path[0], (0, 0, 1), atol=1e-9)
    assert np.allclose(path[-1], (0, 0, 0), atol=1e-9)
    assert path[:, 0].max() == pytest.approx(0.4, rel=1e-2)


def test_polylines_keep_corners_and_lengths() -> None:
    corner = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]
    fine = spaced(corner, 0.3)
    assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() <= 0.3
    assert (fine == (1.0, 0.0)).all(axis=1).any()
    assert np.allclose(np.linalg.norm(np.diff(resampled(corner, 5), axis=0), axis=1), 0.5)
    assert not (rounded(corner, 0.2) == (1.0, 0.0)).all(axis=1).any()
    assert np.allclose(smooth(corner, 9)[[0, -1]], (corner[0], corner[-1]))
