"""Arms as MJCF: what MuJoCo compiles, as links and boxes for the planner."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from graft.checks import Floats, Ints, checked_array
from graft.errors import InputError, MissingExtraError
from graft.grasp import PANDA_HAND, Gripper
from graft.motion.joints import FIXED, HINGE, SLIDE, Chain, clear_joints
from graft.motion.obstacles import nothing_but
from graft.motion.panda import HOME, TCP_SITE, panda_mjcf

UNLIMITED = np.pi
"""A hinge without limits is planned within half a turn to either side, radians."""


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm with a gripper, standing where its model puts it.

    Attributes:
        name: For people.
        model: The compiled `mujoco.MjModel`.
        site: Name of the site whose frame is the gripper frame: z approach, y closing.
        chain: What the planner knows of it; its joints are the model's, fingers included.
        joint_names: Names of the chain's joints.
        arm_joints: Indices of the joints that carry the site; the others are fingers.
        home: (j,) a configuration in which nothing touches that can help it.
    """

    name: str
    model: Any
    site: str
    chain: Chain
    joint_names: tuple[str, ...]
    arm_joints: Ints
    home: Floats

    @property
    def fingers(self) -> Ints:
        """Indices of the joints that do not carry the site."""
        return np.setdiff1d(np.arange(self.chain.n_joints), self.arm_joints)

    def holding(self, opening: float) -> Arm:
        """Return the arm with each finger held at half of `opening` metres, in `home` too."""
        home = self.home.copy()
        home[self.fingers] = opening / 2.0
        return replace(self, chain=self.chain.holding(self.fingers, home[self.fingers]), home=home)


@functools.cache
def panda_arm(gripper: Gripper = PANDA_HAND) -> Arm:
    """Return a Panda built from primitives, standing at the world's origin, its fingers open."""
    half = gripper.stroke / 2.0
    return load_arm(panda_mjcf(gripper), site=TCP_SITE, home=(*HOME, half, half), name="panda")


def load_arm(mjcf: str | Path, *, site: str, home: ArrayLike | None = None, name: str = "arm") -> Arm:
    """Read an arm from an MJCF file, or its text.

    Args:
        mjcf: A path, or text that begins with "<". Joints that carry the site are the arm's; others are fingers, and
            stand at half the opening.
        site: Name of the site whose frame is the gripper frame: z out of the palm, y the direction of closing.
        home: (j,) joint values; the model's reference by default. Boxes that overlap there are taken to do so
            always, as neighbours do.
        name: For people.

    Raises:
        InputError: The model cannot be compiled, has no such site, or has free or ball joints.
        MissingExtraError: MuJoCo is not installed.
    """
    mujoco = mujoco_module("reading an arm")
    try:
        if str(mjcf).lstrip().startswith("<"):
            model = mujoco.MjModel.from_xml_string(str(mjcf))
        else:
            model = mujoco.MjModel.from_xml_path(str(mjcf))
    except ValueError as error:
        raise InputError(f"arm {name!r}: MuJoCo cannot compile it: {error}") from None
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, site)
    if number < 0:
        sites = ", ".join(model.site(i).name for i in range(model.nsite)) or "none"
        raise InputError(f"arm {name!r}: no site {site!r}; its sites are {sites}")
    for j in range(model.njnt):
        if int(model.jnt_type[j]) not in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)):
            raise InputError(f"arm {name!r} joint {model.joint(j).name!r}: expected a hinge or a slide")
    start = checked_array("home", model.qpos0 if home is None else home, (model.njnt,))
    chain = _without_touching(_chain(mujoco, model), start)
    carrying: list[int] = []
    body = int(model.site_bodyid[number])
    while body > 0:
        first = int(model.body_jntadr[body])
        carrying += range(first, first + int(model.body_jntnum[body])) if first >= 0 else ()
        body = int(model.body_parentid[body])
    names = tuple(model.joint(j).name for j in range(model.njnt))
    return Arm(name, model, site, chain, names, np.array(sorted(carrying), np.int64), start)


