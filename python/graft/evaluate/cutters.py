"""Ways to cut a mesh into parts that are measured beside ours."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.cluster.vq import kmeans2
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from graft.objects import Floats, Ints, Part
from graft.parts import cut_part

HULL_POINTS = 20_000
"""Points on all of CoACD's pieces together, by which faces find theirs: a hundredth of the diagonal apart."""


class Cutter(Protocol):
    """A way to cut a mesh.

    Attributes:
        name: In tables.
    """

    @property
    def name(self) -> str:
        """In tables."""
        ...

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Return the part of each face; `people` is how many parts people make of it, for those who must be told."""
        ...


@dataclass(frozen=True)
class Ours:
    """graft: `graft.segment`."""

    name: str = "graft"

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Cut without being told how many."""
        return cut_part(Part("object", vertices, faces), seed=seed).labels


@dataclass(frozen=True)
class Whole:
    """Connected components: faces that share an edge."""

    name: str = "connected components"

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Label components."""
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        owner = np.repeat(np.arange(len(faces)), 3)
        number = np.unique(edges, axis=0, return_inverse=True)[1].ravel()
        graph = coo_matrix((np.ones(len(owner)), (owner, len(faces) + number)), (len(faces) + len(number),) * 2)
        labels: Ints = connected_components(graph, directed=False)[1][: len(faces)].astype(np.int64)
        return labels


@dataclass(frozen=True)
class KMeans:
    """k-means on the faces' centres, told how many parts people make."""

    name: str = "k-means, told k"

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Cluster the centres."""
        centers = vertices[faces].mean(axis=1)
        labels: Ints = kmeans2(centers, people, minit="++", rng=np.random.default_rng(seed))[1].astype(np.int64)
        return labels


@dataclass(frozen=True)
class ConvexPieces:
    """CoACD (Wei et al. 2022) as it comes: a face belongs to the convex piece that it lies nearest to."""

    name: str = "CoACD"

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Decompose, and look for the nearest piece."""
        import coacd
        import trimesh

        coacd.set_log_level("error")
        pieces = coacd.run_coacd(coacd.Mesh(vertices, faces), seed=seed)
        meshes = [trimesh.Trimesh(corners, triangles, process=False) for corners, triangles in pieces]
        total = sum(mesh.area for mesh in meshes)
        points, owner = [], []
        for number, mesh in enumerate(meshes):
            count = max(int(HULL_POINTS * mesh.area / total), 32)
            points.append(trimesh.sample.sample_surface(mesh, count, seed=seed)[0])
            owner.append(np.full(count, number))
        nearest = cKDTree(np.concatenate(points)).query(vertices[faces].mean(axis=1))[1]
        labels: Ints = np.concatenate(owner)[nearest]
        return labels


@dataclass(frozen=True)
class ShapeDiameter:
    """CGAL's shape diameter segmentation (Shapira, Shamir, Cohen-Or 2008) with its defaults."""

    name: str = "CGAL shape diameter"

    def cut(self, vertices: Floats, faces: Ints, people: int, seed: int) -> Ints:
        """Cut; the seed is CGAL's own."""
        import cgal_pybind

        surface = cgal_pybind.Polyhedron()
        surface.build(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.uint64))
        labels: Ints = np.asarray(surface.segmentation()[SEGMENT_IDS], np.int64)
        return labels


SEGMENT_IDS = 1
"""Where `Polyhedron.segmentation` returns the parts; before them are the diameters."""


def cutters() -> list[Cutter]:
    """Return graft and every peer that is installed, in the order of the table."""
    found: list[Cutter] = [Ours(), Whole(), KMeans()]
    if importlib.util.find_spec("cgal_pybind") is not None:
        found.append(ShapeDiameter())
    if importlib.util.find_spec("coacd") is not None and importlib.util.find_spec("trimesh") is not None:
        found.append(ConvexPieces())
    return found
