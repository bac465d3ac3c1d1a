"""Trials of an evaluation: every method on every target in every pose, the same on any number of workers."""

import json

import pytest

pytest.importorskip("mujoco")

from graft.cli import main
from graft.errors import InputError
from graft.evaluate.baselines import RandomPoint
from graft.evaluate.failures import draw_failures
from graft.evaluate.methods import Graft
from graft.evaluate.protocols import Posing, paper
from graft.evaluate.simulation import Arena, PlannerAlone, sensitivity, simulate, simulated_methods
from graft.sim import SimulationConfig

METHODS = [Graft(), RandomPoint(), PlannerAlone()]


@pytest.fixture(scope="module")
def benchmark():
    return paper(Posing(seed=0), variants=1, limit=2)


@pytest.fixture(scope="module")
def arena():
    return Arena(poses=2, settings={"friction 0.3": SimulationConfig(friction=0.3)})


@pytest.fixture(scope="module")
def rows(benchmark, arena):
    return simulate(benchmark, METHODS, arena)


def test_every_method_is_tried_in_every_pose(benchmark, arena, rows):
    expected = [
        (query.key, method.name, pose, setting)
        for query in benchmark.queries
        for method in METHODS
        for pose in range(arena.poses)
        for setting in (("", "friction 0.3") if method.name == "graft" else ("",))
    ]
    assert [(row.query, row.method, row.pose, row.setting) for row in rows] == expected


def test_rows_say_what_was_done(rows):
    for row in rows:
        assert (row.grasp is None) == (row.outcome == "no_grasp") == (row.held is None)
        assert (row.contact is None) == (row.method == "planner alone") == (row.part is None)
        assert row.reason
        json.dumps(row.measured, allow_nan=False)
    ours = [row for row in rows if row.method == "graft" and not row.setting]
    assert all(row.source is not None and row.grasp is not None for row in ours)
    assert all(row.measured["lift"] > 0 for row in ours if row.outcome == "success")


def test_the_same_grasp_is_tried_in_other_physics(rows):
    grasps = {(row.query, row.pose, row.setting): row.grasp for row in rows if row.method == "graft"}
    assert all(grasps[query, pose, ""] == grasp for (query, pose, _), grasp in grasps.items())


def test_sensitivity_changes_one_number_at_a_time():
    base = SimulationConfig()
    for name, config in sensitivity(base).items():
        changed = [key for key, value in config.document().items() if value != base.document()[key]]
        assert changed == [name.split()[0]]


def test_the_table_has_the_paper_s_stand_ins():
    names = [method.name for method in simulated_methods()]
    assert names == ["graft", "whole object + ICP", "random surface point", "planner alone"]


def test_a_killed_run_goes_on(benchmark, arena, rows, tmp_path):
    assert simulate(benchmark, METHODS, arena, out=tmp_path) == rows
    lines = (tmp_path / "rows.jsonl").read_bytes().split(b"\n")
    (tmp_path / "rows.jsonl").write_bytes(lines[0] + b"\n" + lines[1] + b"\n" + lines[2][:100])
    assert simulate(benchmark, METHODS, arena, out=tmp_path) == rows
    with pytest.raises(InputError, match="another"):
        simulate(benchmark, METHODS, Arena(poses=1), out=tmp_path)


@pytest.mark.slow
def test_workers_do_not_change_the_rows(benchmark, arena, rows):
    assert simulate(benchmark, METHODS, arena, workers=2) == rows


@pytest.mark.slow
def test_failures_are_drawn(benchmark, rows, tmp_path):
    # So heavy that nothing holds it: every trial fails and is drawn.
    arena = Arena(poses=1, config=SimulationConfig(mass=20.0))
    failed = simulate(benchmark, [Graft()], arena)
    assert all(row.outcome != "success" for row in failed)
    path = tmp_path / "failures.html"
    draw_failures(path, benchmark, arena, failed, "the table", lambda *_: None)
    page = path.read_text()
    assert page.count("<figure>") == len(failed) == page.count("data:image/png")
    assert "the table" in page


def test_the_command_prints_the_table(capsys):
    assert main(["evaluate", "simulation", "--limit", "1", "--poses", "1", "--workers", "1", "--only-graft"]) == 0
    printed = capsys.readouterr().out
    assert "GRAFT, paper (quoted)" in printed
    assert "graft per object" in printed
    assert main(["evaluate", "simulation", "--poses", "0"]) == 3
