"""Part graphs: laws of boxes, samples, relations and masses."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.graph import PartFlag, build_graph, source_mass, target_prior
from graft.objects import Joint, Part, PartObject


def part(name: str, mesh: trimesh.Trimesh, shift=(0.0, 0.0, 0.0)) -> Part:
    return Part(name, mesh.vertices + np.asarray(shift), mesh.faces)


def hammer() -> PartObject:
    """A cone's head on a tapering handle, a collar that touches neither, all without symmetric boxes."""
    wedge = trimesh.convex.convex_hull(np.random.default_rng(0).normal(size=(40, 3)) * [0.05, 0.12, 0.04])
    handle = trimesh.convex.convex_hull(np.random.default_rng(1).normal(size=(60, 3)) * [0.02, 0.015, 0.2])
    collar = trimesh.convex.convex_hull(np.random.default_rng(2).normal(size=(30, 3)) * [0.03, 0.05, 0.015])
    return PartObject(
        "hammer",
        (part("head", wedge, (0, 0, 0.5)), part("handle", handle), part("collar", collar, (0.9, 0, 0))),
        up=[0, 0, 1],
        scale_to_metres=0.25,
    )


def moved(obj: PartObject, scale: float) -> tuple[PartObject, np.ndarray]:
    transform = np.eye(4)
    transform[:3, :3] = Rotation.from_rotvec([0.7, -0.4, 1.9]).as_matrix() * scale
    transform[:3, 3] = np.array([3.0, -1.0, 0.5]) * scale
    parts = [Part(p.name, p.vertices @ transform[:3, :3].T + transform[:3, 3], p.faces) for p in obj.parts]
    return PartObject(obj.name, tuple(parts)), transform


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_graph_moves_with_its_object(scale):
    graph = build_graph(hammer(), descriptor=None)
    other_object, transform = moved(hammer(), scale)
    other = build_graph(other_object, descriptor=None)
    turn = transform[:3, :3] / scale
    assert_allclose(other.diagonal / scale, graph.diagonal, rtol=1e-4)
    assert_allclose(other.half_extents / scale, graph.half_extents, rtol=1e-3)
    assert_allclose(other.centers, graph.centers @ transform[:3, :3].T + transform[:3, 3], atol=1e-3 * scale)
    assert_allclose(other.axes, turn @ graph.axes, atol=1e-3)
    assert_allclose(other.structure, graph.structure, atol=1e-3)
    assert_allclose(other.gaps, graph.gaps, atol=1e-3)
    assert_array_equal(other.adjacency, graph.adjacency)
    assert_allclose(other.points[1], graph.points[1] @ transform[:3, :3].T + transform[:3, 3], atol=1e-9 * scale)
    assert_allclose(target_prior(other), target_prior(graph), atol=1e-3)


def test_relations_have_their_form():
    graph = build_graph(hammer(), descriptor=None)
    for table in (graph.structure, graph.gaps):
        assert_allclose(table, table.T)
        assert_allclose(np.diag(table), 0)
    assert (graph.structure < 1).all()
    i, j = 0, 1
    cosine = abs(graph.axes[i][:, 0] @ graph.axes[j][:, 0])
    x = np.linalg.norm(graph.centers[i] - graph.centers[j]) / graph.diagonal + np.arccos(cosine) / np.pi
    assert_allclose(graph.structure[i, j], x / (1 + x), rtol=1e-9)
    metric = build_graph(hammer(), descriptor=None, unit="metres")
    x = np.linalg.norm(graph.centers[i] - graph.centers[j]) * 0.25 + np.arccos(cosine) / np.pi
    assert_allclose(metric.structure[i, j], x / (1 + x), rtol=1e-9)


def test_shortest_paths_add_up_along_the_adjacency():
    chain = PartObject("chain", tuple(part(f"p{k}", trimesh.creation.box([1, 0.2, 0.1]), (k, 0, 0)) for k in range(4)))
    graph = build_graph(chain, descriptor=None, structure="shortest_path")
    x = graph.structure / (1 - graph.structure)
    assert_allclose(x[0], np.arange(4) / graph.diagonal, atol=1e-9)


