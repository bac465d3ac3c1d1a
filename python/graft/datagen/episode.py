"""One run of the gripper with everything that it takes to learn from it and to run it again."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graft import __version__
from graft.checks import Floats, Ints, checked_array
from graft.errors import InputError
from graft.trajectory import Trajectory

Image = NDArray[np.uint8]

SUCCESS = "success"
"""The outcome of an episode that does what its task asks; the others say what failed."""

GYM_TYPE = 2
"""robomimic's number for environments that follow the interface of Gym."""

MAX_SEED = 2**64 - 1
"""Seeds are unsigned and have 64 bits."""

IMAGE_SUFFIX = "_image"
"""What robomimic adds to a camera's name for its images among the observations."""

EVEN_STEPS = 1e-3
"""Steps are even when they differ from their mean by less than this share of it; LeRobot needs even ones."""

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.\-]*")
_VERSIONED = ("numpy", "mujoco")


def current_versions() -> dict[str, str]:
    """Return the versions of what makes episodes: graft, NumPy and, where installed, MuJoCo."""
    versions = {"graft": __version__}
    for package in _VERSIONED:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return versions


@dataclass(frozen=True, eq=False)
class Episode:
    """A run of T steps: observed, acted, recorded.

    Attributes:
        name: Unique in a data set; an episode whose name is there already is not written again.
        trajectory: T steps: targets, reached poses (which are required here), objects, segments.
        actions: (T, A) what the environment was given, in [-1, 1].
        states: (T, s) state of the simulation before each action: put back, it runs the episode again.
        observations: Name -> (T + 1, d): before each action, and after the last. In the order of the names.
        rewards: (T,)
        dones: (T,) 1 where the episode is over after the step.
        model_xml: The simulated scene as MJCF that needs no other file.
        env_args: How the environment is made: `env_name`, `env_kwargs`; `type` is always `GYM_TYPE`.
        seed: From which everything random came.
        outcome: `SUCCESS` or what failed.
        task: What was to be done, in words ("lift the mug").
        source: Name of the demonstration that it was made from; "" for none.
        settings: Everything else that it was made with, as JSON has it.
        versions: Package -> version that made it.
        cameras: Name -> T frames (h, w, 3) of uint8 RGB: an array (T, h, w, 3), or anything that gives them one by one
            each time it is iterated, so that they need not be in memory.
    """

    name: str
    trajectory: Trajectory
    actions: Floats
    states: Floats
    observations: Mapping[str, Floats]
    rewards: Floats
    dones: Ints
    model_xml: str
    env_args: Mapping[str, Any]
    seed: int
    outcome: str
    task: str
    source: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=current_versions)
    cameras: Mapping[str, Iterable[Image]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not self.name:
            raise InputError("episode name: expected a name, got an empty string")
        where, n = f"episode {self.name!r}", len(self.trajectory)
        if self.trajectory.T_world_gripper is None:
            raise InputError(f"{where}: expected the poses that the gripper reached, the trajectory has only targets")
        put(self, "actions", checked_array(f"{where} actions", self.actions, (n, None)))
        if self.actions.size == 0 or np.abs(self.actions).max() > 1:
            raise InputError(f"{where} actions: expected numbers in [-1, 1]")
        put(self, "states", checked_array(f"{where} states", self.states, (n, None)))
        put(self, "rewards", checked_array(f"{where} rewards", self.rewards, (n,)))
        put(self, "dones", checked_array(f"{where} dones", self.dones, (n,), np.int64))
        observations = {
            name: checked_array(f"{where} observation {name!r}", self.observations[name], (n + 1, None))
            for name in sorted(self.observations)
        }
        put(self, "observations", observations)
        if not self.outcome:
            raise InputError(f"{where} outcome: expected a word, got an empty string")
        if not 0 <= self.seed <= MAX_SEED:
            raise InputError(f"{where} seed: expected a whole number from 0 to 2^64 - 1, got {self.seed}")
        put(self, "env_args", {"env_kwargs": {}, **self.env_args, "type": GYM_TYPE})
        if not isinstance(self.env_args.get("env_name"), str):
            raise InputError(f"{where} env_args: expected an env_name, got {self.env_args.get('env_name')!r}")
        put(self, "settings", dict(self.settings))
        put(self, "versions", dict(self.versions))
        put(self, "cameras", {name: self.cameras[name] for name in sorted(self.cameras)})
        self._check_names(where)
        for what in ("env_args", "settings"):
            try:
                json.dumps(getattr(self, what), allow_nan=False)
            except (TypeError, ValueError) as error:
                raise InputError(f"{where} {what}: {error}") from None

    def _check_names(self, where: str) -> None:
        """Names become keys of HDF5 and of LeRobot, where a slash would make a folder."""
        signals = [s.signal for s in self.trajectory.segments if s.signal is not None]
        kinds: dict[str, Iterable[str]] = {
            "observation": self.observations,
            "camera": self.cameras,
            "object": self.trajectory.T_world_object,
            "term signal": signals,
        }
        for kind, names in kinds.items():
            for name in names:
                if not _NAME.fullmatch(name):
                    raise InputError(
                        f"{where} {kind} {name!r}: expected letters, digits, '_', '.' and '-', and no '.' or '-' first"
                    )
        for camera, frames in self.cameras.items():
            if isinstance(frames, Iterator):
                raise InputError(f"{where} camera {camera!r}: expected frames that can be iterated again and again")
            if camera + IMAGE_SUFFIX in self.observations:
                raise InputError(f"{where}: observation {camera + IMAGE_SUFFIX!r} has the name of a camera's images")

    def __len__(self) -> int:
        return len(self.trajectory)

    @property
    def succeeded(self) -> bool:
        """Whether the outcome is `SUCCESS`."""
        return self.outcome == SUCCESS

    @property
    def rate(self) -> float:
        """Steps per second.

        Raises:
            InputError: The steps are not even.
        """
        steps = np.diff(self.trajectory.times)
        if len(steps) == 0:
            raise InputError(f"episode {self.name!r}: a single step has no rate")
        mean = float(steps.mean())
        if np.abs(steps - mean).max() > EVEN_STEPS * mean:
            raise InputError(
                f"episode {self.name!r} times: expected even steps, got {steps.min():.4g} to {steps.max():.4g} s"
            )
        return 1.0 / mean


def checked_frame(where: str, frame: Any, shape: tuple[int, ...] | None) -> Image:
    """Return a camera's frame if it is (h, w, 3) of uint8 and, where given, of the shape of those before it."""
    image = np.asarray(frame)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
        raise InputError(f"{where}: expected (h, w, 3) of uint8, got {image.shape} of {image.dtype}")
    if shape is not None and image.shape != shape:
        raise InputError(f"{where}: expected {shape} as the frames before it, got {image.shape}")
    return image
