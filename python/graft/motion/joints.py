"""Motions of an arm in its joints, around an object in the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graft import _core
from graft.checks import Floats, Ints, checked_array
from graft.errors import InputError
from graft.grasp import Support
from graft.io import ObjectLike, as_object
from graft.motion.config import MotionConfig
from graft.motion.hand import DEFAULTS
from graft.motion.obstacles import World, metric_world, moved, nothing_but
from graft.motion.trajectory import checked_pose

FIXED, HINGE, SLIDE = 0, 1, 2
"""What a link's `kinds` may be."""

Links = tuple[Floats | Ints, ...]
"""What the core reads: parents, rests, kinds, axes, anchors, limits, then the boxes' links, centres, axes, halves."""


@dataclass(frozen=True, eq=False)
class Chain:
    """An arm as links and boxes: what the planner knows of it. Metres, radians, world frame.

    Attributes:
        parents: (l,) index of each link's parent, lower than its own; -1 for links that stand in the world.
        rests: (l, 4, 4) T_parent_link where the link's joint is at 0.
        kinds: (l,) `FIXED`, `HINGE` or `SLIDE`. Joints are numbered in the order of their links.
        axes: (l, 3) unit axes of the joints, link frame.
        anchors: (l, 3) points on the hinges' axes, link frame.
        limits: (j, 2) lowest and highest value of each joint.
        box_links: (b,) which link each box is on.
        box_centers: (b, 3) link frame.
        box_rotations: (b, 3, 3) the boxes' axes in columns, link frame.
        box_half_extents: (b, 3)
        movers: (m,) indices of the boxes that keep away from object and support.
        pairs: (p, 2) indices of boxes that keep away from each other.
    """

    parents: Ints
    rests: Floats
    kinds: Ints
    axes: Floats
    anchors: Floats
    limits: Floats
    box_links: Ints
    box_centers: Floats
    box_rotations: Floats
    box_half_extents: Floats
    movers: Ints
    pairs: Ints

    def __post_init__(self) -> None:
        n, b = len(self.parents), len(self.box_links)
        shapes = {"parents": (n,), "rests": (n, 4, 4), "kinds": (n,), "axes": (n, 3), "anchors": (n, 3)}
        boxes = {"box_links": (b,), "box_centers": (b, 3), "box_rotations": (b, 3, 3), "box_half_extents": (b, 3)}
        rest = {"limits": (None, 2), "movers": (None,), "pairs": (None, 2)}
        whole = {"parents", "kinds", "box_links", "movers", "pairs"}
        for name, shape in {**shapes, **boxes, **rest}.items():
            dtype = np.int64 if name in whole else np.float64
            object.__setattr__(self, name, checked_array(f"chain {name}", getattr(self, name), shape, dtype))

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.limits)

    @property
    def links(self) -> Links:
        """What the core reads."""
        boxes = (self.box_links, self.box_centers, self.box_rotations, self.box_half_extents)
        return (self.parents, self.rests, self.kinds, self.axes, self.anchors, self.limits, *boxes)

    def holding(self, joints: Ints, values: ArrayLike) -> Chain:
        """Return the chain with some joints held at values, one for each."""
        limits = self.limits.copy()
        limits[joints] = np.asarray(values, np.float64)[:, None]
        return replace(self, limits=limits)

    def poses(self, joints: ArrayLike) -> Floats:
        """Return T_world_link (n, l, 4, 4) at joint values (n, j)."""
        return _core.arm_poses(self.links, checked_array("joints", joints, (None, self.n_joints)))


