import json
import subprocess
import sys

import pytest

from graft import zoo
from graft.cli import EXIT_BAD_INPUT, EXIT_OK, EXIT_USAGE, main
from graft.io import save_demonstration, save_object

HELP_MODULES = ("numpy", "trimesh", "tyro", "mujoco", "viser", "scipy", "rich")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    root = tmp_path_factory.mktemp("cli")
    save_object(root / "kettle.glb", zoo.make("kettle"))
    for category in zoo.demonstrated():
        save_demonstration(root / "demos" / category, zoo.demonstration(category))
    return root


def test_help_lists_the_verbs_without_heavy_imports():
    code = (
        "import sys; from graft.cli import main; code = main(['--help']);"
        f"assert not set({HELP_MODULES}) & set(sys.modules), set({HELP_MODULES}) & set(sys.modules); sys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == EXIT_OK, done.stderr
    for verb in ("demo", "show", "match", "transfer"):
        assert verb in done.stdout


@pytest.mark.parametrize("verb", ["demo", "show", "match", "transfer"])
def test_every_verb_explains_itself(verb, capsys):
    assert main([verb, "--help"]) == EXIT_OK
    assert "--json" in capsys.readouterr().out


def test_no_verb_and_unknown_verbs_are_usage_errors(capsys):
    assert main([]) == EXIT_USAGE
    assert main(["trasfer"]) == EXIT_USAGE
    assert "did you mean 'transfer'" in capsys.readouterr().err
    assert main(["show"]) == EXIT_USAGE
    assert main(["show", "a.glb", "--nonsense"]) == EXIT_USAGE


def test_version(capsys):
    assert main(["--version"]) == EXIT_OK
    assert capsys.readouterr().out.startswith("graft ")


def test_show_prints_parts_and_one_json_document(folder, capsys):
    assert main(["show", str(folder / "kettle.glb")]) == EXIT_OK
    printed = capsys.readouterr().out
    kettle = zoo.make("kettle")
    for name in kettle.part_names:
        assert name in printed
    assert main(["show", str(folder / "kettle.glb"), "--json"]) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    assert [p["name"] for p in document["parts"]] == list(kettle.part_names)
    assert document["scale_to_metres"] == 1.0


def test_match_prints_the_plan(folder, capsys):
    arguments = ["match", str(folder / "demos" / "mug"), str(folder / "kettle.glb")]
    assert main(arguments) == EXIT_OK
    assert "handle" in capsys.readouterr().out
    assert main([*arguments, "--json"]) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    assert len(document["plan"]) == len(document["source_parts"])
    assert {len(row) for row in document["plan"]} == {len(document["target_parts"])}
    assert document["converged"] is True


def test_match_takes_any_object_with_a_part(folder, capsys):
    kettle = str(folder / "kettle.glb")
    assert main(["match", kettle, kettle, "--part", "handle", "--json"]) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    assert document["contact"]["part"] == "handle"
    assert main(["match", kettle, kettle, "--part", "wing"]) == EXIT_BAD_INPUT
    assert "the parts are" in capsys.readouterr().err


def test_transfer_ranks_and_writes_pictures(folder, tmp_path, capsys):
    out = tmp_path / "contacts.png"
    code = main(
        ["transfer", str(folder / "kettle.glb"), "--library", str(folder / "demos"), "-k", "2", "--out", str(out)]
    )
    assert code == EXIT_OK
    assert out.stat().st_size > 1000
    capsys.readouterr()
    assert main(["transfer", str(folder / "kettle.glb"), "--library", str(folder / "demos"), "--json"]) == EXIT_OK
    document = json.loads(capsys.readouterr().out)
    costs = [m["cost"] for m in document["matches"]]
    assert costs == sorted(costs)
    assert len(costs) == 4


@pytest.mark.parametrize(
    ("arguments", "culprit"),
    [
        (["show", "missing.glb"], "missing.glb"),
        (["show", "{root}/empty.glb"], "empty.glb"),
        (["show", "{root}/text.glb"], "text.glb"),
        (["show", "{root}/kettle.glb", "--out", "x.bmp"], "x.bmp"),
        (["match", "{root}/kettle.glb", "{root}/kettle.glb"], "kettle.glb"),
        (["transfer", "{root}/kettle.glb", "--library", "{root}/nowhere"], "nowhere"),
        (["transfer", "{root}/kettle.glb", "--library", "{root}/demos", "-k", "0"], "k"),
        (["transfer", "{root}/kettle.glb", "--library", "{root}/demos", "--eps", "0"], "eps"),
        (["transfer", "{root}/kettle.glb", "--library", "{root}/demos", "--alpha", "2"], "alpha"),
        (["show", "{root}/kettle.glb", "--package", "nonsense"], "--package"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_3(folder, arguments, culprit, capsys):
    (folder / "empty.glb").write_bytes(b"")
    (folder / "text.glb").write_text("this is no model")
    assert main([a.format(root=folder) for a in arguments]) == EXIT_BAD_INPUT
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("graft: ")
    assert len(captured.err.strip().splitlines()) == 1
    assert culprit in captured.err


def test_a_file_that_cannot_be_written_is_bad_input(folder, capsys):
    code = main(["show", str(folder / "kettle.glb"), "--out", str(folder / "none" / "deep" / "x.png")])
    assert code == EXIT_BAD_INPUT
    assert "Traceback" not in capsys.readouterr().err


def test_a_reader_that_goes_away_is_no_error(folder):
    command = f"{sys.executable} -m graft show {folder / 'kettle.glb'} --json | head -c 10"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    command = f"{sys.executable} -m graft show --help | true"
    assert subprocess.run(command, shell=True, capture_output=True, text=True, check=False).stderr == ""
