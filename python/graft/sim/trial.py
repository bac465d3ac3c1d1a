"""One grasp in physics: approach, close, lift, hold, and on request shake and tilt."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import checked_array, is_rotation
from graft.errors import InputError
from graft.grasp import Grasp
from graft.io import as_object
from graft.objects import Floats
from graft.sim.compiled import CompiledScene, compiled_scene
from graft.sim.config import SimulationConfig
from graft.sim.course import ramped, reached, turned
from graft.sim.outcome import Measurements, Outcome, Trial
from graft.sim.poses import displacement
from graft.sim.prepared import PreparedObject, prepare
from graft.sim.scene import CLOSED_TARGET

CHUNK = 5
"""Steps between two looks at the scene: 10 ms. The path is written at each step of the hand's course."""

LOOKS = 5
"""Looks, together 50 ms, that forces are averaged over."""

STILL = 0.001
"""Metres per second below which closing fingers have come to rest on something."""

SPEED_UP = 0.05
"""Seconds that the fingers have to start moving before standing still means that they hold something."""

CLOSING_MARGIN = 0.25
"""Seconds beyond the pure travel that the fingers may need to close, pushing a loose object along."""

EXPLODED = 30.0
"""Metres or radians per second that nothing in a trial reaches unless its numbers diverge."""

Watch = Callable[[CompiledScene, str], None]
"""Called with the scene and the name of the phase every `CHUNK` steps."""


class _Ended(Exception):
    """The trial is decided."""

    def __init__(self, outcome: Outcome, reason: str) -> None:
        super().__init__(reason)
        self.outcome = outcome
        self.reason = reason


def simulate_grasp(
    obj: Any, grasp: Grasp, config: SimulationConfig | None = None, *, pose: ArrayLike | None = None
) -> Trial:
    """Try a grasp in physics.

    The hand, open by `Gripper.opening_for`, comes from `approach_distance` in a straight line, closes, lifts and
    holds. The trial ends early when its outcome cannot change any more: after the first check failed, or once no
    finger touches the lifted object.

    Args:
        obj: A `PreparedObject` (prepare once for many trials), or anything that `graft.load_object` reads.
        grasp: Object frame, metres; it brings its gripper.
        config: Settings; the defaults when None.
        pose: (4, 4) T_world_object to start from, metres; where the prepared object stands when None.

    Returns:
        The outcome with the numbers behind it. The same arguments give the same bits, but for `wall_seconds`.

    Raises:
        InputError: The grasp's pose is no finite rigid motion, or the force is more than the gripper can give.
        MissingExtraError: mujoco is not installed.
    """
    config = config or SimulationConfig()
    prepared = obj if isinstance(obj, PreparedObject) else prepare(as_object(obj), config)
    return run_trial(prepared, grasp, config, pose=pose)


def run_trial(
    prepared: PreparedObject,
    grasp: Grasp,
    config: SimulationConfig,
    *,
    pose: ArrayLike | None = None,
    watch: Watch | None = None,
    scene: CompiledScene | None = None,
) -> Trial:
    """Try a grasp as `simulate_grasp` does; `watch` sees the scene every `CHUNK` steps, `scene` may have looks."""
    started = time.perf_counter()
    _check_grasp(grasp, config)
    T_world_object = checked_array("pose", prepared.T_world_object if pose is None else pose, (4, 4))
    if not is_rotation(T_world_object[:3, :3]):
        raise InputError("pose: expected a rotation and a translation")
    result = Trial(Outcome.UNSTABLE, "", prepared.object.name, config, grasp=grasp, T_world_object=T_world_object)
    if not prepared.pose.stable:
        return replace(result, reason="no stable resting pose was found", wall_seconds=time.perf_counter() - started)
    run = _Run(scene or compiled_scene(prepared.body, config, grasp.gripper), T_world_object, grasp, config, watch)
    with run.scene.quiet():
        try:
            run.go()
            outcome, reason = Outcome.SUCCESS, "held"
        except _Ended as end:
            outcome, reason = end.outcome, end.reason
    return replace(
        result,
        outcome=outcome,
        reason=reason,
        measurements=Measurements(**run.measured),
        warnings=run.scene.warnings(),
        steps=run.steps,
        wall_seconds=time.perf_counter() - started,
    )


def _check_grasp(grasp: Grasp, config: SimulationConfig) -> None:
    pose = checked_array("grasp pose", grasp.pose, (4, 4))
    if not is_rotation(pose[:3, :3]):
        raise InputError("grasp pose: expected a rotation and a translation")
    if config.force > grasp.gripper.max_force:
        raise InputError(
            f"simulation force: gripper {grasp.gripper.name!r} gives at most {grasp.gripper.max_force:g} N a finger, "
            f"got {config.force:g}"
        )