@dataclass(frozen=True, eq=False)
class JointMotion:
    """How an arm gets from one configuration to another, or why it does not.

    Attributes:
        joints: (n, j) waypoints; between them the joints move in proportion. Empty where there is no motion.
        times: (n,) when the arm is there, seconds from 0.
        reason: "" when found, else why not.
        iterations: Growths of the planner's trees; 0 where the direct motion is free.
        nodes: Configurations in the trees.
        checks: Configurations that were tested for collisions.
    """

    joints: Floats
    times: Floats
    reason: str = ""
    iterations: int = 0
    nodes: int = 0
    checks: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", checked_array("joints", self.joints, (None, None)))
        object.__setattr__(self, "times", checked_array("times", self.times, (len(self.joints),)))

    @property
    def found(self) -> bool:
        """Whether there is a motion."""
        return not self.reason

    @property
    def duration(self) -> float:
        """Seconds from first to last configuration; 0 where there is no motion."""
        return float(self.times[-1]) if len(self.times) else 0.0

    def at(self, times: ArrayLike) -> Floats:
        """Return joint values (k, j) at `times` (k,) seconds; before its begin and after its end the arm stands still.

        Raises:
            InputError: There is no motion, or a time is not finite.
        """
        if not self.found:
            raise InputError(f"motion: there is none: {self.reason}")
        moments = checked_array("times", times, (None,))
        return np.stack([np.interp(moments, self.times, column) for column in self.joints.T], axis=1)


def world_around(obj: ObjectLike | None, T_world_object: ArrayLike, support: Support | None) -> World:
    """Return an object placed in the world, with a support given in the world's frame, as the core reads them.

    Raises:
        InputError: `T_world_object` is no rigid motion; see also `graft.motion.plan_motion`.
    """
    pose = checked_pose("T_world_object", T_world_object)
    return nothing_but(support) if obj is None else moved(metric_world(as_object(obj), support), pose)


def plan_joints(
    chain: Chain, world: World, starts: ArrayLike, goals: ArrayLike, config: MotionConfig = DEFAULTS
) -> list[JointMotion]:
    """Plan from each start to the goal of the same index.

    Args:
        chain: The arm.
        world: What it must not touch, see `world_around`.
        starts: (n, j) joint values.
        goals: (n, j) joint values.
        config: How to plan and how fast to move.

    Returns:
        A motion each, or one without waypoints that says why there is none.

    Raises:
        InputError: Joint values that are not finite or too many, a chain that is none.
    """
    begins = checked_array("start joints", starts, (None, chain.n_joints))
    ends = checked_array("goal joints", goals, (len(begins), chain.n_joints))
    try:
        waypoints, rows = _core.plan_arms(
            world=world,
            links=chain.links,
            movers=chain.movers,
            pairs=chain.pairs,
            starts=begins,
            goals=ends,
            settings=config.settings,
        )
    except ValueError as error:
        raise InputError(str(error)) from None
    motions = []
    first = 0
    for i, (outcome, count, iterations, nodes, checks) in enumerate(rows.tolist()):
        reason = _beyond(chain, begins[i], "start") or _beyond(chain, ends[i], "goal")
        reason = reason or config.reason(outcome, iterations, nodes)
        path = waypoints[first : first + count]
        first += count
        if reason:
            motions.append(no_joint_motion(chain, reason, iterations, nodes, checks))
            continue
        steps = np.abs(np.diff(path, axis=0)).max(axis=1) / config.joint_speed
        motions.append(JointMotion(path, np.append(0.0, np.cumsum(steps)), "", iterations, nodes, checks))
    return motions


def no_joint_motion(chain: Chain, reason: str, iterations: int = 0, nodes: int = 0, checks: int = 0) -> JointMotion:
    """Return that there is no motion and why."""
    return JointMotion(np.empty((0, chain.n_joints)), np.empty(0), reason, iterations, nodes, checks)


def clear_joints(chain: Chain, world: World, joints: ArrayLike, slack: float) -> NDArray[np.bool_]:
    """Return which joint values (n, j) keep every contact `slack` metres away: (n,) bool."""
    values = checked_array("joints", joints, (None, chain.n_joints))
    return _core.clear_arms(
        world=world, links=chain.links, movers=chain.movers, pairs=chain.pairs, joints=values, slack=slack
    )


LIMIT_TOLERANCE = 1e-6
"""Joint values may be beyond their limits by this: solvers of inverse kinematics end on them up to rounding."""


def _beyond(chain: Chain, joints: Floats, which: str) -> str:
    low, high = chain.limits.T
    beyond = np.flatnonzero((joints < low - LIMIT_TOLERANCE) | (joints > high + LIMIT_TOLERANCE))
    if not len(beyond):
        return ""
    j = beyond[0]
    return f"{which} beyond the limits of joint {j}: {joints[j]:.3f} of {low[j]:.3f} to {high[j]:.3f}"
