import numpy as np
import pytest
import trimesh

from graft.io import primitives

SHAPES = {
    "box": (primitives.box((1.0, 2.0, 3.0)), 48.0, (1.0, 2.0, 3.0)),
    "sphere": (primitives.sphere(1.5), 4 / 3 * np.pi * 1.5**3, (1.5, 1.5, 1.5)),
    "ellipsoid": (primitives.ellipsoid((1.0, 2.0, 3.0)), 4 / 3 * np.pi * 6, (1.0, 2.0, 3.0)),
    "cylinder": (primitives.cylinder(0.5, 2.0), np.pi * 0.25 * 4, (0.5, 0.5, 2.0)),
    "capsule": (primitives.capsule(0.5, 2.0), np.pi * 0.25 * 4 + 4 / 3 * np.pi * 0.125, (0.5, 0.5, 2.5)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_is_closed_faces_outward_and_fills_its_shape(name):
    (vertices, faces), volume, extents = SHAPES[name]
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert 0.97 * volume <= mesh.volume <= volume * (1 + 1e-12)  # inscribed, faces outward
    np.testing.assert_allclose(mesh.bounds, [[-e for e in extents], extents], atol=1e-12)


def test_round_vertices_lie_on_the_surface():
    vertices, _ = primitives.ellipsoid((1.0, 2.0, 3.0))
    np.testing.assert_allclose(np.linalg.norm(vertices / (1.0, 2.0, 3.0), axis=1), 1.0)
    vertices, _ = primitives.capsule(0.5, 2.0)
    axis = np.c_[np.zeros((len(vertices), 2)), np.clip(vertices[:, 2], -2.0, 2.0)]
    ends = np.abs(vertices[:, 2]) == 2.5
    assert ends.sum() == 2
    np.testing.assert_allclose(np.linalg.norm(vertices - axis, axis=1), 0.5)
