import json

import pytest

from graft.cli import EXIT_BAD_INPUT, EXIT_OK, EXIT_USAGE, main

FEW = ["--limit", "2", "--workers", "1"]


def test_affordance_prints_one_table(capsys):
    assert main(["evaluate", "affordance", *FEW]) == EXIT_OK
    out = capsys.readouterr().out
    assert "paper: 2 targets" in out
    for name in ("GRAFT, paper (quoted)", "graft ", "whole object + ICP", "random part", "surest answers"):
        assert name in out


def test_json_is_one_document(capsys):
    assert main(["evaluate", "diversity", *FEW, "--k", "2", "--json"]) == EXIT_OK
    found = json.loads(capsys.readouterr().out)
    assert found["protocol"] == "paper"
    assert len(found["diversity"][0]["accuracy"]) == 2


def test_no_table_is_cut(capsys):
    for what, name in (("affordance", "nearest part (six moments)"), ("diversity", "nearest part (six moments)")):
        assert main(["evaluate", what, *FEW]) == EXIT_OK
        out = capsys.readouterr().out
        assert name in out
        assert "\N{HORIZONTAL ELLIPSIS}" not in out


def test_ablation_tells_differences(capsys):
    assert main(["evaluate", "ablation", "--limit", "1", "--workers", "1", "--k", "1"]) == EXIT_OK
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("without EM ") and "+" in line for line in lines)


@pytest.mark.slow
def test_out_gets_rows_table_and_pictures(capsys, tmp_path):
    pytest.importorskip("viser")
    arguments = ["evaluate", "affordance", *FEW, "--categories", "--out", str(tmp_path / "out")]
    assert main(arguments) == EXIT_OK
    first = capsys.readouterr().out
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"rows.jsonl", "evaluation.json", "table.txt", "worst.png", "worst.html"}
    assert (tmp_path / "out" / "table.txt").read_text() in first
    # A second run finds its rows and says the same.
    assert main(arguments) == EXIT_OK
    assert (tmp_path / "out" / "table.txt").read_text() in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--protocol", "within-category"], "expected --objects"),
        (["--objects", "somewhere"], "the paper's protocol runs on the zoo"),
        (["--limit", "0"], "--limit: expected at least 1"),
        (["--protocol", "within-category", "--objects", "/nowhere"], "/nowhere: expected a folder"),
    ],
)
def test_bad_arguments_are_one_line(capsys, arguments, message):
    assert main(["evaluate", "affordance", *arguments]) == EXIT_BAD_INPUT
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1


def test_usage(capsys):
    assert main(["evaluate", "colours"]) == EXIT_USAGE
    assert main(["evaluate", "--help"]) == EXIT_OK
    assert "affordance" in capsys.readouterr().out
