"""Rates and margins of trials: counted by hand."""

import json
from dataclasses import asdict, replace

import pytest

from graft.evaluate.trials import OUTCOMES, TrialRow, margins, rate, rates_by, steady, succeeded, usable
from graft.sim import Outcome


def row(outcome=Outcome.SUCCESS, *, method="graft", query="mug_0", pose=0, held=True, angle=5.0, fits=True):
    return TrialRow(
        method=method,
        setting="",
        query=query,
        category=query.split("_")[0],
        pose=pose,
        outcome=outcome.value,
        reason="",
        source=None,
        part="handle",
        right=True,
        fits=fits,
        contact=(0.0, 0.0, 0.1),
        grasp=((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        held=held,
        width=0.02,
        distance=0.001,
        measured={"slip_angle": angle} if outcome is Outcome.SUCCESS else {},
    )


def test_a_rate_counts_every_class():
    rows = [row(outcome, query=f"mug_{i}") for i, outcome in enumerate([*Outcome, Outcome.SUCCESS])]
    found = rate("all", rows)
    assert found.trials == 6
    assert found.counts == {outcome.value: 2 if outcome is Outcome.SUCCESS else 1 for outcome in OUTCOMES}
    assert found.success.value == pytest.approx(2 / 6)
    assert found.success.low < found.success.value < found.success.high


def test_usable_and_steady_are_stricter():
    assert succeeded(row(held=False))
    assert not usable(row(held=False))
    assert usable(row())
    assert steady(row(angle=29.0))
    assert not steady(row(angle=31.0))
    assert not any(good(row(Outcome.SLIPPAGE)) for good in (succeeded, usable, steady))


def test_fitting_leaves_out_what_no_gripper_could_hold():
    rows = [row(), row(Outcome.NO_GRASP, query="bowl_0", fits=False)]
    found = rate("all", rows)
    assert found.success.value == 0.5
    assert found.fitting is not None
    assert found.fitting.value == 1.0
    assert rate("none", rows[1:]).fitting is None


def test_rates_come_in_the_order_of_their_rows():
    rows = [row(query="mug_0"), row(query="bag_0"), row(Outcome.SLIPPAGE, query="mug_1")]
    assert [(r.name, r.trials, r.success.value) for r in rates_by(rows, lambda r: r.category)] == [
        ("mug", 2, 0.5),
        ("bag", 1, 1.0),
    ]


def test_margins_are_paired():
    ours = [row(query="mug_0", pose=0), row(query="mug_0", pose=1), row(Outcome.SLIPPAGE, query="bag_0")]
    theirs = [replace(r, method="other", outcome=Outcome.NO_GRASP.value) for r in ours[:2]]
    theirs.append(row(method="other", query="bag_0"))
    found = margins(ours + theirs, "graft", succeeded)
    assert list(found) == ["other"]
    assert found["other"].value == pytest.approx((1 + 1 - 1) / 3)


def test_a_row_survives_its_line():
    for one in (row(), row(Outcome.NO_GRASP), replace(row(), grasp=None, contact=None, held=None, width=None)):
        assert TrialRow.read(json.loads(json.dumps(asdict(one)))) == one
