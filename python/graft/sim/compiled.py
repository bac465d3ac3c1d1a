"""A compiled scene and what a trial asks of it. Compiled once per object, settings and gripper."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from graft.grasp import Gripper
from graft.grasp.conventions import rigid_inverse
from graft.objects import Floats, PartObject
from graft.sim.config import SimulationConfig
from graft.sim.engine import load_mujoco
from graft.sim.poses import get_pose, set_pose
from graft.sim.scene import LINKED, Body, scene_spec

OBJECT, HAND, FINGERS = 0, 7, 14
"""Where the object's, the hand's and the fingers' positions begin in qpos."""

KEPT_SCENES = 8
"""Scenes kept of one object: settings and grippers that take turns."""


class CompiledScene:
    """Model and state of a scene."""

    def __init__(self, body: Body, config: SimulationConfig, gripper: Gripper, looks: PartObject | None = None) -> None:
        self._attach(scene_spec(body, config, gripper, looks).compile(), np.array(body.center_of_mass))

    @classmethod
    def from_xml(cls, xml: str) -> CompiledScene:
        """Return the scene that MJCF text describes, with bodies and actuator named as `scene_spec` names them.

        Raises:
            ValueError: It is no MJCF.
        """
        model = load_mujoco().MjModel.from_xml_string(xml)
        scene = cls.__new__(cls)
        scene._attach(model, np.array(model.body("object").ipos))
        return scene

    def _attach(self, model: Any, center_of_mass: Floats) -> None:
        self.mj = load_mujoco()
        self.model = model
        self.data = self.mj.MjData(self.model)
        self.center_of_mass = center_of_mass
        names = self.mj.mjtObj.mjOBJ_BODY
        ids = {n: self.mj.mj_name2id(self.model, names, n) for n in ("object", "hand", "finger_left", "finger_right")}
        self._thing = ids["object"]
        self._fingers = (ids["finger_left"], ids["finger_right"])
        self._hand = np.array([ids["hand"], *self._fingers])
        self._owner = np.array(self.model.geom_bodyid)
        self._servo = self.mj.mj_name2id(self.model, self.mj.mjtObj.mjOBJ_ACTUATOR, LINKED)
        self._force = np.zeros(6)
        self._clock = 0.0
        self._started = self.data.time

    def place(self, T_world_object: Floats, T_world_hand: Floats, opening: float) -> None:
        """Start anew: the object and the open hand at rest at their poses (4, 4)."""
        self.mj.mj_resetData(self.model, self.data)
        set_pose(self.mj, self.data, T_world_object, OBJECT)
        set_pose(self.mj, self.data, T_world_hand, HAND)
        self.data.qpos[FINGERS:] = opening / 2
        self.data.ctrl[self._servo] = opening / 2
        self.data.mocap_pos[0] = T_world_hand[:3, 3]
        self.lead(T_world_hand[:3, 3], T_world_hand[:3, :3])
        self.mj.mj_forward(self.model, self.data)
        self._clock = 0.0

    def resume(self) -> None:
        """Take the clock as it is: the state was set from outside."""
        self._clock = self.data.time

    def lead(self, place: Floats, rotation: Floats | None = None) -> None:
        """Set where the hand shall be: its place (3,), and its rotation (3, 3) where it changes."""
        self.data.mocap_pos[0] = place
        if rotation is not None:
            self.mj.mju_mat2Quat(self.data.mocap_quat[0], np.ascontiguousarray(rotation).ravel())

    def aim_fingers(self, place: float) -> None:
        """Send each finger to `place` metres from the middle; far beyond closed, they press with the full force."""
        self.data.ctrl[self._servo] = place

    def step(self, count: int) -> None:
        """Simulate `count` steps."""
        self.mj.mj_step(self.model, self.data, count)
        self._clock += count * self.model.opt.timestep

    def object_pose(self) -> Floats:
        """(4, 4) T_world_object."""
        return get_pose(self.mj, self.data, OBJECT)

    def hand_pose(self) -> Floats:
        """(4, 4) T_world_gripper."""
        return get_pose(self.mj, self.data, HAND)

    def object_in_hand(self) -> Floats:
        """(4, 4) T_gripper_object."""
        pose: Floats = rigid_inverse(self.hand_pose()) @ self.object_pose()
        return pose

    def grasp_point_on_object(self) -> Floats:
        """(3,) the TCP in the object's frame."""
        pose = self.object_in_hand()
        point: Floats = -pose[:3, :3].T @ pose[:3, 3]
        return point

    def height(self, point: Floats) -> float:
        """Height of a point (3,) of the object, given in its frame, metres."""
        pose = self.object_pose()
        return float(pose[2, :3] @ point + pose[2, 3])

    def center_height(self) -> float:
        """Height of the object's centre of mass, metres."""
        return self.height(self.center_of_mass)

    def opening(self) -> float:
        """Metres between the pads."""
        return float(self.data.qpos[FINGERS] + self.data.qpos[FINGERS + 1])

    def finger_speed(self) -> float:
        """Metres per second of the faster finger."""
        return float(np.abs(self.data.qvel[12:14]).max())

    def _pairs(self) -> Any:
        """(n, 2) bodies of the contacts that press."""
        contacts = self.data.contact
        pairs = self._owner[contacts.geom]
        return pairs[contacts.efc_address >= 0]

    def hand_touches_object(self) -> bool:
        """Whether any box of the hand touches the object."""
        if self.data.ncon == 0:
            return False
        pairs = self._pairs()
        return bool(((pairs == self._thing).any(axis=1) & np.isin(pairs, self._hand).any(axis=1)).any())

    def hand_touches_table(self) -> bool:
        """Whether any box of the hand touches the table."""
        if self.data.ncon == 0:
            return False
        pairs = self._pairs()
        return bool(((pairs == 0).any(axis=1) & np.isin(pairs, self._hand).any(axis=1)).any())

    def object_touches_table(self) -> bool:
        """Whether the object touches the table."""
        if self.data.ncon == 0:
            return False
        pairs = self._pairs()
        return bool(((pairs == 0).any(axis=1) & (pairs == self._thing).any(axis=1)).any())

    def finger_forces(self) -> tuple[float, float]:
        """Newtons that the fingers at +y and -y press on the object with, along the contacts' normals."""
        forces = [0.0, 0.0]
        if self.data.ncon == 0:
            return 0.0, 0.0
        pairs = self._owner[self.data.contact.geom]
        for index in np.flatnonzero((pairs == self._thing).any(axis=1)):
            for side in (0, 1):
                if self._fingers[side] in pairs[index]:
                    self.mj.mj_contactForce(self.model, self.data, int(index), self._force)
                    forces[side] += float(self._force[0])
        return forces[0], forces[1]

    def trouble(self, fastest: float) -> str:
        """Return what has gone wrong with the numbers; "" when nothing has.

        MuJoCo resets itself silently when it meets NaN: its warnings and its clock tell.
        """
        data = self.data
        if abs(data.time - self._clock) > 1e-6:
            return "the simulation diverged and was reset"
        speed = float(np.abs(data.qvel).max())
        if not speed <= fastest:
            return f"the simulation exploded: {speed:.3g} m/s or rad/s"
        warned = self.warnings()
        return f"the simulator warned of {', '.join(warned)}" if warned else ""

    def warnings(self) -> tuple[str, ...]:
        """Names of the warnings that MuJoCo has counted."""
        counts = self.data.warning.number
        if not counts.any():
            return ()
        kinds = self.mj.mjtWarning
        return tuple(kinds(int(i)).name.removeprefix("mjWARN_").lower() for i in np.flatnonzero(counts))

    @contextmanager
    def quiet(self) -> Iterator[None]:
        """Keep MuJoCo from printing warnings and writing MUJOCO_LOG.TXT: they are in the trial."""
        self.mj.set_mju_user_warning(_ignore)
        try:
            yield
        finally:
            self.mj.set_mju_user_warning(None)