def test_adjacency_is_joints_or_gaps_and_always_connected():
    obj = hammer()
    graph = build_graph(obj, descriptor=None)
    reach = np.linalg.matrix_power(graph.adjacency.astype(int) + np.eye(3, dtype=int), 3)
    assert (reach > 0).all()
    jointed = PartObject(obj.name, obj.parts, joints=(Joint(0, 2),))
    assert build_graph(jointed, descriptor=None).adjacency[0, 2]


def test_masses_add_up_and_fall_with_every_step():
    chain = PartObject("chain", tuple(part(f"p{k}", trimesh.creation.box([1, 0.2, 0.1]), (k, 0, 0)) for k in range(4)))
    graph = build_graph(chain, descriptor=None)
    mass = source_mass(graph, "p1")
    assert_allclose(mass, np.array([0.6, 1, 0.6, 0.36]) / 2.56, rtol=1e-6)
    assert_allclose(source_mass(graph, 0, gamma=1.0), target_prior(graph))
    assert_allclose(target_prior(graph).sum(), 1)
    for scale in (1e-6, 1e6):
        assert_allclose(source_mass(build_graph(moved(chain, scale)[0], descriptor=None), 1), mass, rtol=1e-6)


def test_samples_lie_on_the_surface_and_share_it_by_area():
    cuboid = PartObject("cuboid", (part("cuboid", trimesh.creation.box([4.0, 2.0, 1.0])),))
    graph = build_graph(cuboid, descriptor=None, samples=2800)
    points, normals = graph.points[0], graph.normals[0]
    assert_allclose((np.abs(points) / [2, 1, 0.5]).max(axis=1), 1, atol=1e-12)
    assert_allclose(np.linalg.norm(normals, axis=1), 1)
    assert (np.einsum("ij,ij->i", points, normals) > 0).all()
    # Faces of area 8, 4 and 2, two each: strata give each its share to within two samples per triangle.
    share = [np.abs(normals[:, k]).sum() for k in range(3)]
    assert_allclose(share, [400, 800, 1600], atol=8)
    assert_allclose(graph.areas, 28)
    inside_out = PartObject("c", (Part("c", cuboid.parts[0].vertices, cuboid.parts[0].faces[:, ::-1]),))
    flipped = build_graph(inside_out, descriptor=None)
    assert (np.einsum("ij,ij->i", flipped.points[0], flipped.normals[0]) > 0).all()


def test_clouds_keep_their_normals_or_get_them():
    ball = trimesh.creation.icosphere(subdivisions=4).vertices
    given_ = build_graph(PartObject("b", (Part("b", ball, normals=ball),)), descriptor=None, samples=200)
    guessed = build_graph(PartObject("b", (Part("b", ball),)), descriptor=None, samples=200)
    assert given_.flags[0] & PartFlag.CLOUD
    assert len(np.unique(given_.points[0], axis=0)) == 200
    assert_allclose(given_.normals[0], given_.points[0], atol=1e-9)
    assert (np.einsum("ij,ij->i", guessed.normals[0], guessed.points[0]) > 0.98).all()
    assert_allclose(guessed.areas, 4 * np.pi, rtol=0.25)
    assert build_graph(PartObject("b", (Part("b", ball[:5]),)), descriptor=None, samples=8).points[0].shape == (8, 3)


def test_a_seed_gives_the_same_graph_whatever_the_threads():
    script = (
        f"import sys; sys.path[:0] = [{str(Path(__file__).parent)!r}]\n"
        "from test_graph import hammer; from graft.graph import build_graph\n"
        "g = build_graph(hammer(), descriptor=None, seed=3)\n"
        "print(hash((g.points[1].tobytes(), g.axes.tobytes(), g.structure.tobytes())))"
    )
    runs = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "RAYON_NUM_THREADS": threads, "PYTHONHASHSEED": "0"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2", "5")
    }
    assert len(runs) == 1
    one, two = (build_graph(hammer(), descriptor=None, seed=s).points[0] for s in (3, 4))
    assert not np.array_equal(one, two)


