"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "box_gaps",
    "cast_rays",
    "chamfer_distances",
    "convex_hull",
    "describe_parts",
    "descriptor_dim",
    "edge_lengths",
    "feature_costs",
    "oriented_box",
    "part_adjacency",
    "part_geometry",
    "part_hops",
    "part_relations",
    "rank_graphs",
    "render_scene",
    "segment_cloud",
    "segment_mesh",
    "ufgw_batch",
    "ufgw_pair",
]
__version__: str

# geometry

def chamfer_distances(cloud: NDArray[np.float64], candidates: NDArray[np.float64]) -> NDArray[np.float64]: ...
def part_geometry(
    vertices: NDArray[np.float64],
    normals: NDArray[np.float64],
    vertex_counts: NDArray[np.int64],
    faces: NDArray[np.int64],
    face_counts: NDArray[np.int64],
    samples: int,
    seed: int,
) -> tuple[
    float,
    tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.uint8],
    NDArray[np.float64],
    NDArray[np.float64],
]:
    """Measure the parts of an object.

    Args:
        vertices: (v, 3) the parts' vertices, one part after the other.
        normals: (v, 3) a cloud's normals; zero rows where unknown.
        vertex_counts: (n,) vertices of each part, at least 1.
        faces: (f, 3) the parts' faces, indices within their part.
        face_counts: (n,) faces of each part; 0 for a cloud.
        samples: Surface samples s of each part.
        seed: Of the samples.

    Returns:
        Diagonal of the object's minimal box; box centres (n, 3), axes (n, 3, 3) in columns and half extents (n, 3);
        areas (n,); signed volumes (n,); hull volumes (n,); flag bits (n,): 1 degenerate, 2 flat, 4 symmetric;
        sampled points (n, s, 3) and normals (n, s, 3).
    """

