"""The scene of a trial as a MuJoCo model: a table, the object in pieces, a hand that follows a path.

Bits decide what may touch: the object meets the table by its hull alone (a plane touches nothing else of it) and the
hand by its pieces, so that a cup on its foot costs four contacts rather than two for each sector of its wall.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from graft.grasp import Box, Gripper
from graft.objects import Floats, PartObject
from graft.sim.config import SimulationConfig
from graft.sim.engine import load_mujoco

FOOT, PIECE, HAND = 1, 2, 4
"""Collision bits."""

FINGER_MASS = 0.05
"""Kilograms of a finger."""

FINGER_ARMATURE = 0.2
"""Kilograms that the drive adds to a finger (the reflected inertia of motor and gear)."""

FINGER_DAMPING = 30.0
"""Newton seconds per metre: about critical for servo and armature. No more: the contact solver does not see that
implicit integration adds timestep times damping to the inertia, and strong dampers make contacts soft."""

FINGER_STIFFNESS = 2000.0
"""Newtons per metre of the servo that opens the fingers; closing saturates it at the force, whatever the width."""

CLOSED_TARGET = -1.0
"""Metres: a target so far beyond closed that the servo gives its full force at every width."""

GYRATION = 0.05
"""Radius of gyration of the hand, metres; the weld drives it, so that it only has to be of its size."""

STIFF = (0.004, 1.0)
"""solref of the fingers' limits and of their coupling: two steps of 2 ms, the stiffest that MuJoCo takes."""

LINKED = "fingers"
PALETTE = (
    (0.55, 0.63, 0.72, 1), (0.87, 0.60, 0.35, 1), (0.50, 0.68, 0.46, 1), (0.76, 0.47, 0.49, 1),
    (0.60, 0.53, 0.72, 1), (0.80, 0.72, 0.44, 1), (0.45, 0.66, 0.68, 1), (0.72, 0.60, 0.53, 1),
)  # fmt: skip
HAND_COLOR = (0.30, 0.32, 0.35, 1)
PAD_COLOR = (0.12, 0.13, 0.15, 1)
SKY_COLOR = (0.97, 0.97, 0.96)
TABLE_COLOR = (0.90, 0.89, 0.86, 1)


@dataclass(frozen=True, eq=False)
class Body:
    """What physics knows of an object.

    Attributes:
        pieces: (v, 3) corners of each convex piece, object frame, metres.
        hull: (h, 3) corners of the whole's hull.
        center_of_mass: (3,) object frame, metres.
        unit_inertia: (3, 3) about the centre of mass for a mass of 1 kg.
    """

    pieces: tuple[Floats, ...]
    hull: Floats
    center_of_mass: Floats
    unit_inertia: Floats


def scene_spec(body: Body, config: SimulationConfig, gripper: Gripper | None, looks: PartObject | None = None) -> Any:
    """Return the mujoco.MjSpec of a scene.

    Args:
        body: The object.
        config: The settings.
        gripper: The hand; None for an object alone on the table.
        looks: The object to be drawn; pieces and hull stay invisible. None for physics only.
    """
    mj = load_mujoco()
    spec = mj.MjSpec()
    _set_options(spec, config, mj)
    table = spec.worldbody.add_geom(name="table", type=mj.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.05])
    _touch(table, config, contype=0, conaffinity=FOOT | HAND, condim=3)
    table.rgba = TABLE_COLOR
    _add_object(spec, body, config, looks, mj)
    if looks is not None:
        table.size = [0, 0, 0.05]  # without end
        sky = spec.add_texture(name="sky", type=mj.mjtTexture.mjTEXTURE_SKYBOX, width=32, height=192)
        sky.builtin = mj.mjtBuiltin.mjBUILTIN_FLAT
        sky.rgb1 = SKY_COLOR
    if gripper is not None:
        _add_hand(spec, gripper, config, mj)
    return spec


def _set_options(spec: Any, config: SimulationConfig, mj: Any) -> None:
    spec.option.timestep = config.timestep
    spec.option.gravity = [0, 0, -config.gravity]
    spec.option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.impratio = config.impratio
    spec.visual.headlight.ambient = [0.5, 0.5, 0.5]
    spec.visual.headlight.diffuse = [0.5, 0.5, 0.5]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]
    # The shadow map takes five sixths of a frame's time.
    spec.visual.quality.shadowsize = 0


def _touch(geom: Any, config: SimulationConfig, *, contype: int, conaffinity: int, condim: int) -> None:
    geom.contype, geom.conaffinity, geom.condim = contype, conaffinity, condim
    geom.friction = [config.friction, config.torsional_friction, 1e-4]
    geom.solref = config.contact_solref
    geom.solimp = [*config.contact_solimp, 0.5, 2]


