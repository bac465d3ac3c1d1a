"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "antipodal_grasps",
    "arm_poses",
    "box_gaps",
    "cast_rays",
    "chamfer_distances",
    "clear_arms",
    "convex_hull",
    "describe_parts",
    "descriptor_dim",
    "edge_lengths",
    "feature_costs",
    "gripper_collisions",
    "oriented_box",
    "part_adjacency",
    "part_geometry",
    "part_hops",
    "part_relations",
    "plan_arms",
    "plan_hands",
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
    bar: float,
    among: NDArray[np.int64] | None,
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

# grasp

def gripper_collisions(
    *,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    points: NDArray[np.float64],
    radii: NDArray[np.float64],
    centers: NDArray[np.float64],
    half_extents: NDArray[np.float64],
    rotations: NDArray[np.float64],
    fingers: int,
    poses: NDArray[np.float64],
    openings: NDArray[np.float64],
    margin: float,
    plane: tuple[float, ...] | None,
    solid: bool,
) -> NDArray[np.bool_]:
    """Say which poses of a gripper touch an object or go below a plane.

    Args:
        vertices: (v, 3) of a mesh.
        faces: (f, 3) vertex indices.
        points: (p, 3) centres of balls.
        radii: (p,) of the balls.
        centers: (b, 3) of the gripper's boxes, palm first; those of the finger at +y in its own frame.
        half_extents: (b, 3).
        rotations: (b, 3, 3) axes in columns.
        fingers: How many of the boxes, the last ones, are the finger's.
        poses: (q, 4, 4) T_object_gripper.
        openings: (q,) between the pads.
        margin: By which boxes grow.
        plane: Unit normal and offset of what lies below.
        solid: Boxes wholly inside the mesh count too.

    Returns:
        (q,).
    """

# motion

_World = tuple[
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.float64],
    NDArray[np.float64],
    tuple[float, float, float, float] | None,
]
_Links = tuple[NDArray[np.float64] | NDArray[np.int64], ...]
_Settings = tuple[float, float, float, int, float | None, int, int]

def plan_hands(
    *,
    world: _World,
    box_centers: NDArray[np.float64],
    box_rotations: NDArray[np.float64],
    box_half_extents: NDArray[np.float64],
    bounds: NDArray[np.float64],
    starts: NDArray[np.float64],
    goals: NDArray[np.float64],
    settings: _Settings,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Plan for a hand made of boxes from each start to the goal of the same index, by RRT-Connect.

    Args:
        world: Vertices (v, 3), faces (f, 3), centres (p, 3) and radii (p,) of balls, and normal and offset of the
            support.
        box_centers: (b, 3) in the hand's frame.
        box_rotations: (b, 3, 3) axes in columns.
        box_half_extents: (b, 3).
        bounds: (n, 2, 3) corners of where the hand's origin is sampled.
        starts: (n, 4, 4).
        goals: (n, 4, 4).
        settings: Clearance, step, goal bias, iterations, seconds or None, shortcuts, seed.

    Returns:
        All waypoints (m, 4, 4); rows (n, 5): how it ended (0 found, 1 start blocked, 2 goal blocked, 3 out of
        iterations, 4 out of time), waypoints, iterations, nodes, collision tests.
    """

def plan_arms(
    *,
    world: _World,
    links: _Links,
    movers: NDArray[np.int64],
    pairs: NDArray[np.int64],
    starts: NDArray[np.float64],
    goals: NDArray[np.float64],
    settings: _Settings,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Plan for an arm from each start to the goal of the same index, by RRT-Connect.

    Args:
        world: As for `plan_hands`.
        links: Parents (l,), rest poses (l, 4, 4), kinds (l,) 0 fixed 1 hinge 2 slide, axes (l, 3), anchors (l, 3),
            limits (j, 2), links of the boxes (b,), their centres (b, 3), rotations (b, 3, 3), half extents (b, 3).
        movers: Boxes that keep away from the world.
        pairs: (p, 2) boxes that keep away from each other.
        starts: (n, j).
        goals: (n, j).
        settings: As for `plan_hands`.

    Returns:
        All waypoints (m, j); rows as of `plan_hands`.
    """

def clear_arms(
    *,
    world: _World,
    links: _Links,
    movers: NDArray[np.int64],
    pairs: NDArray[np.int64],
    joints: NDArray[np.float64],
    slack: float,
) -> NDArray[np.bool_]:
    """Return which joint values (n, j) keep `slack` metres from every contact: (n,)."""

def arm_poses(links: _Links, joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the links are, (n, l, 4, 4), at joint values (n, j)."""

def antipodal_grasps(
    *,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    face_parts: NDArray[np.int64],
    centers: NDArray[np.float64],
    half_extents: NDArray[np.float64],
    rotations: NDArray[np.float64],
    fingers: int,
    stroke: float,
    contact: tuple[float, ...] | None,
    tolerance: float,
    approach: tuple[float, ...] | None,
    radius: float,
    part: int | None,
    plane: tuple[float, ...] | None,
    up: tuple[float, ...] | None,
    weights: tuple[float, ...],
    depths: NDArray[np.float64],
    samples: int,
    rays: int,
    pairs: int,
    approaches: int,
    cone: float,
    clearance: float,
    margin: float,
    travel: float,
    spacing: float,
    turn: float,
    count: int,
    seed: int,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    tuple[list[str], NDArray[np.float64]],
    list[tuple[str, int]],
]:
    """Find antipodal grasps that a parallel gripper can reach, best first.

    Boxes are those of `gripper_collisions`, parameters those of `graft.grasp.AntipodalPlanner`; `spacing` and `turn`
    tell grasps apart, `weights` are in the order of the names that come back.

    Returns:
        Poses (n, 4, 4); widths (n,); scores (n,); contacts (n, 2, 3); distances (n,); names and values (n, t) of the
        scores' terms; reasons with how many candidates fell for each.
    """