FACE = np.array([[0, 1, 2]])
ODD_PARTS = {
    "one vertex": Part("p", [[1.0, 2, 3]]),
    "coincident": Part("p", np.ones((5, 3)), FACE),
    "collinear faces": Part("p", [[0.0, 0, 0], [1, 1, 1], [2, 2, 2]], FACE),
    "collinear cloud": Part("p", np.arange(30.0)[:, None] * [1.0, 2.0, 3.0]),
    "one triangle": Part("p", [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], FACE),
    "flat cloud": Part("p", np.random.default_rng(0).normal(size=(40, 3)) * [1, 1, 0]),
    "unused vertex": Part("p", [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], FACE),
}


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("name", ODD_PARTS)
def test_odd_parts_give_numbers_and_flags(name, scale):
    odd = ODD_PARTS[name]
    scaled = Part("p", odd.vertices * scale, odd.faces)
    cube = part("cube", trimesh.creation.box([scale, scale, scale]), (4 * scale, 0, 0))
    for parts in ((scaled,), (scaled, cube)):
        graph = build_graph(PartObject("o", parts), descriptor=None, samples=16)
        for array in (graph.centers, graph.axes, graph.areas, graph.structure, graph.gaps, *graph.points):
            assert np.isfinite(array).all()
        assert (graph.half_extents > 0).all()
        assert_allclose(np.linalg.norm(graph.normals[0], axis=1), 1)
        assert graph.flags[0] & PartFlag.FLAT
        assert_allclose(source_mass(graph, 0).sum(), 1)
    flat_only = name in ("one triangle", "flat cloud", "unused vertex")
    assert bool(graph.flags[0] & PartFlag.DEGENERATE) != flat_only
    assert graph.flags[1] == PartFlag.SYMMETRIC


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_random_objects_make_sound_graphs(seed):
    rng = np.random.default_rng(seed)
    parts = tuple(
        Part(f"p{k}", np.round(rng.normal(size=(int(rng.integers(1, 30)), 3)), int(rng.integers(0, 4))))
        for k in range(int(rng.integers(1, 6)))
    )
    graph = build_graph(PartObject("random", parts), descriptor=None, samples=8, seed=seed)
    n = len(graph)
    assert (np.linalg.matrix_power(graph.adjacency.astype(float) + np.eye(n), n) > 0).all()
    assert np.isfinite(graph.structure).all()
    assert (graph.structure < 1).all()
    assert (graph.half_extents > 0).all()
    assert_allclose(target_prior(graph).sum(), 1)


class Fixed:
    name = "fixed/1"
    dim = 2

    def __init__(self, rows):
        self.rows = rows

    def describe(self, obj):
        return self.rows


def test_descriptors_are_checked():
    graph = build_graph(hammer(), descriptor=Fixed(np.ones((3, 2))))
    assert graph.descriptor_name == "fixed/1"
    assert graph.descriptors.shape == (3, 2)
    with pytest.raises(InputError, match=r"expected shape \(3, 2\), got \(2, 2\)"):
        build_graph(hammer(), descriptor=Fixed(np.ones((2, 2))))
    with pytest.raises(InputError, match="not finite for part 'handle'"):
        build_graph(hammer(), descriptor=Fixed(np.array([[1, 1], [np.nan, 1], [1, 1]])))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 0}, "samples: expected at least 1"),
        ({"seed": -1}, "seed: expected"),
        ({"adjacency_gap": float("nan")}, "adjacency_gap: expected"),
        ({"structure": "star"}, "structure: expected 'all_pairs' or 'shortest_path'"),
        ({"unit": "feet"}, "unit: expected 'diagonal' or 'metres'"),
    ],
)
def test_bad_options_are_named(options, message):
    with pytest.raises(InputError, match=message):
        build_graph(hammer(), descriptor=None, **options)


def test_metres_need_a_scale():
    with pytest.raises(InputError, match="need scale_to_metres"):
        build_graph(PartObject("o", hammer().parts), descriptor=None, unit="metres")
