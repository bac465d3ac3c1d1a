"""What a scripted hand is told: targets and gripper actions at the control rate, in segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graft.checks import Floats
from graft.datagen.config import CONTROL_RATE
from graft.datagen.retarget import HOLD
from graft.datagen.rollout import FINGER_SPEED
from graft.datagen.rotations import interpolated, rotation_about
from graft.grasp import Gripper
from graft.trajectory import CLOSE, DEMONSTRATED, Segment

STRAIGHT_SPEED = 0.2
"""Metres a second of the last centimetres and of the lift."""

LIFT = 0.15
"""Metres that a demonstration lifts by."""

SQUEEZE = 8
"""Actions that the fingers press before the lift, after the time that the whole stroke takes."""

HELD = 10
"""Actions that a demonstration holds at the top, half a second."""

SETTLED = 3
"""Actions that the hand rests at the grasp before it closes."""

TILT = 60.0
"""Degrees that a pour tilts by."""

TILT_SPEED = 40.0
"""Degrees a second, on average."""


@dataclass(frozen=True, eq=False)
class Script:
    """Targets (t, 4, 4) T_world_gripper, gripper actions (t,), and the stretches by name."""

    targets: Floats
    grips: Floats
    segments: tuple[Segment, ...]


def closing_actions(gripper: Gripper) -> int:
    """Return how many actions it takes to close the whole stroke and press."""
    return int(np.ceil(gripper.stroke / 2 / FINGER_SPEED * CONTROL_RATE)) + SQUEEZE


def script(
    transit: Floats, grasp: Floats, before: Floats, grip: float, closing: int, pour: Floats | None = None
) -> Script:
    """Return the script of a lift, or of a lift and a pour.

    Args:
        transit: (t, 4, 4) targets to the pre-grasp, T_world_gripper.
        grasp: (4, 4) where the gripper closes.
        before: (4, 4) the pre-grasp.
        grip: Gripper action on the way.
        closing: Actions that it closes for.
        pour: (3,) horizontal direction in which is poured; None lifts only.
    """
    way = float(np.linalg.norm(grasp[:3, 3] - before[:3, 3]))
    straight = interpolated(before, grasp, max(1, round(way / STRAIGHT_SPEED * CONTROL_RATE)))
    straight = np.concatenate([straight, np.repeat(grasp[None], SETTLED, axis=0)])
    shut = np.repeat(grasp[None], closing, axis=0)
    steps = round(LIFT / STRAIGHT_SPEED * CONTROL_RATE) + 1
    lift = np.repeat(grasp[None], steps, axis=0)
    lift[:, 2, 3] += LIFT * _eased(steps)
    stretches = [("reach", "reached", transit), ("grasp", "grasped", np.concatenate([straight, shut]))]
    stretches.append(("lift", "lifted", lift))
    if pour is not None:
        stretches.append(("pour", "poured", _poured(lift[-1], pour)))
    stretches.append((HOLD, "", np.repeat(stretches[-1][2][-1:], HELD, axis=0)))
    segments, begin = [], 0
    for name, signal, targets in stretches:
        segments.append(Segment(name, begin, begin + len(targets), DEMONSTRATED, signal or None))
        begin += len(targets)
    grips = np.full(begin, CLOSE)
    grips[: len(transit) + len(straight)] = grip
    return Script(np.concatenate([targets for _, _, targets in stretches]), grips, tuple(segments))


def _poured(top: Floats, front: Floats) -> Floats:
    """Return targets that turn the hand at `top` (4, 4) about its TCP so that `front` (3,) sinks."""
    axis = np.cross((0.0, 0.0, 1.0), front / np.linalg.norm(front))
    steps = round(TILT / TILT_SPEED * CONTROL_RATE)
    targets = np.repeat(top[None], steps, axis=0)
    for target, share in zip(targets, _eased(steps), strict=True):
        target[:3, :3] = rotation_about(np.radians(TILT) * share * axis) @ top[:3, :3]
    return targets


def _eased(steps: int) -> Floats:
    """Return shares (steps,) up to 1 along a cosine: the pads need not carry more than the weight at the start."""
    shares: Floats = (1 - np.cos(np.pi * np.arange(1, steps + 1) / steps)) / 2
    return shares
