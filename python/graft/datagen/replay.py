"""Run episodes again from their own files: the scene, the first state and the actions, nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graft.datagen.episode import Episode, current_versions
from graft.datagen.judge import AttemptOutcome, Bounds, Judge
from graft.datagen.read import read_episodes
from graft.datagen.rollout import ACTIONS, Diverged, Rollout
from graft.datagen.scene import scene_from_xml
from graft.errors import InputError

SAME = 1e-6
"""Largest difference of a state with which a replay is the same; where the episode was made it is 0."""


@dataclass(frozen=True)
class Replayed:
    """What came of running an episode again.

    Attributes:
        name: Of the episode.
        steps: Actions that were run.
        difference: Largest difference of a number of a state.
        step: In which it was.
        recorded: Outcome in the file.
        outcome: Outcome now.
        reason: What decided it.
        versions: Package -> (made with, run with), where they differ.
    """

    name: str
    steps: int
    difference: float
    step: int
    recorded: str
    outcome: str
    reason: str
    versions: dict[str, tuple[str, str]]

    @property
    def same(self) -> bool:
        """Whether states and outcome are those of the file."""
        return self.difference <= SAME and self.outcome == self.recorded


def replay(path: str | Path, *, episode: int | None = None) -> Iterator[Replayed]:
    """Run the episodes of a file or dataset again, each from its first state by its actions.

    Args:
        path: What `graft.datagen.read.read_episodes` reads.
        episode: Only that one, from 0.

    Raises:
        InputError: No such episode, or one that graft did not generate: another scene, state or action.
        MissingExtraError: mujoco or h5py is not installed.
    """
    path, count = Path(path), 0
    for number, found in enumerate(read_episodes(path)):
        count = number + 1
        if episode is None or number == episode:
            try:
                yield replay_episode(found)
            except InputError as error:
                raise InputError(f"episode {number} {found.name!r}: {error}", path=path) from None
            if number == episode:
                return
    if episode is not None:
        raise InputError(f"no episode {episode}: there are {count}, the first is 0", path=path)


def replay_episode(episode: Episode) -> Replayed:
    """Run an episode again.

    Raises:
        InputError: It is not one that graft generated.
    """
    bounds = _bounds(episode.settings)
    scene = scene_from_xml(episode.model_xml)
    if episode.actions.shape[1] != ACTIONS:
        raise InputError(f"expected actions of {ACTIONS} numbers, got {episode.actions.shape[1]}")
    judge = Judge(bounds)
    rollout = Rollout(scene, float("inf"), judge)
    worst, where = 0.0, 0
    with scene.quiet():
        try:
            rollout.restore(episode.states[0])
            for step, action in enumerate(episode.actions):
                difference = float(np.abs(rollout.state() - episode.states[step]).max())
                if not difference <= worst:
                    worst, where = difference, step
                rollout.act(action)
            outcome, reason = judge.verdict(rollout)
        except ValueError as error:
            raise InputError(f"states: {error}") from None
        except Diverged as trouble:
            outcome, reason = AttemptOutcome.UNSTABLE, str(trouble)
    now = current_versions()
    versions = {name: (made, now.get(name, "none")) for name, made in episode.versions.items() if made != now.get(name)}
    return Replayed(
        episode.name, len(rollout.actions), worst, where, episode.outcome, outcome.value, reason, versions
    )  # fmt: skip


def _bounds(settings: Any) -> Bounds:
    try:
        bounds = dict(settings["bounds"])
        front = bounds.pop("front")
        numbers = {name: float(value) for name, value in bounds.items()}
        return Bounds(**numbers, front=None if front is None else tuple(map(float, front)))
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError("its settings have no bounds of a success: graft did not generate it") from None