def oriented_box(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return centre (3,), axes (3, 3) in columns and half extents (3,) of the minimal box of (p, 3) points."""

def convex_hull(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (v, 3) and outward faces (f, 3) of the hull; flat sets come back whole, without faces."""

# graph

def box_gaps(
    centers: NDArray[np.float64], axes: NDArray[np.float64], half_extents: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the (n, n) distances between boxes, 0 where they touch or overlap."""

def edge_lengths(
    centers: NDArray[np.float64],
    axes: NDArray[np.float64],
    half_extents: NDArray[np.float64],
    unit: float,
    adjacency: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """Return (n, n) edge lengths in [0, 1): of all pairs, or of the shortest paths along an adjacency (n, n)."""

def part_adjacency(gaps: NDArray[np.float64], joints: NDArray[np.int64], threshold: float) -> NDArray[np.bool_]:
    """Return (n, n): joints (j, 2), gaps of at most the threshold where a part has no joint; always connected."""

def part_hops(adjacency: NDArray[np.bool_], part: int) -> NDArray[np.int64]:
    """Return the (n,) numbers of steps from `part`, breadth first; n where there is no way."""

def part_relations(
    centers: NDArray[np.float64],
    axes: NDArray[np.float64],
    half_extents: NDArray[np.float64],
    points: NDArray[np.float64],
    areas: NDArray[np.float64],
    diagonal: float,
    up: tuple[float, float, float] | None = None,
    *,
    raw: bool = False,
) -> NDArray[np.float64]:
    """Return (n, 34) rows of how each part lies in its object, or (n, 17) raw features, NaN where unknown.

    Args:
        centers: (n, 3) box centres, object frame and units.
        axes: (n, 3, 3) box axes in columns.
        half_extents: (n, 3).
        points: (n, s, 3) surface samples.
        areas: (n,) surface areas.
        diagonal: The object's, object units.
        up: Unit vector against gravity, or None.
        raw: Return the features before standardisation.
    """

# descriptor

def describe_parts(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    vertex_offsets: NDArray[np.int64],
    face_offsets: NDArray[np.int64],
    *,
    families: list[str],
    samples: int,
    seed: int,
    raw: bool = False,
) -> NDArray[np.float64]: ...
def descriptor_dim(families: list[str]) -> int: ...

# transport

def ufgw_batch(
    sizes: NDArray[np.int64],
    features: NDArray[np.float64],
    source: NDArray[np.float64],
    target: NDArray[np.float64],
    source_mass: NDArray[np.float64],
    target_mass: NDArray[np.float64],
    prior: NDArray[np.float64] | None,
    start: NDArray[np.float64] | None,
    start_potential: NDArray[np.float64] | None,
    *,
    alpha: float,
    tau_s: float,
    tau_t: float,
    eps: float,
    loss: str,
    entropy: str,
    em_rate: float | None,
    tol: float,
    max_outer: int,
    n_init: int,
    seed: int,
    precision: str,
    history: bool,
    threads: int,
    instructions: str,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.bool_],
]: ...
def ufgw_pair(
    features: NDArray[np.float64],
    source: NDArray[np.float64],
    target: NDArray[np.float64],
    source_mass: NDArray[np.float64],
    target_mass: NDArray[np.float64],
    prior: NDArray[np.float64] | None,
    start: NDArray[np.float64] | None,
    start_potential: NDArray[np.float64] | None,
    alpha: float,
    tau_s: float,
    tau_t: float,
    eps: float,
    loss: str,
    entropy: str,
    em_rate: float | None,
    tol: float,
    max_outer: int,
    n_init: int,
    seed: int,
    precision: str,
    history: bool,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    list[float],
    NDArray[np.float64],
    int,
    int,
    bool,
]: ...
def rank_graphs(
    offsets: NDArray[np.int64],
    parts: NDArray[np.int64],
    extents: NDArray[np.float64],
    relations: NDArray[np.float64],
    descriptors: NDArray[np.float64] | None,
    structures: NDArray[np.float64],
    masses: NDArray[np.float64],
    hot_extents: NDArray[np.float32],
    hot_features: NDArray[np.float32],
    hot_masses: NDArray[np.float32],
    target_extents: NDArray[np.float64],
    target_relations: NDArray[np.float64],
    target_descriptors: NDArray[np.float64] | None,
    target_structure: NDArray[np.float64],
    target_prior: NDArray[np.float64],
    *,
    alpha: float,
    tau_s: float,
    tau_t: float,
    eps: float,
    loss: str,
    entropy: str,
    em_rate: float | None,
    tol: float,
    max_outer: int,
    lambda_obb: float,
    lambda_global: float,
    lambda_relation: float,
    variant: str,
    part_weight: float,
    doubt_weight: float,
    rival_weight: float,
    k: int,
    prune: bool,
) -> tuple[NDArray[np.int64], NDArray[np.float64], int]: ...
def feature_costs(
    source_extents: NDArray[np.float64],
    source_relations: NDArray[np.float64],
    source_descriptors: NDArray[np.float64] | None,
    target_extents: NDArray[np.float64],
    target_relations: NDArray[np.float64],
    target_descriptors: NDArray[np.float64] | None,
    *,
    lambda_obb: float,
    lambda_global: float,
    lambda_relation: float,
    variant: str,
) -> NDArray[np.float64]: ...

# render

def render_scene(
    *,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    face_groups: NDArray[np.int64],
    centers: NDArray[np.float64],
    radii: NDArray[np.float64],
    center_groups: NDArray[np.int64],
    colors: NDArray[np.uint8],
    camera: NDArray[np.float64],
    width: int,
    height: int,
) -> NDArray[np.uint8]: ...
def cast_rays(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
) -> NDArray[np.float64]: ...

# segment

def segment_mesh(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    *,
    parts: int | None,
    hierarchy: bool,
    seed: int,
) -> tuple[NDArray[np.int64], int, tuple[float, float], tuple[int, int, int, int, int, int]]: ...
def segment_cloud(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    neighbours: NDArray[np.int64],
    *,
    parts: int | None,
    hierarchy: bool,
    seed: int,
) -> tuple[NDArray[np.int64], int, tuple[float, float], tuple[int, int, int, int, int, int]]: ...
