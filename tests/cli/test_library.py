"""`graft library`: every verb on a small library, in words and in JSON."""

import json
import shutil

import pytest

from graft import zoo
from graft.cli import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_OK, EXIT_USAGE, main
from graft.io import load_demonstrations, save_demonstration, save_object

VERBS = ("build", "add", "remove", "ls", "show", "explain", "verify", "versions", "checkout", "compact", "vacuum")


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    root = tmp_path_factory.mktemp("library")
    save_object(root / "kettle.glb", zoo.make("kettle"))
    for category in zoo.demonstrated():
        save_demonstration(root / "demos" / category, zoo.demonstration(category))
    save_demonstration(root / "new", zoo.demonstration("mug", 5))
    words = json.loads((root / "new" / "demonstration.json").read_text())
    (root / "new" / "demonstration.json").write_text(
        json.dumps({**words, "name": "new", "metadata": {"licence": "MIT", "tags": ["a", "b"], "gripper_width": 0.03}})
    )
    assert main(["library", "build", str(root / "demos"), "--out", str(root / "lib"), "--workers", "1"]) == EXIT_OK
    return root


@pytest.fixture
def lib(root, tmp_path):
    return str(shutil.copytree(root / "lib", tmp_path / "lib"))


def run(capsys, *words):
    code = main(["library", *map(str, words)])
    return code, capsys.readouterr()


def document(capsys, *words):
    code, said = run(capsys, *words, "--json")
    assert said.err == ""
    return code, json.loads(said.out)


@pytest.mark.parametrize("verb", [*VERBS, "export"])
def test_every_verb_explains_itself(verb, capsys):
    code, said = run(capsys, verb, "--help")
    assert code == EXIT_OK
    assert "--json" in said.out


def test_a_built_library_is_listed_and_built_again_at_once(root, lib, capsys):
    code, listed = document(capsys, "ls", lib)
    names = [row["name"] for row in listed["objects"]]
    assert (code, sorted(names)) == (EXIT_OK, sorted(d.name for d in load_demonstrations(root / "demos")))
    assert all(len(row["id"]) == 32 and row["source"].startswith(str(root)) for row in listed["objects"])
    code, report = document(capsys, "build", root / "demos", "--out", lib)
    assert (code, report["added"], report["skipped"]) == (EXIT_OK, 0, len(names))
    code, said = run(capsys, "ls", lib, "--limit", "2")
    assert "2 of" in said.out
    assert code == EXIT_OK


def test_some_failures_are_exit_code_1(root, lib, tmp_path, capsys):
    bad = tmp_path / "more" / "bad"
    bad.mkdir(parents=True)
    (bad / "demonstration.json").write_text("{}")
    code, said = run(capsys, "build", tmp_path / "more", "--out", lib, "--workers", "1")
    assert code == EXIT_FAILED
    assert f"failed {bad}/demonstration.json: schema: expected 1, got None\n" in said.out
    assert "0 objects added from 1 folders" in said.out


def test_adding_filtering_removing_and_going_back(root, lib, capsys):
    before = document(capsys, "ls", lib)[1]["of"]
    code, added = document(capsys, "add", lib, root / "new")
    assert (code, added["added"], added["objects"]) == (EXIT_OK, ["new"], before + 1)
    for flags in (("--tags", "a", "b"), ("--licence", "MIT"), ("--max-gripper-width", "0.03")):
        assert [row["name"] for row in document(capsys, "ls", lib, *flags)[1]["objects"]] == ["new"]
    shown = next((root / "demos").iterdir())
    assert added["duplicates"] == {}
    shutil.copytree(shown, root / "copy", dirs_exist_ok=True)
    words = json.loads((shown / "demonstration.json").read_text())
    (root / "copy" / "demonstration.json").write_text(json.dumps({**words, "name": "copy"}))
    code, said = run(capsys, "add", lib, root / "copy")
    assert f"note copy is the same as {words['name']}\n" in said.out
    run(capsys, "remove", lib, "copy")
    code, removed = document(capsys, "remove", lib, "new")
    assert removed["objects"] == before
    assert document(capsys, "compact", lib)[1]["objects"] == before
    _, found = document(capsys, "versions", lib)
    version = added["version"]
    assert [v["operation"] for v in found["versions"]][-5:] == ["add 1", "add 1", "remove 1", "remove 1", "compact"]
    code, said = run(capsys, "checkout", lib, version)
    assert said.out == f"version {found['versions'][-1]['version'] + 1} is what version {version} was\n"
    assert document(capsys, "ls", lib)[1]["of"] == before + 1
    assert document(capsys, "vacuum", lib, "--grace", "0")[1]["files"] > 0
    assert len(document(capsys, "versions", lib)[1]["versions"]) == 1
    code, said = run(capsys, "verify", lib)
    assert (code, "every byte is as it was written" in said.out) == (EXIT_OK, True)