def _ignore(_: str) -> None:
    """Take a warning of MuJoCo; `CompiledScene.warnings` reads the counters."""


_SCENES: weakref.WeakKeyDictionary[Body, dict[tuple[Any, ...], CompiledScene]] = weakref.WeakKeyDictionary()


def compiled_scene(body: Body, config: SimulationConfig, gripper: Gripper) -> CompiledScene:
    """Return the scene for an object, settings and a gripper; the last `KEPT_SCENES` of each object are kept."""
    kept = _SCENES.setdefault(body, {})
    key = (_physics_of(config), _shape_of(gripper))
    scene = kept.pop(key, None) or CompiledScene(body, config, gripper)
    kept[key] = scene
    while len(kept) > KEPT_SCENES:
        del kept[next(iter(kept))]
    return scene


def _physics_of(config: SimulationConfig) -> tuple[Any, ...]:
    """Return the settings that are compiled into a scene."""
    c = config
    return (
        c.friction, c.torsional_friction, c.force, c.mass, c.gravity, c.timestep, c.impratio, c.condim,
        c.contact_solref, c.contact_solimp, c.weld_solref,
    )  # fmt: skip


def _shape_of(gripper: Gripper) -> tuple[Any, ...]:
    """Return what makes two grippers one to the physics: they come from files and processes as equal, not the same."""
    boxes = [*gripper.palm, *gripper.finger]
    arrays = (a.tobytes() for box in boxes for a in (box.center, box.half_extents, box.rotation))
    return (gripper.stroke, gripper.mass, len(gripper.palm), *arrays)
