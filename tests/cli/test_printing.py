"""What stands in files reaches the terminal as it is: names are no markup, tables are whole, errors are one line."""

import io
import json
import re

import pytest
from rich.console import Console
from rich.table import Table

from graft.cli import EXIT_BAD_INPUT, EXIT_OK, main
from graft.cli.options import fits, print_table, shown, stdout_console

FACES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


@pytest.fixture
def odd(tmp_path):
    path = tmp_path / "odd.obj"
    path.write_text(f"{FACES}o [/]\nf 1 2 3\nf 1 2 4\no [bold]lid[/bold]\nf 1 3 4\no :smile:\nf 2 3 4\n")
    return path


def test_names_that_look_like_markup_are_printed_as_they_are(odd, capsys):
    assert main(["show", str(odd)]) == EXIT_OK
    printed = capsys.readouterr().out
    for name in ("[/]", "[bold]lid[/bold]", ":smile:"):
        assert name in printed
    assert main(["match", str(odd), str(odd), "--part", "[/]"]) == EXIT_OK
    assert "[/] *" in capsys.readouterr().out


def test_control_characters_of_names_do_not_reach_the_terminal():
    assert shown("a\x1b[31mb\nc") == "a\\x1b[31mb\\nc"
    assert shown("tülle 漢") == "tülle 漢"


def test_tables_in_pipes_are_never_cut(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "40")
    name = "a_rather_long_name_of_a_part_that_no_narrow_column_would_hold"
    (tmp_path / "cup.obj").write_text(f"{FACES}o {name}\nf 1 2 3\nf 1 2 4\no lid\nf 1 3 4\n")
    assert main(["show", str(tmp_path / "cup.obj")]) == EXIT_OK
    printed = capsys.readouterr().out
    assert re.search(rf"^{name} +2 ", printed, re.MULTILINE)
    assert "…" not in printed


def test_tables_on_narrow_terminals_fold():
    text = io.StringIO()
    console = Console(file=text, width=20, force_terminal=True, color_system=None)
    table = Table("one", "two", box=None)
    table.add_row("abcdefghijklmnopqrst", "0123456789")
    assert not fits(console, table)
    print_table(console, table)
    assert "…" not in text.getvalue()
    assert set("abcdefghijklmnopqrst0123456789") <= set(text.getvalue())
    assert fits(stdout_console(), table)


def test_a_wide_plan_becomes_pairs_on_a_narrow_terminal(odd, monkeypatch, capsys):
    monkeypatch.setattr("graft.cli.match.fits", lambda console, table: False)
    assert main(["match", str(odd), str(odd), "--part", "0"]) == EXIT_OK
    printed = capsys.readouterr().out
    assert "to part" in printed
    assert "--json" in printed


@pytest.mark.parametrize("json_flag", [[], ["--json"]])
def test_nothing_is_printed_when_a_file_cannot_be_written(odd, tmp_path, json_flag, capsys):
    (tmp_path / "folder.glb").mkdir()
    (tmp_path / "folder.png").mkdir()
    for arguments in (
        ["show", str(odd), "--out", str(tmp_path / "folder.glb")],
        ["match", str(odd), str(odd), "--part", "0", "--out", str(tmp_path / "folder.png")],
    ):
        assert main([*arguments, *json_flag]) == EXIT_BAD_INPUT
        captured = capsys.readouterr()
        assert captured.out == ""
        assert len(captured.err.splitlines()) == 1
        assert "folder." in captured.err


@pytest.mark.parametrize("name", ["a\nb.glb", "a\x1b[31m.glb", "a\rb.obj"])
def test_odd_file_names_leave_the_message_one_line(name, capsys):
    assert main(["show", name]) == EXIT_BAD_INPUT
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert error.rstrip("\n").isprintable()


def test_a_part_is_a_name_first_and_then_a_number(tmp_path, capsys):
    path = tmp_path / "cup.obj"
    path.write_text(f"{FACES}o 1\nf 1 2 3\nf 1 2 4\no 0\nf 1 3 4\n")
    for part, expected in (("1", "1"), ("0", "0")):
        assert main(["match", str(path), str(path), "--part", part, "--json"]) == EXIT_OK
        assert json.loads(capsys.readouterr().out)["demonstrated"]["part"] == expected
    assert main(["match", str(path), str(path), "--part", "²"]) == EXIT_BAD_INPUT
    assert "no part called '²'" in capsys.readouterr().err


def test_a_source_without_a_contact_asks_for_a_part(odd, capsys):
    assert main(["match", str(odd), str(odd)]) == EXIT_BAD_INPUT
    assert "or --part" in capsys.readouterr().err


def test_help_of_a_verb_by_either_word_order(capsys):
    assert main(["help", "show"]) == EXIT_OK
    assert "--scale-to-metres" in capsys.readouterr().out


def test_the_demo_refuses_a_file_before_it_computes(odd, capsys):
    assert main(["demo", "--out", str(odd)]) == EXIT_BAD_INPUT
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "it is a file" in captured.err