def mujoco_module(what: str) -> Any:
    """Return the module.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError(what, package="mujoco", extra="sim") from None
    return mujoco


def _chain(mujoco: Any, model: Any) -> Chain:
    """Return links, one for each joint and one for each body without, and boxes around what can collide."""
    parents: list[int] = []
    rests: list[Floats] = []
    kinds: list[int] = []
    axes: list[Floats] = []
    anchors: list[Floats] = []
    last = [-1] * model.nbody  # the link that a body's shapes are on
    for body in range(1, model.nbody):
        rest = _frame(model.body_pos[body], model.body_quat[body])
        parent = last[model.body_parentid[body]]
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for j in range(first, first + max(count, 1)):
            kind, axis, anchor = FIXED, np.zeros(3), np.zeros(3)
            if count:
                slides = int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
                kind, axis, anchor = (SLIDE if slides else HINGE), model.jnt_axis[j], model.jnt_pos[j]
                # MuJoCo's joints are at their reference, not at 0, where the model is drawn.
                rest = rest @ _moved(slides, axis, anchor, -float(model.qpos0[j]))
            parents.append(parent)
            rests.append(rest)
            kinds.append(kind)
            axes.append(np.array(axis))
            anchors.append(np.array(anchor))
            parent, rest = len(parents) - 1, np.eye(4)
        last[body] = parent
    plain = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    geoms = [
        g
        for g in range(model.ngeom)
        if (model.geom_contype[g] or model.geom_conaffinity[g])
        and int(model.geom_type[g]) not in plain
        and model.geom_bodyid[g] > 0
    ]
    frames = [_frame(model.geom_pos[g], model.geom_quat[g]) for g in geoms]
    centers = [f[:3, :3] @ model.geom_aabb[g][:3] + f[:3, 3] for f, g in zip(frames, geoms, strict=True)]
    limits = [model.jnt_range[j] if model.jnt_limited[j] else (-UNLIMITED, UNLIMITED) for j in range(model.njnt)]
    moving = [k for k, g in enumerate(geoms) if model.body_weldid[model.geom_bodyid[g]] > 0]
    return Chain(
        parents=np.array(parents, np.int64),
        rests=np.array(rests),
        kinds=np.array(kinds, np.int64),
        axes=np.array(axes),
        anchors=np.array(anchors),
        limits=np.array(limits),
        box_links=np.array([last[model.geom_bodyid[g]] for g in geoms], np.int64),
        box_centers=np.array(centers),
        box_rotations=np.array([f[:3, :3] for f in frames]),
        box_half_extents=np.array([model.geom_aabb[g][3:] for g in geoms]),
        movers=np.array(moving, np.int64),
        pairs=_pairs(model, geoms),
    )


def _pairs(model: Any, geoms: list[int]) -> Ints:
    """Return pairs that MuJoCo would test: not of one rigid piece, of neighbours, masked or excluded."""
    weld = [int(model.body_weldid[model.geom_bodyid[g]]) for g in geoms]
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    pairs = []
    for a, g in enumerate(geoms):
        for b, h in enumerate(geoms[:a]):
            bodies = int(model.geom_bodyid[g]), int(model.geom_bodyid[h])
            masked = not (
                model.geom_contype[g] & model.geom_conaffinity[h] or model.geom_contype[h] & model.geom_conaffinity[g]
            )
            up = [int(model.body_weldid[model.body_parentid[weld[k]]]) for k in (a, b)]
            neighbours = weld[a] in (weld[b], up[1]) or weld[b] == up[0]
            if not (neighbours or masked or bodies in excluded or bodies[::-1] in excluded):
                pairs.append((b, a))
    return np.array(pairs, np.int64).reshape(-1, 2)


def _without_touching(chain: Chain, joints: Floats) -> Chain:
    """Drop the pairs of boxes that overlap at `joints`."""
    alone = replace(chain, movers=np.empty(0, np.int64))
    kept = [
        pair
        for pair in chain.pairs
        if clear_joints(replace(alone, pairs=pair[None]), nothing_but(None), joints[None], 0.0)[0]
    ]
    return replace(chain, pairs=np.array(kept, np.int64).reshape(-1, 2))


def _frame(position: Floats, quaternion: Floats) -> Floats:
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
    frame[:3, 3] = position
    return frame


def _moved(slides: bool, axis: Floats, anchor: Floats, value: float) -> Floats:
    motion = np.eye(4)
    if slides:
        motion[:3, 3] = value * axis
    else:
        motion[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
        motion[:3, 3] = anchor - motion[:3, :3] @ anchor
    return motion
