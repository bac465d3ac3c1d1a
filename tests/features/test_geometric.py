"""Laws of the geometric descriptor: what must not change it, what must, and what it refuses."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.features import FAMILIES, Descriptor, GeometricDescriptor
from graft.objects import Part, PartObject

DESCRIPTOR = GeometricDescriptor()


def mesh_part(mesh: trimesh.Trimesh, name: str = "part") -> Part:
    return Part(name, mesh.vertices, mesh.faces)


def single(part: Part) -> PartObject:
    return PartObject("object", (part,))


def row(part: Part, descriptor: GeometricDescriptor = DESCRIPTOR) -> np.ndarray:
    return descriptor.describe(single(part))[0]


def shapes() -> dict[str, trimesh.Trimesh]:
    make = trimesh.creation
    return {
        "box": make.box((1.0, 0.7, 0.4)),
        "ring": make.torus(1.0, 0.15),
        "rod": make.cylinder(0.1, 2.0).subdivide().subdivide(),
        "plate": make.cylinder(1.0, 0.05),
        "ball": make.icosphere(3),
        "cup": make.annulus(0.8, 0.9, 1.5),
    }


@pytest.mark.parametrize("name", shapes())
@given(seed=st.integers(0, 2**31), scale=st.floats(1e-4, 1e4), shift=st.floats(-10.0, 10.0), mirror=st.booleans())
@settings(max_examples=8, deadline=None)
def test_pose_scale_and_mirroring_do_not_matter(name, seed, scale, shift, mirror):
    mesh = shapes()[name]
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix() * (-1.0 if mirror else 1.0)
    moved = Part("part", scale * (mesh.vertices @ turn.T + shift), mesh.faces)
    # Rounding may move a sample to the next face, and tied axes may swap: hence not 1e-9.
    assert row(moved) @ row(mesh_part(mesh)) > 0.999


@pytest.mark.parametrize("name", shapes())
def test_the_order_of_vertices_and_faces_matters_less_than_shape(name):
    mesh = shapes()[name].subdivide()
    random = np.random.default_rng(3)
    order = random.permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = place[mesh.faces][random.permutation(len(mesh.faces))]
    assert row(Part("part", mesh.vertices[order], faces)) @ row(mesh_part(mesh)) > 0.96


def test_other_shapes_differ_more_than_other_samples_of_one_shape():
    names = list(shapes())
    parts = [mesh_part(mesh) for mesh in shapes().values()]
    first = np.array([row(part) for part in parts])
    second = np.array([row(part, GeometricDescriptor(seed=1)) for part in parts])
    same = 1.0 - (first * second).sum(axis=1)
    other = 1.0 - first @ first.T + 2.0 * np.eye(len(names))
    assert (other.min(axis=1) > 4.0 * same).all(), dict(
        zip(names, zip(same, other.min(axis=1), strict=True), strict=True)
    )


@pytest.mark.parametrize("name", ["ring", "rod", "plate", "ball"])
def test_finer_triangles_do_not_matter(name):
    mesh = shapes()[name]
    fine = mesh.subdivide().subdivide()
    assert row(mesh_part(mesh)) @ row(mesh_part(fine)) > 0.98


DEGENERATE = {
    "one point": Part("part", np.ones((1, 3))),
    "two points": Part("part", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
    "one triangle": Part("part", np.eye(3), [[0, 1, 2]]),
    "coincident": Part("part", np.full((4, 3), 2.0), [[0, 1, 2], [1, 2, 3]]),
    "collinear": Part("part", np.outer(np.arange(6.0), [1.0, 2.0, 3.0]), [[0, 1, 2], [3, 4, 5]]),
    "sheet": Part("part", [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]]),
    "three faces on an edge": Part(
        "part", [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    ),
    "cloud": Part("part", np.random.default_rng(0).normal(size=(3000, 3))),
    "huge": Part("part", 1e300 * np.eye(3), [[0, 1, 2]]),
    "far away": Part("part", np.eye(3) + 1e9, [[0, 1, 2]]),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_parts_have_finite_vectors(name):
    vector = row(DEGENERATE[name])
    assert np.isfinite(vector).all()
    assert np.linalg.norm(vector) == pytest.approx(1.0)


def test_a_cloud_is_near_the_mesh_it_was_sampled_from():
    rng = np.random.default_rng(0)
    described = {name: row(mesh_part(mesh)) for name, mesh in shapes().items()}
    for name, mesh in shapes().items():
        triangles = mesh.triangles[rng.choice(len(mesh.faces), 4000, p=mesh.area_faces / mesh.area)]
        cloud = np.einsum("nk,nkd->nd", rng.dirichlet(np.ones(3), 4000), triangles)
        vector = row(Part("part", cloud))
        assert max(described, key=lambda other: vector @ described[other]) == name


def test_rows_do_not_depend_on_the_other_parts_or_repetition():
    parts = tuple(mesh_part(mesh, name) for name, mesh in shapes().items())
    together = DESCRIPTOR.describe(PartObject("object", parts))
    assert np.array_equal(together, DESCRIPTOR.describe(PartObject("object", parts)))
    assert np.array_equal(together, np.array([row(part) for part in parts]))


def test_rows_do_not_depend_on_the_number_of_threads():
    code = (
        "import sys, trimesh\n"
        "from graft.features import GeometricDescriptor\n"
        "from graft.objects import Part, PartObject\n"
        "m = trimesh.creation.torus(1.0, 0.2)\n"
        "parts = [Part(str(k), m.vertices * [1, 1, k], m.faces) for k in (1, 2, 3)]\n"
        "sys.stdout.write(GeometricDescriptor().describe(PartObject('o', parts)).tobytes().hex())\n"
    )

    def run(threads: str) -> str:
        environment = {**os.environ, "RAYON_NUM_THREADS": threads}
        command = [sys.executable, "-c", code]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout

    assert run("1") == run("3") != ""


def test_it_is_a_descriptor_and_its_name_tells_its_options():
    assert isinstance(DESCRIPTOR, Descriptor)
    others = [
        GeometricDescriptor(seed=1),
        GeometricDescriptor(samples=512),
        GeometricDescriptor(families=("hull",)),
    ]
    assert len({d.name for d in [DESCRIPTOR, *others]}) == 4
    assert GeometricDescriptor(families=FAMILIES[::-1]) == DESCRIPTOR


@pytest.mark.parametrize("families", [FAMILIES, ("curve",), ("harmonics", "hull")])
def test_every_choice_of_families_gives_rows_of_length_one_and_dim_wide(families):
    descriptor = GeometricDescriptor(families=families)
    vector = row(mesh_part(shapes()["ring"]), descriptor)
    assert vector.shape == (descriptor.dim,)
    assert np.linalg.norm(vector) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "options",
    [{"families": ()}, {"families": ("colour",)}, {"families": ("hull", "hull")}, {"samples": 10},
     {"samples": 1024.0}, {"samples": True}, {"seed": -1}],
)  # fmt: skip
def test_bad_options_are_named(options):
    with pytest.raises(InputError, match=next(iter(options))):
        GeometricDescriptor(**options)
