"""Many trials: the same for any number of workers, taken up again, and nobody stops the run."""

from __future__ import annotations

import json
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from sim_scenes import box, grasp

from graft.errors import InputError
from graft.sim import Job, MujocoSimulator, Outcome, SimulationConfig, Trial, prepare, random_poses, simulate_grasps

DIES, HANGS, RAISES = 3, 5, 6


@dataclass(frozen=True)
class Treacherous:
    """A simulator that dies, hangs or raises at some seeds."""

    name: str = "treacherous"

    def simulate(self, prepared, grasp, config, *, pose=None) -> Trial:
        if config.seed == DIES:
            os._exit(7)
        if config.seed == HANGS:
            time.sleep(600)
        if config.seed == RAISES:
            raise ValueError("inside")
        return MujocoSimulator().simulate(prepared, grasp, config, pose=pose)


@pytest.fixture(scope="module")
def jobs() -> list[Job]:
    slim, wide = prepare(box(0.05, 0.05, 0.1)), prepare(box(0.06, 0.03, 0.08))
    made = [
        Job(f"{name}/{i}", thing, grasp((0, 0, 0.065)), SimulationConfig(hold_time=0.1), pose)
        for name, thing in (("slim", slim), ("wide", wide))
        for i, pose in enumerate(random_poses(thing, 5, 1))
    ]
    return [*made, Job("none", slim, None, reason="nothing near")]


def documents(trials: list[Trial]) -> list[dict]:
    return [trial.document(timing=False) for trial in trials]


def test_workers_change_nothing(jobs: list[Job], tmp_path: Path) -> None:
    here = simulate_grasps(jobs, workers=0, out=tmp_path / "0.jsonl")
    there = simulate_grasps(jobs, workers=2, out=tmp_path / "2.jsonl")
    assert documents(here) == documents(there)
    assert [trial.outcome for trial in here] == [Outcome.SUCCESS] * 10 + [Outcome.NO_GRASP]
    assert here[-1].reason == "nothing near"
    lines = [[json.loads(line) for line in (tmp_path / f"{n}.jsonl").read_bytes().splitlines()] for n in (0, 2)]
    assert [line["key"] for line in lines[0]] == [job.key for job in jobs]
    for a, b in zip(*lines, strict=True):
        assert a | {"wall_seconds": 0} == b | {"wall_seconds": 0}


def test_a_broken_run_is_taken_up(jobs: list[Job], tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    whole = simulate_grasps(jobs, workers=0, out=path)
    data = path.read_bytes()
    third = data.splitlines(keepends=True)[:3]
    path.write_bytes(b"".join(third) + b'{"key": "slim/3", "outc')
    seen: list[tuple[int, int]] = []
    again = simulate_grasps(jobs, workers=0, out=path, progress=lambda *done: seen.append(done))
    assert documents(again) == documents(whole)
    # Three trials and the one without a grasp were there before the first was simulated.
    assert (seen[0], seen[-1], len(seen)) == ((4, 11), (11, 11), 8)
    assert sorted(json.loads(line)["key"] for line in path.read_bytes().splitlines()) == sorted(j.key for j in jobs)


def test_other_settings_do_not_mix(jobs: list[Job], tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    simulate_grasps(jobs[:1], workers=0, out=path)
    heavier = [replace(jobs[0], config=SimulationConfig(mass=0.5))]
    with pytest.raises(InputError, match=r"line 1: the trial 'slim/0' was made with another"):
        simulate_grasps(heavier, workers=0, out=path)
    anew = simulate_grasps(heavier, workers=0, out=path, resume=False)
    assert anew[0].config.mass == 0.5
    assert len(path.read_bytes().splitlines()) == 1


def test_what_is_no_file_of_trials_is_named(jobs: list[Job], tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    path.write_text("hello\n")
    with pytest.raises(InputError, match=r"trials.jsonl: line 1: expected a trial"):
        simulate_grasps(jobs, workers=0, out=path)


def test_death_and_hanging_are_outcomes(jobs: list[Job], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graft.sim.runner.GRACE", 0.5)
    config = SimulationConfig(hold_time=0.1, timeout=2)
    hard = [replace(jobs[0], key=f"{seed}", config=replace(config, seed=seed)) for seed in range(8)]
    trials = simulate_grasps(hard, workers=2, simulator=Treacherous())
    for seed, reason in ((DIES, "the worker died with code 7"), (HANGS, "timeout"), (RAISES, "ValueError: inside")):
        assert trials[seed].outcome is Outcome.UNSTABLE
        assert reason in trials[seed].reason
    assert [t.outcome for i, t in enumerate(trials) if i not in (DIES, HANGS, RAISES)] == [Outcome.SUCCESS] * 5


def test_keys_are_unique(jobs: list[Job]) -> None:
    with pytest.raises(InputError, match="unique keys, got 'slim/0' twice"):
        simulate_grasps([jobs[0], jobs[0]], workers=0)
