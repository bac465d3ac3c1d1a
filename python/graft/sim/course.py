"""Where the hand is led."""

from __future__ import annotations

import numpy as np

from graft.objects import Floats
from graft.sim.config import SimulationConfig

RAMP = 0.15
"""Seconds in which the lift comes to its speed."""


def ramped(distance: float, speed: float, timestep: float) -> Floats:
    """Return the way gone (n,) after each step: up to `speed` over `RAMP` seconds, and down again at the end.

    A hand that starts at once would ask the pads for more than the object's weight again.
    """
    acceleration = speed / RAMP
    speed = min(speed, float(np.sqrt(acceleration * distance)))  # a short way does not reach the full speed
    ramp = speed / acceleration
    total = distance / speed + ramp
    t = timestep * np.arange(1, int(np.ceil(total / timestep)) + 1)
    late = np.maximum(t - (total - ramp), 0.0)
    early = np.minimum(t, ramp)
    way: Floats = speed * (early**2 / (2 * ramp) + np.maximum(t - ramp, 0.0) - late**2 / (2 * ramp))
    way[t >= total] = distance
    return way


def reached(wanted: Floats, config: SimulationConfig) -> Floats:
    """Return the pose that a hand with `position_noise` and `angle_noise` reaches when it is sent to `wanted`."""
    if config.position_noise == 0 and config.angle_noise == 0:
        return np.array(wanted)
    draws = np.random.default_rng(config.seed).standard_normal(6)
    pose = np.array(wanted)
    pose[:3, 3] += config.position_noise * draws[:3]
    turn = np.radians(config.angle_noise) * draws[3:]
    angle = float(np.linalg.norm(turn))
    if angle > 0:
        pose[:3, :3] = turned(turn / angle, angle) @ pose[:3, :3]
    return pose


def turned(axis: Floats, angle: float) -> Floats:
    """Return the rotation (3, 3) by `angle` radians about the unit vector `axis` (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation
