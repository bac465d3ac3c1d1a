"""Files that are not what was written: noticed, named, never answered from."""

import json
import shutil

import numpy as np
import pytest
import xxhash
from test_disk import answers, assert_same

from graft.errors import InputError, InputWarning
from graft.library import Library, checkout, drop_damaged, vacuum, verify

SAMPLED = 30
"""Bytes of each file that the default run flips."""


def files_of(path):
    return sorted(p for folder in ("versions", "segments") for p in (path / folder).iterdir())


def newest(path):
    return max((path / "versions").iterdir())


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.filterwarnings("ignore::graft.errors.InputWarning")
def test_every_flipped_byte_is_reported_and_never_given_out(tiny, every):
    truth = tuple(Library.open(tiny))
    costs = answers(Library.open(tiny), truth[0].object)
    rng = np.random.default_rng(0)
    for path in files_of(tiny):
        data = path.read_bytes()
        searched = rng.choice(len(data), SAMPLED, replace=False).tolist()
        for index in range(len(data)) if every else searched:
            bad = bytearray(data)
            bad[index] ^= 1 << int(rng.integers(8))
            path.write_bytes(bad)
            assert any(path.name in problem for problem in verify(tiny).problems), (path, index)
            try:
                library = Library.open(tiny)
                given = tuple(library)
                # Searching takes longer than reading: not after every flip.
                found = answers(library, truth[0].object) if index in searched else costs
            except InputError:
                continue
            if library.version == 3:
                assert_same(given, truth)
                assert found == costs
            else:  # with a warning
                assert path == newest(tiny)
                assert_same(given, truth[:1])
        path.write_bytes(data)
    assert verify(tiny).problems == ()


def test_an_older_version_is_taken_with_a_warning_that_names_the_file(small, pairs):
    newest(small).write_bytes(newest(small).read_bytes()[:-40])
    with pytest.warns(InputWarning, match=r"00000003\.json: damaged.*the version before it is taken"):
        library = Library.open(small)
    assert [d.name for d in library] == [pairs[0][0].name]
    with pytest.raises(InputError, match="version 3 is damaged and nothing is changed: go on from version 2"):
        library.extend_graphs(*zip(pairs[5], strict=True))
    with pytest.raises(InputError, match="version 3 is damaged"):
        vacuum(small, grace=0)
    checkout(small, 2)
    library = Library.open(small)
    library.extend_graphs(*zip(pairs[5], strict=True))
    assert (library.version, len(library)) == (5, 2)
    vacuum(small, grace=0)
    assert verify(small).problems == ()


@pytest.mark.parametrize("table", ["bounds", "parts", "graphs", "objects"])
@pytest.mark.parametrize("harm", ["cut", "emptied", "zeroed", "missing", "grown", "replaced"])
def test_harmed_segments_are_named(small, table, harm, pairs):
    entry = Library.open(small).snapshot.manifest.segments[1]
    path = small / "segments" / entry.files[table].name
    data = path.read_bytes()
    other = small / "segments" / Library.open(small).snapshot.manifest.segments[0].files[table].name
    path.unlink()
    if harm != "missing":
        changed = {"cut": data[:-9], "emptied": b"", "zeroed": bytes(len(data)), "grown": data + b"\0"}
        path.write_bytes(changed.get(harm, other.read_bytes()[: len(data)].ljust(len(data), b"\0")))
    assert any(path.name in problem for problem in verify(small).problems)
    if harm in ("cut", "emptied", "missing", "grown"):
        with pytest.warns(InputWarning, match=path.name):
            assert len(Library.open(small)) == 1
    else:
        library = Library.open(small)
        with pytest.raises(InputError, match=rf"{path.name}: damaged"):
            library.retrieve(pairs[1][1], 2)
    saved = drop_damaged(small)
    assert [d.name for d in Library.open(small)] == [pairs[0][0].name]
    assert saved.manifest.operation == "drop 1 object of damaged segments"
    vacuum(small, grace=0)
    assert verify(small).problems == ()


def test_nothing_is_dropped_from_a_library_that_is_whole(small):
    assert drop_damaged(small).manifest.version == 3


def test_foreign_files_are_reported_and_harmless(small):
    for name in ("versions/notes.txt", "versions/.00000004.json.ab12", "segments/x.parts.arrow", "README"):
        (small / name).write_text("hello")
    report = verify(small)
    assert report.problems == ()
    assert [p.rpartition("/")[2] for p in report.foreign] == ["x.parts.arrow", ".00000004.json.ab12", "notes.txt"]
    assert len(Library.open(small)) == 2


def rewrite(path, **words):
    body, _, _ = path.read_bytes().partition(b"\n")
    body = json.dumps({**json.loads(body), **words}).encode()
    path.write_bytes(body + b"\n" + xxhash.xxh3_128_hexdigest(body).encode() + b"\n")


def test_a_newer_schema_is_refused_and_not_passed_over(small):
    rewrite(newest(small), schema=2)
    with pytest.raises(InputError, match=r"00000003\.json: schema: expected 1, got 2, a newer graft wrote it$"):
        Library.open(small)


@pytest.mark.parametrize("words", [{"format": "other"}, {"segments": [{"id": 3}]}, {"version": 9}, {"colour": 1}])
def test_manifests_of_something_else_are_damaged(small, words):
    rewrite(newest(small), **words)
    with pytest.warns(InputWarning, match=r"00000003\.json: expected"):
        assert Library.open(small).version == 2


def test_no_whole_version_and_no_library_are_errors(small, tmp_path):
    for path in (small / "versions").iterdir():
        path.write_bytes(b"")
    with (
        pytest.warns(InputWarning, match="damaged"),
        pytest.raises(InputError, match="no version of the library is whole"),
    ):
        Library.open(small)
    assert any("no version" in problem for problem in verify(small).problems)
    with pytest.raises(InputError, match="expected a library"):
        verify(tmp_path)
    shutil.rmtree(small / "segments")
    with pytest.raises(InputError, match="no demonstration found"):
        Library.open(small)
