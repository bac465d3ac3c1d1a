"""Methods of generation, compared on the same attempts."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

from graft import zoo
from graft.cli import EXIT_OK, main
from graft.datagen.config import GenerationConfig
from graft.datagen.scripted import demonstrate
from graft.errors import InputError
from graft.evaluate.generation import GRAFT, Field, GenerationRow, above, evaluate_generation, generation_methods, rate
from graft.library import Library


@pytest.fixture(scope="module")
def field() -> Field:
    library = Library()
    library.add(demonstrate(zoo.demonstration("wine_bottle")))
    return Field(library, (zoo.make("shampoo"),), 2)


def row(method: str, query: str, attempt: int, outcome: str, seconds: float = 1.0) -> GenerationRow:
    return GenerationRow(method, query, attempt, "source", outcome, "", outcome == "success", seconds)


def test_methods_differ_by_their_switches_alone() -> None:
    methods = generation_methods(GenerationConfig(noise=0.02))
    told = {name: (c.select, c.anchor, c.reach) for name, c in methods.items()}
    assert told == {
        "graft": ("graft", "grasp", "rrt"),
        "anchor only": ("graft", "grasp", "linear"),
        "reach only": ("graft", "object", "rrt"),
        "neither": ("graft", "object", "linear"),
        "vanilla": ("random", "object", "linear"),
    }
    plain = {replace(c, select="graft", anchor="grasp", reach="rrt") for c in methods.values()}
    assert plain == {methods[GRAFT]}


def test_rows_are_kept_and_not_made_again(field: Field, tmp_path: Path) -> None:
    rows = evaluate_generation(field, out=tmp_path)
    assert [(r.method, r.attempt) for r in rows] == [(m, a) for a in range(2) for m in field.methods]
    assert all(r.outcome == "success" for r in rows if r.method == GRAFT)
    # Seconds differ when they are measured again.
    assert evaluate_generation(field, out=tmp_path) == rows
    with pytest.raises(InputError, match="rows made with another seed"):
        evaluate_generation(replace(field, seed=1), out=tmp_path)


def test_rates_count_what_was_kept() -> None:
    rows = [row("graft", "a", 0, "success"), row("graft", "a", 1, "slippage"), row("graft", "b", 0, "success")]
    found = rate("graft", rows)
    assert found.success.value == pytest.approx(2 / 3)
    assert found.counts == {"success": 2, "slippage": 1}
    assert found.seconds_per_kept == 1.5
    assert rate("none", rows[1:2]).seconds_per_kept is None


def test_methods_are_compared_attempt_by_attempt() -> None:
    rows = [row("graft", "a", 0, "success"), row("graft", "b", 0, "success")]
    rows += [row("vanilla", "a", 0, "success"), row("vanilla", "b", 0, "no_motion")]
    assert above(rows, "vanilla").value == 0.5
    assert above(rows[:3], "vanilla").value == 0.0


def test_the_verb_prints_and_writes(field: Field, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import trimesh

    (tmp_path / "objects").mkdir()
    trimesh.creation.cylinder(0.025, 0.15).export(tmp_path / "objects" / "tube.ply")
    field.library.save(tmp_path / "library")
    run = ["evaluate", "generation", "--objects", str(tmp_path / "objects"), "--library", str(tmp_path / "library")]
    assert main([*run, "--n", "1", "--workers", "1", "--out", str(tmp_path / "out")]) == EXIT_OK
    out = capsys.readouterr().out
    assert "graft above vanilla" in out
    told = json.loads((tmp_path / "out" / "evaluation.json").read_text())
    assert [m["name"] for m in told["methods"]] == list(field.methods)
