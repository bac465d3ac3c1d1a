"""Scans as they come: open, inside out, non-manifold, soups, sheets, next to nothing, and far too much."""

from __future__ import annotations

import numpy as np
import pytest
from grid_solids import dumbbell, mug, voxel_mesh

import graft
from graft.errors import InputError
from graft.evaluate.cut_measures import rand_index_error
from graft.objects import Part, PartObject
from graft.parts import cut_part


@pytest.fixture(scope="module")
def mesh():
    return voxel_mesh(mug)


def test_noise_holes_and_turned_faces_are_told_of_and_hardly_matter(mesh) -> None:
    vertices, faces, drawn = mesh
    rng = np.random.default_rng(0)
    noisy = vertices + 0.004 * rng.standard_normal(vertices.shape)
    kept = rng.random(len(faces)) > 0.03
    torn = np.where((rng.random(len(faces)) < 0.05)[:, None], faces[:, ::-1], faces)[kept]
    cuts = cut_part(Part("scan", noisy, torn))
    assert rand_index_error(cuts.labels, drawn[kept]) < 0.1
    assert any("open edges" in note for note in cuts.notes)
    assert any("turned outward" in note for note in cuts.notes)


def test_an_object_inside_out_is_cut_alike(mesh) -> None:
    vertices, faces, drawn = mesh
    cuts = cut_part(Part("inside out", vertices, faces[:, ::-1]))
    assert rand_index_error(cuts.labels, drawn) < 0.06


def test_unwelded_corners_are_welded(mesh) -> None:
    vertices, faces, drawn = mesh
    loose = vertices[faces].reshape(-1, 3)
    cuts = cut_part(Part("stl", loose, np.arange(len(loose)).reshape(-1, 3)))
    assert rand_index_error(cuts.labels, drawn) < 0.06


def test_crowded_edges_are_counted(mesh) -> None:
    vertices, faces, _ = mesh
    cuts = cut_part(Part("fins", vertices, np.concatenate([faces, faces[:40]])))
    assert any("edges of more than two faces" in note for note in cuts.notes)


def test_components_that_carry_meaning_are_parts(mesh) -> None:
    vertices, faces, _ = voxel_mesh(dumbbell, cells=24)
    apart = np.concatenate([vertices, vertices + np.array([0.0, 3.0, 0.0])])
    both = np.concatenate([faces, faces + len(vertices)])
    labels = cut_part(Part("two", apart, both)).labels
    assert not set(labels[: len(faces)]) & set(labels[len(faces) :])
    assert len(set(cut_part(Part("two", apart, both), n_parts=2).labels)) == 2


def test_a_soup_of_loose_triangles_is_flagged() -> None:
    rng = np.random.default_rng(0)
    corners = (rng.random((400, 1, 3)) + 0.02 * rng.standard_normal((400, 3, 3))).reshape(-1, 3)
    cuts = cut_part(Part("soup", corners, np.arange(1200).reshape(-1, 3)))
    assert any("of 400 loose components joined" in note for note in cuts.notes)
    assert len(cuts.labels) == 400


@pytest.mark.parametrize("count", [1, 3])
def test_too_few_faces_are_one_flagged_part(count: int) -> None:
    corners = np.random.default_rng(0).random((3 * count, 3))
    obj = graft.segment((corners, np.arange(3 * count).reshape(-1, 3)))
    assert len(obj.parts) == 1
    assert "too few" in obj.notes[-1]


def test_three_points_are_one_flagged_part() -> None:
    obj = graft.segment((np.eye(3), None))
    assert len(obj.parts) == 1
    assert "3 points: too few" in obj.notes[-1]


def test_a_flat_sheet_is_one_flagged_part() -> None:
    grid = np.stack([*np.meshgrid(np.linspace(0, 1, 20), np.linspace(0, 1, 20)), np.zeros((20, 20))], axis=-1)
    index = np.arange(400).reshape(20, 20)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    obj = graft.segment((grid.reshape(-1, 3), faces))
    assert len(obj.parts) == 1
    assert "one part" in obj.notes[-1]


def test_points_that_coincide_are_an_error() -> None:
    with pytest.raises(InputError, match="coincide"):
        cut_part(Part("spot", np.ones((30, 3))))


def test_meshes_and_clouds_do_not_fuse(mesh) -> None:
    vertices, faces, _ = mesh
    obj = PartObject("both", (Part("mesh", vertices, faces), Part("cloud", vertices)))
    with pytest.raises(InputError, match="got both"):
        graft.segment(obj, fuse=True)


def test_a_large_mesh_is_cut_on_a_coarser_copy() -> None:
    vertices, faces, drawn = voxel_mesh(dumbbell, cells=24)
    for _ in range(3):
        # Each triangle becomes four.
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        ends, middle = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (len(vertices) + middle.reshape(-1, 3)).T
        a, b, c = faces.T
        vertices = np.concatenate([vertices, vertices[ends].mean(axis=1)])
        faces = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        drawn = np.tile(drawn, 4)
    cuts = cut_part(Part("fine", vertices, faces))
    assert len(faces) > 60_000
    assert cuts.notes[0].startswith("cut on a copy of")
    assert rand_index_error(cuts.labels, drawn) < 0.1
