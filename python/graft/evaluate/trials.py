"""Rows of an evaluation by simulation, and the figures made of them.

A row is one grasp that one method led to, executed once. The paper's classes (table 2): success, no grasp found
near the contact, grasp failure, slippage; and, its own class and always told, unstable.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graft.evaluate.intervals import Estimate, bootstrap_mean
from graft.sim import Outcome

OUTCOMES: Mapping[Outcome, str] = {
    Outcome.SUCCESS: "SR",
    Outcome.NO_GRASP: "AG",
    Outcome.GRASP_FAILURE: "GF",
    Outcome.SLIPPAGE: "SL",
    Outcome.UNSTABLE: "UN",
}
"""Outcome -> the column's head: the paper's words for the first four."""

QUOTED: Mapping[str, float] = {"GRAFT, paper (quoted)": 0.81}
"""Success rates that others published, on their own objects, gripper and physics; not measured here."""


@dataclass(frozen=True)
class TrialRow:
    """One trial.

    Attributes:
        method: What chose the place.
        setting: Which physics; "" for the evaluation's own.
        query: Key of the target.
        category: The target's category.
        pose: Number of the pose in which the target stood.
        outcome: Value of a `graft.sim.Outcome`.
        reason: Why it is no success; "" when it is one.
        source: Name of the demonstration that the contact came from; None when there was none.
        part: Name of the part that the contact lies on; None where the method gives no contact.
        right: Whether that part is graspable; None where the method gives no contact.
        fits: Whether any grasp of a graspable part exists that collides with nothing and that the gripper can open to.
        contact: (3,) where the gripper should close, object frame, metres; None where the method gives none.
        grasp: (4, 4) T_object_gripper as rows, metres; None when none was found.
        held: Whether both pads meet graspable parts; None when no grasp was found.
        width: Between the pads, metres; None when none was found.
        distance: From the contact to the grasp, metres; None without either.
        measured: Name -> what was measured, as `graft.sim.Measurements`.
    """

    method: str
    setting: str
    query: str
    category: str
    pose: int
    outcome: str
    reason: str
    source: str | None
    part: str | None
    right: bool | None
    fits: bool
    contact: tuple[float, ...] | None
    grasp: tuple[tuple[float, ...], ...] | None
    held: bool | None
    width: float | None
    distance: float | None
    measured: dict[str, Any]

    @classmethod
    def read(cls, document: dict[str, Any]) -> TrialRow:
        """Return the row that a line of the file tells."""
        contact, grasp = document["contact"], document["grasp"]
        lists = {
            "contact": None if contact is None else tuple(contact),
            "grasp": None if grasp is None else tuple(tuple(row) for row in grasp),
        }
        return cls(**{**document, **lists})


@dataclass(frozen=True)
class Rate:
    """How the trials of one method, object or setting ended.

    Attributes:
        name: Of the method, object or setting.
        trials: How many.
        counts: Outcome -> how many.
        success: Success rate and its interval, whole targets resampled.
        usable: Rate of successes in which the object is held by a graspable part.
        fitting: The same over the trials whose target the gripper can hold by a graspable part; None without any.
    """

    name: str
    trials: int
    counts: dict[str, int]
    success: Estimate
    usable: Estimate
    fitting: Estimate | None


def rate(name: str, rows: Sequence[TrialRow], seed: int = 0) -> Rate:
    """Return the rate of some rows, of which there is at least one."""
    fitting = [row for row in rows if row.fits]
    return Rate(
        name,
        len(rows),
        {outcome.value: sum(row.outcome == outcome for row in rows) for outcome in OUTCOMES},
        _share(rows, succeeded, seed),
        _share(rows, usable, seed),
        _share(fitting, succeeded, seed) if fitting else None,
    )


def rates_by(rows: Sequence[TrialRow], key: Callable[[TrialRow], str], seed: int = 0) -> list[Rate]:
    """Return one rate per value of `key`, in the order in which the values come."""
    names = dict.fromkeys(key(row) for row in rows)
    return [rate(name, [row for row in rows if key(row) == name], seed) for name in names]


def margins(
    rows: Sequence[TrialRow], reference: str, good: Callable[[TrialRow], bool], seed: int = 0
) -> dict[str, Estimate]:
    """Return by how much the rate of `reference` is above that of every other method, trial by trial.

    The differences are paired: both methods had the same target in the same pose.
    """
    ours = {(row.query, row.pose): good(row) for row in rows if row.method == reference}
    found = {}
    for name in dict.fromkeys(row.method for row in rows if row.method != reference):
        others = [row for row in rows if row.method == name]
        gains = [float(ours[row.query, row.pose]) - float(good(row)) for row in others]
        found[name] = bootstrap_mean(gains, [row.query for row in others], seed=seed)
    return found


def succeeded(row: TrialRow) -> bool:
    """Tell whether the object was held to the end."""
    return row.outcome == Outcome.SUCCESS


def usable(row: TrialRow) -> bool:
    """Tell whether the object was held to the end by a graspable part, so that it can be used."""
    return row.outcome == Outcome.SUCCESS and bool(row.held)


def _share(rows: Sequence[TrialRow], good: Callable[[TrialRow], bool], seed: int) -> Estimate:
    return bootstrap_mean([float(good(row)) for row in rows], [row.query for row in rows], seed=seed)
