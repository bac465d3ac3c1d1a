"""The paper's table 2: grasps at transferred contacts, executed in physics, beside other ways to choose the place.

Every method says where; the same planner looks for grasps there and the same simulator executes the best one. A target
stands in a stable pose, turned about the vertical and moved at random, once per trial.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from graft.evaluate.baselines import RandomPoint, WholeObject
from graft.evaluate.book import ROWS, Book
from graft.evaluate.methods import Graft, Graphs, Method, Prediction, Predictor
from graft.evaluate.protocols import Benchmark, Query, Subject, stream
from graft.evaluate.runner import described, fit
from graft.evaluate.trials import TrialRow
from graft.evaluate.work import Progress, answered
from graft.graph import PartGraph
from graft.grasp import PANDA_HAND, Grasp, GraspSet, Gripper, in_metres, metric_scale, plan_grasps
from graft.marking import closest_surface_point
from graft.objects import Contact, Floats, PartObject
from graft.sim import PreparedObject, SimulationConfig, Trial, prepare, random_poses, simulate_grasp

PLANNED = 20
"""Grasps that are planned; the best of them is executed."""


@dataclass(frozen=True)
class PlannerAlone:
    """No contact: the planner's best grasp of the whole object. What AnyGrasp does in the paper's table.

    Attributes:
        name: In tables.
        graphs: Not used.
        exchangeable: No.
    """

    name: str = "planner alone"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _NoPlace:
        """Learn nothing."""
        return _NoPlace()


@dataclass(frozen=True)
class _NoPlace:
    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return no contact."""
        return []


def simulated_methods() -> list[Method]:
    """Return graft and what takes its place, in the order of the table."""
    return [Graft(), WholeObject(), RandomPoint(), PlannerAlone()]


@dataclass(frozen=True, eq=False)
class Arena:
    """How trials are run.

    Attributes:
        poses: Trials per target and method.
        gripper: What grasps.
        config: Physics.
        settings: Name -> physics in which graft's grasps are executed once more, to see what the figures depend on.
    """

    poses: int = 12
    gripper: Gripper = PANDA_HAND
    config: SimulationConfig = field(default_factory=SimulationConfig)
    settings: Mapping[str, SimulationConfig] = field(default_factory=dict)


def sensitivity(config: SimulationConfig) -> dict[str, SimulationConfig]:
    """Return variations of the physics, one number at a time: friction, closing force, mass."""
    varied: dict[str, SimulationConfig] = {}
    for friction in (0.3, 0.4, 0.7, 1.0):
        varied[f"friction {friction:g}"] = replace(config, friction=friction)
    for force in (5.0, 10.0, 30.0, 60.0):
        varied[f"force {force:g} N"] = replace(config, force=force)
    for mass in (0.1, 0.2, 0.8, 1.2):
        varied[f"mass {mass:g} kg"] = replace(config, mass=mass)
    return varied


@dataclass(frozen=True, eq=False)
class _Job:
    """What a worker needs; sent to it once."""

    benchmark: Benchmark
    methods: tuple[Method, ...]
    predictors: tuple[Predictor, ...]
    arena: Arena

    def rows(self, number: int) -> list[TrialRow]:
        """Run all trials on the target of query `number`."""
        query, seed = self.benchmark.queries[number], self.benchmark.posing.seed
        subject = self.benchmark.subjects[query.target]
        table = Table.lay(subject, self.arena)
        poses = standing(table, self.arena, seed, query.key)
        rows = []
        for method, predictor in zip(self.methods, self.predictors, strict=True):
            chosen: Prediction | None = None
            settings = {"": self.arena.config} | (dict(self.arena.settings) if method.name == Graft().name else {})
            for turn, pose in enumerate(poses):
                rng = stream(seed, method.name, query.key, turn)
                # Methods that draw give every pose a contact of its own, the others give all of them the same.
                if turn == 0 or method.exchangeable:
                    chosen = next(iter(predictor.predict(query, 1, rng)), None)
                grasps = table.plan(chosen, int(rng.integers(2**31)))
                for setting, config in settings.items():
                    trial = table.execute(grasps, config, pose)
                    source = None if chosen is None or chosen.source is None else self.benchmark.sources[chosen.source]
                    rows.append(
                        TrialRow(
                            method=method.name,
                            setting=setting,
                            query=query.key,
                            category=self.benchmark.category(query.target),
                            pose=turn,
                            source=None if source is None else source.demonstration.name,
                            **table.told(chosen, trial),
                        )
                    )
        return rows


def standing(table: Table, arena: Arena, seed: int, query: str) -> Floats:
    """Return (poses, 4, 4) T_world_object of a query's trials."""
    return random_poses(table.prepared, arena.poses, int(stream(seed, query).integers(2**31)))


