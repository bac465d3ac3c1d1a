"""How far two ways to cut a surface differ (Chen, Golovinskiy, Funkhouser, ACM Trans. Graph. 28(3), 2009).

All four are 0 for equal cuts. The Rand-index error counts faces, as the paper does; Hamming distance and
consistency error weigh them by area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from graft.objects import Floats, Ints


def overlaps(a: Ints, b: Ints, weights: Floats) -> Floats:
    """Return (n, m) the weight that each label of `a` shares with each label of `b`."""
    first, second = np.unique(a, return_inverse=True)[1], np.unique(b, return_inverse=True)[1]
    width = int(second.max()) + 1
    table = np.bincount(first * width + second, weights, (int(first.max()) + 1) * width)
    return np.asarray(table, np.float64).reshape(-1, width)


def rand_index_error(a: Ints, b: Ints) -> float:
    """Return the share of pairs of faces that one puts together and the other apart (their equation for 1 - RI)."""
    shared = overlaps(a, b, np.ones(len(a)))
    pairs = len(a) * (len(a) - 1.0)
    together = (shared.sum(axis=1) ** 2).sum() + (shared.sum(axis=0) ** 2).sum() - 2.0 * (shared**2).sum()
    return float(together / pairs) if pairs else 0.0


def hamming_distance(a: Ints, b: Ints, areas: Floats) -> float:
    """Return the mean of missing rate and false alarm rate: what lies outside of the best-overlapping segment."""
    shared = overlaps(a, b, areas)
    total = shared.sum()
    rates = [1.0 - table.max(axis=0).sum() / total for table in (shared, shared.T)]
    return float(np.mean(rates))


def consistency_errors(a: Ints, b: Ints, areas: Floats) -> tuple[float, float]:
    """Return the global and the local consistency error: how far the one is no refinement of the other."""
    shared = overlaps(a, b, areas)
    of_a, of_b = shared.sum(axis=1, keepdims=True), shared.sum(axis=0, keepdims=True)
    # Over faces in the same two segments the refinement error is one number.
    forth = (of_a - shared) / np.where(of_a > 0, of_a, 1.0)
    back = (of_b - shared) / np.where(of_b > 0, of_b, 1.0)
    total = shared.sum()
    overall = min((shared * forth).sum(), (shared * back).sum()) / total
    return float(overall), float((shared * np.minimum(forth, back)).sum() / total)


@dataclass(frozen=True, eq=False)
class Net:
    """The edges of a mesh, on which cuts lie.

    Attributes:
        sides: (s, 2) faces on either side of each inner edge.
        ends: (s, 2) its vertices.
        lengths: (s,) its length.
        graph: (v, v) lengths of all edges.
        radius: Mean distance from the surface to its centroid, by area: their normalisation.
    """

    sides: Ints
    ends: Ints
    lengths: Floats
    graph: csr_matrix
    radius: float

    @classmethod
    def of(cls, vertices: Floats, faces: Ints) -> Net:
        """Find the edges that two faces share."""
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        owner = np.repeat(np.arange(len(faces)), 3)
        order = np.lexsort((owner, edges[:, 1], edges[:, 0]))
        edges, owner = edges[order], owner[order]
        twice = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
        ends = edges[twice]
        lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        every = np.unique(edges, axis=0)
        steps = np.linalg.norm(vertices[every[:, 0]] - vertices[every[:, 1]], axis=1)
        graph = csr_matrix((steps, (every[:, 0], every[:, 1])), (len(vertices), len(vertices)))
        corners = vertices[faces]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        centers = corners.mean(axis=1)
        away = np.linalg.norm(centers - np.average(centers, axis=0, weights=areas), axis=1)
        return cls(
            np.stack([owner[twice], owner[twice + 1]], axis=1),
            ends,
            lengths,
            graph,
            float(np.average(away, weights=areas)),
        )

    def cuts(self, labels: Ints) -> tuple[Ints, Floats]:
        """Return the vertices on the cuts and the length of cut that each stands for."""
        cut = labels[self.sides[:, 0]] != labels[self.sides[:, 1]]
        halves = np.repeat(self.lengths[cut] / 2.0, 2)
        weights = np.asarray(np.bincount(self.ends[cut].ravel(), halves, self.graph.shape[0]), np.float64)
        on = np.asarray(np.flatnonzero(weights), np.int64)
        return on, weights[on]

    def distances(self, on: Ints) -> Floats:
        """Return the distance of every vertex to the nearest of those in `on`, along edges."""
        found: Floats = dijkstra(self.graph, directed=False, indices=on, min_only=True)
        return found


@dataclass(frozen=True, eq=False)
class CutField:
    """The cuts of one segmentation, and how far everything lies from them.

    Attributes:
        on: (c,) vertices on the cuts.
        weights: (c,) length that each stands for.
        away: (v,) geodesic distance from the cuts; empty where there are none.
    """

    on: Ints
    weights: Floats
    away: Floats

    @classmethod
    def of(cls, net: Net, labels: Ints) -> CutField:
        """Measure from the cuts between `labels`."""
        on, weights = net.cuts(labels)
        return cls(on, weights, net.distances(on) if len(on) else np.empty(0))


def cut_discrepancy(a: CutField, b: CutField, radius: float) -> float | None:
    """Return how far the cuts of each lie from those of the other, over the mean radius; None without cuts."""
    if not len(a.on) or not len(b.on):
        return None
    forth = float(np.average(b.away[a.on], weights=a.weights))
    back = float(np.average(a.away[b.on], weights=b.weights))
    return (forth + back) / radius if np.isfinite(forth + back) else None