def _add_object(spec: Any, body: Body, config: SimulationConfig, looks: PartObject | None, mj: Any) -> None:
    thing = spec.worldbody.add_body(name="object")
    thing.add_freejoint(name="object")
    thing.explicitinertial = True
    thing.mass = config.mass
    thing.ipos = body.center_of_mass
    inertia = body.unit_inertia * config.mass
    thing.fullinertia = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]

    def mesh_geom(name: str, corners: Floats) -> Any:
        spec.add_mesh(name=name, uservert=np.ascontiguousarray(corners, np.float32).ravel())
        geom = thing.add_geom(name=name, type=mj.mjtGeom.mjGEOM_MESH, meshname=name)
        geom.group = 3
        return geom

    _touch(mesh_geom("hull", body.hull), config, contype=FOOT, conaffinity=0, condim=3)
    for index, corners in enumerate(body.pieces):
        _touch(mesh_geom(f"piece_{index}", corners), config, contype=PIECE, conaffinity=0, condim=config.condim)
    for index, part in enumerate(() if looks is None else looks.parts):
        if part.is_point_cloud:
            continue
        name = f"look_{index}"
        # A surface that encloses nothing must not be asked for its volume.
        shell = mj.mjtMeshInertia.mjMESH_INERTIA_SHELL
        vertices = np.ascontiguousarray(part.vertices, np.float32).ravel()
        spec.add_mesh(name=name, uservert=vertices, userface=part.faces.astype(np.int32).ravel(), inertia=shell)
        geom = thing.add_geom(name=name, type=mj.mjtGeom.mjGEOM_MESH, meshname=name)
        geom.contype = geom.conaffinity = 0
        geom.rgba = PALETTE[index % len(PALETTE)]


def _add_hand(spec: Any, gripper: Gripper, config: SimulationConfig, mj: Any) -> None:
    """Add the hand, the body that leads it, and the servo of its fingers."""
    spec.worldbody.add_body(name="path", mocap=True)
    hand = spec.worldbody.add_body(name="hand", gravcomp=1.0)
    hand.add_freejoint(name="hand")
    _weigh(hand, max(gripper.mass - 2 * FINGER_MASS, FINGER_MASS))
    for box in gripper.palm:
        _add_box(hand, box, config, HAND_COLOR, mj)
    tendon = spec.add_tendon(name=LINKED)
    for name, sign in (("finger_left", 1.0), ("finger_right", -1.0)):
        finger = hand.add_body(name=name, gravcomp=1.0)
        _weigh(finger, FINGER_MASS)
        joint = finger.add_joint(name=name, type=mj.mjtJoint.mjJNT_SLIDE, axis=[0, sign, 0])
        joint.limited = mj.mjtLimited.mjLIMITED_TRUE
        joint.range = [0, gripper.stroke / 2]
        joint.solref_limit = STIFF
        joint.armature = FINGER_ARMATURE
        # MjSpec keeps polynomial damping as a vector in newer versions, as a number in older ones.
        joint.damping = (
            [FINGER_DAMPING, *([0.0] * (len(joint.damping) - 1))] if np.ndim(joint.damping) else FINGER_DAMPING
        )
        for index, box in enumerate(gripper.finger):
            geom = _add_box(finger, box if sign > 0 else box.mirrored(), config, HAND_COLOR if index else PAD_COLOR, mj)
            geom.priority = 1
        tendon.wrap_joint(name, 0.5)
    link = spec.add_equality(type=mj.mjtEq.mjEQ_JOINT, objtype=mj.mjtObj.mjOBJ_JOINT)
    link.name1, link.name2 = "finger_left", "finger_right"
    link.data[1] = 1.0
    link.solref = STIFF
    weld = spec.add_equality(type=mj.mjtEq.mjEQ_WELD, objtype=mj.mjtObj.mjOBJ_BODY)
    weld.name1, weld.name2 = "path", "hand"
    weld.solref = config.weld_solref
    # Anchor and relative pose are zero: the hand is led by its own frame; the last number weighs turning.
    weld.data[:10] = 0.0
    weld.data[10] = 1.0
    servo = spec.add_actuator(name=LINKED, trntype=mj.mjtTrn.mjTRN_TENDON, target=LINKED)
    servo.set_to_position(kp=FINGER_STIFFNESS)
    # The tendon hands half of the servo's force to each finger.
    servo.forcelimited = mj.mjtLimited.mjLIMITED_TRUE
    servo.forcerange = [-2 * config.force, 2 * config.force]
    servo.ctrllimited = mj.mjtLimited.mjLIMITED_FALSE


def _weigh(body: Any, mass: float) -> None:
    body.explicitinertial = True
    body.mass = mass
    body.inertia = [mass * GYRATION**2] * 3


def _add_box(body: Any, box: Box, config: SimulationConfig, color: tuple[float, ...], mj: Any) -> Any:
    quaternion = np.empty(4)
    mj.mju_mat2Quat(quaternion, np.ascontiguousarray(box.rotation).ravel())
    geom = body.add_geom(type=mj.mjtGeom.mjGEOM_BOX, pos=box.center, size=box.half_extents, quat=quaternion, rgba=color)
    _touch(geom, config, contype=HAND, conaffinity=PIECE, condim=config.condim)
    return geom