@dataclass(frozen=True, eq=False)
class Table:
    """A target on the table, with what is needed to try it.

    Attributes:
        subject: The target.
        prepared: In metres, standing.
        truth: With parts as drawn, metres.
        scale: Metres per unit of the target.
        gripper: What grasps.
        fits: Whether any graspable part can be held.
    """

    subject: Subject
    prepared: PreparedObject
    truth: PartObject
    scale: float
    gripper: Gripper
    fits: bool

    @classmethod
    def lay(cls, subject: Subject, arena: Arena) -> Table:
        """Let a target come to rest and see whether it can be held by a graspable part."""
        prepared, truth = prepare(subject.object, arena.config), in_metres(subject.truth)
        fits = any(
            len(plan_grasps(truth, None, arena.gripper, part=part, support=prepared.support, k=1))
            for part in truth.graspable
        )
        return cls(subject, prepared, truth, metric_scale(subject.object), arena.gripper, fits)

    def plan(self, chosen: Prediction | None, seed: int) -> GraspSet:
        """Plan grasps at a predicted contact, or anywhere when there is none."""
        contact = None
        if chosen is not None:
            part = self.prepared.object.parts[chosen.part]
            point, normal, _ = closest_surface_point(part, self.scale * chosen.point)
            contact = Contact(point, normal, chosen.part, chosen.approach)
        return plan_grasps(
            self.prepared.object, contact, self.gripper, support=self.prepared.support, k=PLANNED, seed=seed
        )

    def execute(self, grasps: GraspSet, config: SimulationConfig, pose: Floats) -> Trial:
        """Try the best grasp with the object at `pose` (4, 4)."""
        if len(grasps):
            return simulate_grasp(self.prepared, grasps[0], config, pose=pose)
        reason = grasps.chief_rejection or "no candidate"
        return Trial.no_grasp(self.prepared.object.name, reason, config)

    def told(self, chosen: Prediction | None, trial: Trial) -> dict[str, Any]:
        """Return what a row says of a trial."""
        obj, grasp = self.prepared.object, trial.grasp
        measured = trial.document()["measurements"]
        return {
            "outcome": trial.outcome.value,
            "reason": trial.reason,
            "part": None if chosen is None else obj.parts[chosen.part].name,
            "right": None if chosen is None else chosen.part in obj.graspable,
            "fits": self.fits,
            "contact": None if chosen is None else tuple((self.scale * chosen.point).tolist()),
            "grasp": None if grasp is None else tuple(tuple(row) for row in grasp.pose.tolist()),
            "held": None if grasp is None else self.holds_graspable(grasp),
            "width": None if grasp is None else grasp.width,
            "distance": None if grasp is None or chosen is None else grasp.distance,
            "measured": {name: value for name, value in measured.items() if value is not None},
        }

    def holds_graspable(self, grasp: Grasp) -> bool:
        """Tell whether the surface nearest to both pads' contacts is that of graspable parts."""
        parts = self.truth.parts
        nearest = [
            int(np.argmin([closest_surface_point(part, contact)[2] for part in parts])) for contact in grasp.contacts
        ]
        return set(nearest) <= set(self.truth.graspable)


def simulate(
    benchmark: Benchmark,
    methods: Sequence[Method],
    arena: Arena,
    *,
    workers: int = 1,
    out: Path | None = None,
    progress: Progress = lambda *_: None,
) -> list[TrialRow]:
    """Execute the grasps that every method leads to, on every target in every pose.

    Args:
        benchmark: Objects, demonstrations, one query per target.
        methods: With unique names.
        arena: How trials are run.
        workers: Processes; the rows do not depend on it.
        out: Folder of `rows.jsonl`; rows found there are not computed again. None keeps nothing.
        progress: Told what is being done.

    Returns:
        Rows in the order of queries, methods, poses, settings.

    Raises:
        InputError: A target cannot be laid on a table, or the file of rows was made with other settings.
        MissingExtraError: The simulator is not installed.
    """
    book = None if out is None else Book.open(out / ROWS, _header(benchmark, methods, arena), TrialRow.read)

    def job() -> _Job:
        predictors = fit(benchmark, methods, workers=workers, progress=progress)
        return _Job(benchmark, tuple(methods), predictors, arena)

    keys = [query.key for query in benchmark.queries]
    return answered(keys, job, book, workers=workers, what="trials", progress=progress)


def _header(benchmark: Benchmark, methods: Sequence[Method], arena: Arena) -> dict[str, Any]:
    """Return what rows depend on."""
    return described(benchmark, methods) | {
        "poses": arena.poses,
        "gripper": arena.gripper.name,
        "config": arena.config.document(),
        "settings": {name: config.document() for name, config in arena.settings.items()},
    }