def test_damage_is_exit_code_3_until_it_is_dropped(root, lib, capsys, tmp_path):
    run(capsys, "add", lib, root / "new")
    segments = tmp_path / "lib" / "segments"
    newest = max(segments.glob("*.parts.arrow"), key=lambda path: path.stat().st_mtime_ns)
    newest.write_bytes(bytes(newest.stat().st_size))
    code, said = run(capsys, "verify", lib)
    assert code == EXIT_BAD_INPUT
    assert f"damaged {newest}: damaged" in said.out
    code, report = document(capsys, "verify", lib, "--drop-damaged")
    assert (code, report["ok"], len(report["problems"])) == (EXIT_OK, False, 1)
    assert "new" not in [row["name"] for row in document(capsys, "ls", lib)[1]["objects"]]


def test_show_draws_a_sheet_and_prints_contacts(lib, capsys, tmp_path):
    names = [row["name"] for row in document(capsys, "ls", lib)[1]["objects"]]
    out = tmp_path / "sheet.png"
    code, said = run(capsys, "show", lib, names[1], names[0], "--out", out)
    assert code == EXIT_OK
    assert out.read_bytes().startswith(b"\x89PNG")
    assert all(name in said.out for name in names[:2])
    code, shown = document(capsys, "show", lib, names[0])
    assert shown["objects"][0]["contact"]["part"] in shown["objects"][0]["parts"]


def test_explain_says_what_the_runner_up_lacks(root, lib, capsys):
    code, found = document(capsys, "explain", lib, root / "kettle.glb")
    assert code == EXIT_OK
    assert sum(found["terms"].values()) == pytest.approx(found["match"]["cost"])
    more = found["runner_up"]["cost"] - found["match"]["cost"]
    assert sum(found["lacks"].values()) == pytest.approx(more)
    assert sum(pair["demonstrated"] for pair in found["pairs"]) == 1
    code, said = run(capsys, "explain", lib, root / "kettle.glb")
    assert "costs more by" in said.out
    assert found["match"]["source"] in said.out


def test_export_to_parquet_and_folders(lib, capsys, tmp_path):
    import pyarrow.parquet as pq

    before = document(capsys, "ls", lib)[1]
    assert run(capsys, "export", lib, tmp_path / "x.parquet", "--form", "parquet")[0] == EXIT_OK
    table = pq.read_table(tmp_path / "x.parquet")
    assert table["name"].to_pylist() == [row["name"] for row in before["objects"]]
    assert [len(x) // 3 for x in table["extents"].to_pylist()] == [row["parts"] for row in before["objects"]]
    assert run(capsys, "export", lib, tmp_path / "folders")[0] == EXIT_OK
    assert sorted(d.name for d in load_demonstrations(tmp_path / "folders")) == sorted(table["name"].to_pylist())
    code, said = run(capsys, "export", lib, tmp_path / "x.parquet", "--form", "parquet")
    assert (code, said.err) == (EXIT_BAD_INPUT, f"graft: {tmp_path}/x.parquet: it exists, nothing is written\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["ls", "{root}/nowhere"], "nowhere"),
        (["ls", "{root}/lib", "--limit", "0"], "--limit: expected at least 1, got 0"),
        (["remove", "{root}/lib", "nobody"], "no demonstration called 'nobody'"),
        (["show", "{root}/lib", "nobody"], "no demonstration called 'nobody'"),
        (["show", "{root}/lib", "--out", "x.jpg"], "--out: expected a file ending in .png"),
        (["build", "{root}/demos", "--out", "{root}/lib", "--shard", "4"], "--shard: expected i/n, got '4'"),
        (["build", "{root}/demos", "--out", "{root}/lib", "--workers", "0"], "workers: expected at least 1"),
        (["build", "{root}/demos", "--out", "{root}/lib", "--address", "a"], "--address a: expected with --executor"),
        (["build", "{root}/demos", "--out", "{root}/demos"], "demos: expected no such folder or an empty one"),
        (["build", "{root}/no", "--out", "{root}/lib"], "no: expected a folder of demonstrations"),
        (["build", "--out", "{root}/lib"], "expected at least one folder"),
        (["checkout", "{root}/lib", "77"], "no such version"),
        (["verify", "{root}/demos"], "demos: expected a library"),
        (["vacuum", "{root}/lib", "--keep", "0"], "keep: expected at least 1"),
        (["explain", "{root}/lib", "{root}/kettle.glb", "--category", "spoon"], "that fulfils the conditions"),
    ],
)
def test_mistakes_are_one_line(root, capsys, words, message):
    code, said = run(capsys, *(word.format(root=root) for word in words))
    assert code == EXIT_BAD_INPUT
    assert message in said.err
    assert said.err.count("\n") == 1


def test_a_missing_verb_is_a_usage_error(capsys):
    assert run(capsys)[0] == EXIT_USAGE
