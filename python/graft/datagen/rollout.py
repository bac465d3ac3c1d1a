"""The hand under delta actions, as robosuite's OSC_POSE takes them, and the record of what it did.

An action (7,) in [-1, 1] is a move and a turn of the hand from where it is, in world axes, and what the fingers do.
The hand lags by a third of a step, 17 ms; the next action begins where it is.
All that the controller remembers is in MuJoCo's state, so that a state and the actions after it run again to the bit.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE, LARGEST_MOVE, LARGEST_TURN
from graft.datagen.rotations import rotation_about, rotation_vector
from graft.sim.compiled import CompiledScene
from graft.sim.scene import CLOSED_TARGET
from graft.sim.trial import EXPLODED
from graft.trajectory import DEMONSTRATED

FINGER_SPEED = 0.1
"""Metres a second of each finger's servo; `graft.sim.SimulationConfig.closing_speed`'s default."""

TURNS = 5
"""Physics steps between two orientations on the way of an action; places come at every step."""

ACTIONS = 7
"""Numbers of an action."""


class Diverged(Exception):
    """The simulation's numbers are none, or time ran out."""


Look = Callable[["Rollout"], None]
"""Called after each action."""


class Rollout:
    """One run of a scene.

    Args:
        scene: The scene.
        timeout: Seconds of wall clock.
        look: Told after each action.
    """

    def __init__(self, scene: CompiledScene, timeout: float, look: Look = lambda _: None) -> None:
        self.scene, self._look = scene, look
        self._deadline = time.perf_counter() + timeout
        self._kind = scene.mj.mjtState.mjSTATE_INTEGRATION
        self._size = scene.mj.mj_stateSize(scene.model, self._kind)
        self.stroke = float(2 * scene.model.jnt_range[scene.model.joint("finger_left").id, 1])
        self._servo = scene.model.actuator("fingers").id
        self.steps = round(1 / (CONTROL_RATE * scene.model.opt.timestep))
        self._aim: Floats | None = None
        self.actions: list[Floats] = []
        self.targets: list[Floats] = []
        self.grips: list[float] = []
        self.states: list[Floats] = []
        self.hands: list[Floats] = []
        self.objects: list[Floats] = []
        self.openings: list[float] = []

    def begin(self, T_world_object: Floats, T_world_gripper: Floats, rest: float) -> None:
        """Place object and open hand (4, 4), and let them come to rest for `rest` seconds."""
        self.scene.place(T_world_object, T_world_gripper, self.stroke)
        self._advance(max(1, round(rest / self.scene.model.opt.timestep)))
        self._see()

    def restore(self, state: Floats) -> None:
        """Go to a state that `states` has (s,).

        Raises:
            ValueError: It is of another size.
        """
        if len(state) != self._size:
            raise ValueError(f"expected a state of {self._size} numbers, got {len(state)}")
        self.scene.mj.mj_resetData(self.scene.model, self.scene.data)
        self.scene.mj.mj_setState(self.scene.model, self.scene.data, state, self._kind)
        self.scene.mj.mj_forward(self.scene.model, self.scene.data)
        self.scene.mj.mj_setState(self.scene.model, self.scene.data, state, self._kind)
        self.scene.resume()
        self._see()

    def state(self) -> Floats:
        """Return the state (s,) from which the run goes on to the bit."""
        state = np.empty(self._size)
        self.scene.mj.mj_getState(self.scene.model, self.scene.data, state, self._kind)
        return state

    @property
    def aim(self) -> Floats:
        """(4, 4) where the hand was last wanted, without noise; where it is before the first action."""
        return self.hands[-1] if self._aim is None else self._aim

    def toward(self, target: Floats, grip: float, noise: float = 0.0, rng: Generator | None = None) -> None:
        """Act so that the hand is at `target` (4, 4) next, as far as one action can; noise comes on top, clipped."""
        hand = self.hands[-1]
        action = np.empty(ACTIONS)
        action[:3] = (target[:3, 3] - hand[:3, 3]) / LARGEST_MOVE
        action[3:6] = rotation_vector(target[:3, :3] @ hand[:3, :3].T) / LARGEST_TURN
        action[6] = grip
        if noise > 0 and rng is not None:
            action[:6] += noise * rng.standard_normal(6)
        self._aim = target
        self.act(np.clip(action, -1.0, 1.0))

    def act(self, action: Floats) -> None:
        """Apply an action (7,) and record it, and as target the pose that it sends the hand to.

        Raises:
            Diverged: The numbers explode, MuJoCo warns, or time is up.
        """
        self.states.append(self.state())
        self.actions.append(np.array(action))
        self.grips.append(float(action[6]))
        scene, data = self.scene, self.scene.data
        hand = self.hands[-1]
        place = hand[:3, 3] + LARGEST_MOVE * action[:3]
        rotation = rotation_about(LARGEST_TURN * action[3:6]) @ hand[:3, :3]
        target = np.eye(4)
        target[:3, :3], target[:3, 3] = rotation, place
        self.targets.append(target)
        begin = np.array(data.mocap_pos[0])
        flat = np.empty(9)
        scene.mj.mju_quat2Mat(flat, np.array(data.mocap_quat[0]))
        was = flat.reshape(3, 3)
        turn = rotation_vector(rotation @ was.T)
        fingers = self._fingers(float(action[6]))
        for step in range(1, self.steps + 1):
            share = step / self.steps
            turned = rotation_about(share * turn) @ was if step % TURNS == 0 else None
            scene.lead(begin + share * (place - begin), turned)
            scene.aim_fingers(float(fingers[0] + share * (fingers[1] - fingers[0])))
            scene.step(1)
        self._check()
        self._see()
        self._look(self)

    def _fingers(self, grip: float) -> tuple[float, float]:
        """Return where the servo is and where it goes in one action: on and on inwards to press, else to an opening."""
        now = float(self.scene.data.ctrl[self._servo])
        way = FINGER_SPEED / CONTROL_RATE
        if grip >= 1.0:
            return now, max(now - way, CLOSED_TARGET)
        goal = (1.0 - grip) / 2.0 * self.stroke / 2.0
        now = max(now, 0.0)  # letting go begins at once, however hard it pressed
        return now, float(np.clip(goal, now - way, now + way))

    def _advance(self, count: int) -> None:
        self.scene.step(count)
        self._check()

    def _check(self) -> None:
        trouble = self.scene.trouble(EXPLODED)
        if trouble:
            raise Diverged(trouble)
        if time.perf_counter() > self._deadline:
            raise Diverged("timeout")

    def _see(self) -> None:
        self.hands.append(self.scene.hand_pose())
        self.objects.append(self.scene.object_pose())
        self.openings.append(self.scene.opening())

    def observations(self) -> dict[str, Floats]:
        """Name -> (T + 1, d): places in metres, quaternions wxyz, what lies between the pads in metres."""
        hands, objects = np.array(self.hands), np.array(self.objects)
        return {
            "eef_pos": hands[:, :3, 3],
            "eef_quat": self._quaternions(hands),
            "gripper_opening": np.array(self.openings)[:, None],
            f"{DEMONSTRATED}_pos": objects[:, :3, 3],
            f"{DEMONSTRATED}_quat": self._quaternions(objects),
        }

    def _quaternions(self, poses: Floats) -> Floats:
        result = np.empty((len(poses), 4))
        for row, pose in zip(result, poses, strict=True):
            self.scene.mj.mju_mat2Quat(row, np.ascontiguousarray(pose[:3, :3]).ravel())
        return result


def grip_for(opening: float, stroke: float) -> float:
    """Return the gripper action that holds the pads `opening` metres apart: -1 wide open, below 1 when closed."""
    return float(np.clip(1.0 - 2.0 * opening / stroke, -1.0, np.nextafter(1.0, 0.0)))
