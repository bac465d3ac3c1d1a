"""The ray caster through the border, against closed forms."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from graft import _core
from graft.viz.camera import fit, look_from
from graft.viz.picture import draw_shapes
from graft.viz.shapes import Shape, rod, sphere

RED, BLUE = (200, 0, 0), (0, 0, 200)


def flat_camera(size, scale):
    """x to the right, y up, the viewer at +z."""
    shift = [[size / 2], [size / 2], [0.0]]
    return np.hstack([scale * np.diag([1.0, -1.0, -1.0]), shift])


def covered(pixels):
    return (pixels != 255).any(axis=2)


def test_a_spheres_silhouette_has_the_area_of_its_disc():
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=0.8)
    pixels = draw_shapes([Shape("ball", mesh.vertices, mesh.faces, BLUE)], flat_camera(300, 150.0), 300, 300)
    disc = np.pi * (0.8 * 150) ** 2
    # A pixel that is partly covered counts in full: half a pixel along the rim too much.
    assert covered(pixels).sum() == pytest.approx(disc, rel=0.01)


def test_a_cloud_is_drawn_as_balls_of_its_radius():
    points = Shape("points", np.array([[-0.5, 0, 0], [0.5, 0, 0.0]]), np.empty((0, 3), np.int64), RED, 0.2)
    pixels = draw_shapes([points], flat_camera(200, 100.0), 200, 200)
    assert covered(pixels).sum() == pytest.approx(2 * np.pi * 20**2, rel=0.06)
    assert covered(pixels)[100, 50]
    assert covered(pixels)[100, 150]
    assert not covered(pixels)[100, 100]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_box_hides_the_farther(order):
    near = trimesh.creation.box(extents=(0.5, 0.5, 0.2)).apply_translation((0, 0, 1.0))
    far = trimesh.creation.box(extents=(1.5, 1.5, 0.2))
    shapes = [Shape("near", near.vertices, near.faces, RED), Shape("far", far.vertices, far.faces, BLUE)]
    pixels = draw_shapes([shapes[i] for i in order], flat_camera(100, 50.0), 100, 100)
    assert pixels[50, 50, 0] > pixels[50, 50, 2] + 80
    assert pixels[50, 18, 2] > pixels[50, 18, 0] + 80
    assert (pixels[2, 2] == 255).all()


@given(seed=st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_rays_meet_a_sphere_where_the_quadratic_says(seed):
    rng = np.random.default_rng(seed)
    vertices, faces = sphere(1.0)
    origins = 3.0 * rng.normal(size=(50, 3))
    directions = -origins + rng.normal(size=(50, 3))
    distances = _core.cast_rays(vertices, faces, origins, directions)
    a = (directions**2).sum(axis=1)
    b = (origins * directions).sum(axis=1)
    closest = np.linalg.norm(origins - directions * (b / a)[:, None], axis=1)
    outside = np.linalg.norm(origins, axis=1) > 1.05
    surely_hit, surely_missed = outside & (closest < 0.95) & (b < 0), closest > 1.0
    assert np.isfinite(distances[surely_hit]).all()
    assert np.isinf(distances[surely_missed]).all()
    expected = (-b - np.sqrt(np.maximum(b**2 - a * ((origins**2).sum(axis=1) - 1.0), 0.0))) / a
    # The polyhedron lies inside the sphere by up to 3 % of its radius, more along slanting rays.
    steep = surely_hit & (closest < 0.5)
    off = (distances - expected)[steep] * np.sqrt(a)[steep]
    assert ((off > -1e-9) & (off < 0.06)).all()


def test_meshes_made_here_are_closed_and_look_outward():
    for vertices, faces in (sphere(0.3), rod(np.zeros(3), np.array([1.0, 2.0, 2.0]), 0.1)):
        mesh = trimesh.Trimesh(vertices, faces)
        mesh.merge_vertices()
        assert mesh.is_watertight
        assert mesh.volume > 0


@given(azimuth=st.floats(0, 360), elevation=st.floats(-89, 89), seed=st.integers(0, 99))
@settings(max_examples=50, deadline=None)
def test_cameras_are_rotations_and_keep_everything_in_the_frame(azimuth, elevation, seed):
    rng = np.random.default_rng(seed)
    up = rng.normal(size=3)
    up /= np.linalg.norm(up)
    rotation = look_from(azimuth, elevation, up)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) > 0
    assert rotation[0] @ up == pytest.approx(0.0, abs=1e-9)
    assert rotation[1] @ up < 0, "up is up in the picture"
    points = rng.normal(size=(30, 3)) * rng.uniform(0.01, 100)
    camera = fit(rotation, points, 300, 200)
    seen = points @ camera[:2, :3].T + camera[:2, 3]
    assert (seen >= 0).all()
    assert (seen <= (300, 200)).all()


def test_bad_arrays_are_named():
    empty = {
        "vertices": np.empty((0, 3)),
        "faces": np.empty((0, 3), np.int64),
        "face_groups": np.empty(0, np.int64),
        "centers": np.zeros((1, 3)),
        "radii": np.ones(1),
        "center_groups": np.zeros(1, np.int64),
        "colors": np.zeros((1, 3), np.uint8),
        "camera": flat_camera(10, 1.0),
        "width": 10,
        "height": 10,
    }
    assert _core.render_scene(**empty).shape == (10, 10, 4)
    for name, value in [
        ("vertices", np.full((1, 3), np.nan)),
        ("vertices", np.zeros((1, 2))),
        ("faces", np.zeros((1, 3), np.int64)),
        ("center_groups", np.ones(1, np.int64)),
        ("radii", np.zeros(1)),
        ("camera", np.zeros((3, 4))),
        ("width", 0),
        ("height", 10**6),
    ]:
        with pytest.raises(ValueError, match=name):
            _core.render_scene(**{**empty, name: value})
    with pytest.raises(ValueError, match="directions"):
        _core.cast_rays(np.zeros((3, 3)), np.zeros((1, 3), np.int64), np.zeros((1, 3)), np.zeros((1, 3)))