class _Run:
    """The course of one trial."""

    def __init__(
        self, scene: CompiledScene, start: Floats, grasp: Grasp, config: SimulationConfig, watch: Watch | None
    ) -> None:
        self.scene, self.config, self.watch = scene, config, watch
        self.measured: dict[str, Any] = {}
        self.steps = 0
        self.recent: deque[tuple[float, float]] = deque(maxlen=LOOKS)
        self.deadline = time.perf_counter() + config.timeout
        self.goal = reached(start @ grasp.pose, config)
        self.away = self.goal.copy()
        self.away[:3, 3] -= config.approach_distance * self.goal[:3, 2]
        self.opening = grasp.gripper.opening_for(grasp.width)
        scene.place(start, self.away, self.opening)

    def go(self) -> None:
        """Run all phases; raises `_Ended` where one decides the trial."""
        self._approach()
        self._close()
        self._lift()
        if self.config.shake_amplitude > 0:
            self._shake()
        if self.config.tilt > 0:
            self._tilt()
        self._judge()

    def _approach(self) -> None:
        """Let the object rest, then come in a straight line; what it does before it is touched is its own fault."""
        config, scene = self.config, self.scene
        start = scene.object_pose()
        for what, inside in (("the table", scene.hand_touches_table()), ("the object", scene.hand_touches_object())):
            if inside:
                raise _Ended(Outcome.GRASP_FAILURE, f"the open hand lies in {what} at its pre-grasp")
        self._stay("rest", config.settle_time)
        touched = scene.hand_touches_object()
        self._drift(start, touched)
        steps = self._steps(config.approach_distance / config.approach_speed)
        table = False
        for done in range(0, steps, CHUNK):
            self._glide("approach", self.away, self.goal, done, min(done + CHUNK, steps), steps)
            touched = touched or scene.hand_touches_object()
            table = table or scene.hand_touches_table()
            if not touched:
                self._drift(start, touched)
        moved, turned = displacement(start, scene.object_pose(), scene.center_of_mass)
        self.measured |= {
            "touched_before_closing": touched,
            "pushed_distance": moved,
            "pushed_angle": turned,
            "table_contact": table,
        }

    def _drift(self, start: Floats, touched: bool) -> None:
        moved, turned = displacement(start, self.scene.object_pose(), self.scene.center_of_mass)
        if not touched:
            self.measured |= {"drift_distance": moved, "drift_angle": turned}
            if moved > self.config.drift_distance or turned > self.config.drift_angle:
                reason = f"the object moved {1000 * moved:.1f} mm and {turned:.1f} degrees before it was touched"
                raise _Ended(Outcome.UNSTABLE, reason)

    def _close(self) -> None:
        """Close until the fingers stand still, then squeeze."""
        config, scene = self.config, self.scene
        center = scene.center_height()
        limit = self._steps(self.opening / 2 / config.closing_speed + CLOSING_MARGIN)
        speed_up = self._steps(SPEED_UP)
        for done in range(CHUNK, limit + CHUNK, CHUNK):
            scene.aim_fingers(self.opening / 2 - config.closing_speed * done * config.timestep)
            self._advance("close", CHUNK)
            if done > speed_up and scene.finger_speed() < STILL:
                break
        scene.aim_fingers(CLOSED_TARGET)
        self._stay("squeeze", config.squeeze_time)
        self.held = scene.object_in_hand()
        self.spot = scene.grasp_point_on_object()
        self.heights = (scene.height(self.spot), center)
        self.measured |= {"closed_forces": scene.finger_forces(), "closed_width": scene.opening()}

    def _lift(self) -> None:
        """Lift, check at `secured_height`, hold."""
        config, scene = self.config, self.scene
        self.top = self.goal.copy()
        self.top[2, 3] += config.lift_height
        heights = ramped(config.lift_height, config.lift_speed, config.timestep)
        place = self.goal[:3, 3].copy()
        secured = False
        for done, height in enumerate(heights, start=1):
            place[2] = self.goal[2, 3] + height
            scene.lead(place)
            scene.step(1)
            if done % CHUNK and done < len(heights):
                continue
            self._account("lift", (done - 1) % CHUNK + 1)
            if not secured and height >= config.secured_height:
                self._secure()
                secured = True
            if secured and done % (10 * CHUNK) == 0:
                self._must_touch()
        self._stay("hold", config.hold_time, held=True)

    def _secure(self) -> None:
        """Check that both fingers carry."""
        config = self.config
        forces = self._forces()
        self.measured["secured_forces"] = forces
        if min(forces) <= config.least_force:
            raise _Ended(
                Outcome.GRASP_FAILURE,
                f"after a lift of {1000 * config.secured_height:.0f} mm the fingers carry {forces[0]:.2f} and "
                f"{forces[1]:.2f} N",
            )

    def _shake(self) -> None:
        """Move to and fro along x, y and z, three periods each."""
        config = self.config
        steps = self._steps(3 / config.shake_frequency)
        for axis in range(3):
            for done in range(1, steps + 1):
                offset = config.shake_amplitude * np.sin(2 * np.pi * 3 * done / steps)
                place = self.top[:3, 3].copy()
                place[axis] += offset
                self.scene.lead(place)
                self._advance("shake", 1, look=done % CHUNK == 0)
                if done % (10 * CHUNK) == 0:
                    self._must_touch()

    def _tilt(self) -> None:
        """Turn the hand to both sides about the horizontal direction across its approach, and back."""
        config = self.config
        across = np.cross(self.top[:3, 2], (0.0, 0.0, 1.0))
        across = self.top[:3, 0] if np.linalg.norm(across) < 0.1 else across / np.linalg.norm(across)
        for begin, end in ((0.0, config.tilt), (config.tilt, -config.tilt), (-config.tilt, 0.0)):
            steps = self._steps(abs(end - begin) / config.tilt_speed)
            for done in range(CHUNK, steps + CHUNK, CHUNK):
                angle = np.radians(begin + (end - begin) * min(done, steps) / steps)
                self.scene.lead(self.top[:3, 3], turned(across, angle) @ self.top[:3, :3])
                self._advance("tilt", CHUNK)
                if done % (10 * CHUNK) == 0:
                    self._must_touch()

    def _judge(self) -> None:
        """Compare the end with what was secured."""
        config, scene = self.config, self.scene
        forces = self._forces()
        rise = scene.height(self.spot) - self.heights[0]
        now = scene.object_in_hand()
        slip, angle = displacement(self.held, now, self.spot)
        self.measured |= {
            "final_forces": forces,
            "lift": config.lift_height,
            "rise": rise,
            "center_rise": scene.center_height() - self.heights[1],
            "slip_distance": slip,
            "slip_angle": angle,
        }
        if min(forces) <= config.least_force:
            raise _Ended(Outcome.SLIPPAGE, f"at the end the fingers carry {forces[0]:.2f} and {forces[1]:.2f} N")
        if rise < config.least_rise * config.lift_height:
            raise _Ended(
                Outcome.SLIPPAGE, f"it rose {1000 * rise:.0f} mm of {1000 * config.lift_height:.0f} mm of lift"
            )
        if scene.object_touches_table():
            raise _Ended(Outcome.SLIPPAGE, "it still touches the table")
        if slip > config.slip_distance:
            raise _Ended(Outcome.SLIPPAGE, f"it slipped {1000 * slip:.1f} mm between the fingers")
        if angle > config.slip_angle:
            raise _Ended(Outcome.SLIPPAGE, f"it turned {angle:.0f} degrees in the hand")

    def _forces(self) -> tuple[float, float]:
        """Return the mean forces of the last looks: while a rounded handle turns, contacts come and go."""
        left, right = np.mean(self.recent, axis=0)
        return float(left), float(right)

    def _must_touch(self) -> None:
        """End the trial when no finger touches the object: nothing brings it back."""
        if max(self._forces()) == 0.0:
            raise _Ended(Outcome.SLIPPAGE, f"lost after {self.steps * self.config.timestep:.2f} s")

    def _glide(self, phase: str, begin: Floats, end: Floats, first: int, last: int, steps: int) -> None:
        """Lead the hand from step `first` to `last` of `steps` on a line: a new place at every step, no jerk."""
        direction = (end[:3, 3] - begin[:3, 3]) / steps
        for step in range(first + 1, last + 1):
            self.scene.lead(begin[:3, 3] + step * direction)
            self.scene.step(1)
        self._account(phase, last - first)

    def _stay(self, phase: str, seconds: float, *, held: bool = False) -> None:
        steps = self._steps(seconds)
        for done in range(0, steps, CHUNK):
            self._advance(phase, min(CHUNK, steps - done))
            if held and done % (10 * CHUNK) == 0:
                self._must_touch()

    def _advance(self, phase: str, steps: int, *, look: bool = True) -> None:
        self.scene.step(steps)
        self._account(phase, steps, look=look)

    def _account(self, phase: str, steps: int, *, look: bool = True) -> None:
        """Count steps, look for trouble, show the scene."""
        self.steps += steps
        if not look:
            return
        self.recent.append(self.scene.finger_forces())
        if self.watch is not None:
            self.watch(self.scene, phase)
        trouble = self.scene.trouble(EXPLODED)
        if trouble:
            raise _Ended(Outcome.UNSTABLE, f"{trouble} in the phase {phase!r}")
        if time.perf_counter() > self.deadline:
            raise _Ended(Outcome.UNSTABLE, f"timeout: more than {self.config.timeout:g} s")

    def _steps(self, seconds: float) -> int:
        return max(1, round(seconds / self.config.timestep))
