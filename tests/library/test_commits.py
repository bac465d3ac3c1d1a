"""Commits are whole or absent, whatever happens to the writer, and two writers lose nothing."""

import contextlib
import errno
import multiprocessing
import os
import shutil
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from library_workers import append_for_ever, append_some, tetrahedra

from graft.errors import InputError
from graft.library import Library, LibraryChangedError, checkout, compact, files, store, vacuum, verify, versions


@pytest.fixture
def bare(tmp_path):
    return Library.create(tmp_path / "library", descriptor=None, samples=False).path


@pytest.fixture(scope="module")
def processes():
    """Processes that are forked from a clean server which has imported what they need."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["library_workers"])
    return context


@pytest.mark.parametrize("kills", [6, pytest.param(200, marks=pytest.mark.slow)])
def test_a_killed_writer_loses_nothing_that_was_committed(bare, tmp_path, processes, kills):
    rng = np.random.default_rng(0)
    log = tmp_path / "acknowledged"
    for kill in range(kills):
        log.touch()
        before = log.stat().st_size
        writer = processes.Process(target=append_for_ever, args=(bare, log, kill))
        writer.start()
        while log.stat().st_size == before:
            assert writer.is_alive()
            time.sleep(0.001)
        time.sleep(rng.random() * 0.05)
        writer.kill()
        writer.join()
        kept = {d.name for d in Library.open(bare)}
        lines = [line.split() for line in log.read_text().splitlines()]
        acknowledged = {name for line in lines for name in line}
        assert acknowledged <= kept
        # At most the commit under way came through whole without being acknowledged.
        assert len(kept - acknowledged) in (0, 3)
        log.write_text("".join(" ".join(sorted(kept)[i : i + 3]) + "\n" for i in range(0, len(kept), 3)))
        if kill % 20 == 0:
            assert verify(bare).problems == ()
            compact(bare)
            vacuum(bare, grace=0)
    report = verify(bare)
    assert report.problems == ()
    assert len(kept) >= 3 * kills


@pytest.mark.parametrize(("writers", "each"), [(3, 8), pytest.param(4, 250, marks=pytest.mark.slow)])
def test_writers_at_the_same_time_lose_nothing(bare, processes, writers, each):
    running = [processes.Process(target=append_some, args=(bare, w, each)) for w in range(writers)]
    for writer in running:
        writer.start()
    for writer in running:
        writer.join()
    assert [writer.exitcode for writer in running] == [0] * writers
    names = [d.name for d in Library.open(bare)]
    assert sorted(names) == sorted(f"{w}-{n}" for w in range(writers) for n in range(each))
    for w in range(writers):
        own = [name for name in names if name.startswith(f"{w}-")]
        assert own == [f"{w}-{n}" for n in range(each)]
    assert verify(bare).problems == ()


def add(library, name):
    shown, graph = tetrahedra()
    library.extend_graphs([replace(shown, name=name)], [graph])


def test_the_slower_writer_applies_its_change_to_what_the_faster_left(bare):
    one, two = Library.open(bare), Library.open(bare)
    add(one, "a")
    add(two, "b")
    assert [d.name for d in two] == ["a", "b"]
    with pytest.raises(InputError, match="'b' already"):
        add(one, "b")
    one.remove(["b"])
    two.remove(["a"])
    assert [d.name for d in Library.open(bare)] == []
    assert [m.parent for m in versions(bare)] == [0, 1, 2, 3, 4]


def test_a_change_that_no_longer_fits_can_be_tried_again(bare, monkeypatch):
    library = Library.open(bare)
    for name in ("a", "b", "c"):
        add(library, name)
    real = store.commit

    def late(path, change, base=None):
        Library.open(path).remove(["b"])
        return real(path, change, base)

    monkeypatch.setattr("graft.library.compaction.commit", late)
    with pytest.raises(LibraryChangedError, match="another writer changed the library meanwhile, try again"):
        compact(bare)
    monkeypatch.undo()
    assert [d.name for d in Library.open(bare)] == ["a", "c"]
    assert len(verify(bare).foreign) == 0
    assert len(compact(bare).manifest.segments) == 1
    monkeypatch.setattr("graft.library.store.version_numbers", lambda path: [1])
    with pytest.raises(LibraryChangedError):
        checkout(bare, 1)


def test_without_hard_links_versions_are_still_placed_by_one(bare, monkeypatch):
    def no_links(*_):
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr("os.link", no_links)
    library, late = Library.open(bare), Library.open(bare)
    add(library, "a")
    add(late, "b")
    assert [d.name for d in Library.open(bare)] == ["a", "b"]
    report = verify(bare)
    assert (report.problems, report.foreign) == ((), ())


@pytest.mark.parametrize("after", range(12))
def test_a_full_disk_leaves_the_library_as_it_was(bare, monkeypatch, after):
    """The n-th flush to the disk fails: whatever it was of, nothing torn is left."""
    library = Library.open(bare)
    add(library, "a")
    count = iter(range(10**6))
    real = os.fsync

    def full(handle):
        if next(count) == after:
            raise OSError(errno.ENOSPC, "No space left on device")
        real(handle)

    monkeypatch.setattr("os.fsync", full)
    with contextlib.suppress(InputError):
        add(library, "b")
    monkeypatch.undo()
    report = verify(bare)
    assert report.problems == ()
    names = [d.name for d in Library.open(bare)]
    assert names in (["a"], ["a", "b"])
    if names == ["a"]:
        assert report.foreign == ()
    add(Library.open(bare), "c")


@pytest.fixture
def disk(tmp_path):
    """A file system of one megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    if shutil.which("mount") is None or os.geteuid() != 0:
        pytest.skip("mounting needs root")
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(place)], check=False).returncode:
        pytest.skip("mounting is not allowed here")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


def test_a_full_file_system(disk):
    path = Library.create(disk / "library", descriptor=None).path
    library = Library.open(path)

    def fill():
        for number in range(100):
            add(library, str(number))

    with pytest.raises(InputError, match="No space left on device"):
        fill()
    kept = len(Library.open(path))
    assert 0 < kept < 100
    report = verify(path)
    assert (report.problems, report.foreign) == ((), ())


def test_media_that_cannot_be_written_are_read(disk):
    path = Library.create(disk / "library", descriptor=None).path
    add(Library.open(path), "a")
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    library = Library.open(path)
    assert library.retrieve(tetrahedra()[1], 1)[0].demonstration.name == "a"
    assert verify(path).problems == ()
    with pytest.raises(InputError, match="Read-only file system"):
        add(library, "b")


def test_everything_is_on_the_disk_before_its_name_is(bare, tmp_path):
    if shutil.which("strace") is None:
        pytest.skip("strace is not installed")
    code = f"""
        import sys
        sys.path.insert(0, {str(Path(__file__).parent)!r})
        from test_commits import add
        from graft.library import Library
        add(Library.open({str(bare)!r}), "a")
        """
    log = tmp_path / "calls"
    calls = "trace=openat,fsync,link,linkat,unlink,rename"
    command = ["strace", "-f", "-y", "-e", calls, "-o", str(log), sys.executable, "-c", textwrap.dedent(code)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if "ptrace" in done.stderr:
        pytest.skip("tracing is not allowed here")
    assert done.returncode == 0, done.stderr
    lines = [line for line in log.read_text().splitlines() if str(bare) in line]

    def first(*words):
        return next(i for i, line in enumerate(lines) if all(word in line for word in words))

    linked = first("link", '00000002.json"')
    flushed = [first("fsync", f".{table}.arrow>") for table in ("bounds", "parts", "graphs", "objects")]
    folder, draft = first("fsync", "/segments>"), first("fsync", "/versions/.00000002.json")
    named = next(i for i, line in enumerate(lines) if i > linked and "fsync" in line and "/versions>" in line)
    assert max(flushed) < folder < draft < linked < named


@pytest.mark.parametrize("count", [300, pytest.param(100_000, marks=pytest.mark.slow)])
def test_opening_many_libraries_leaks_no_handles(bare, count):
    add(Library.open(bare), "a")
    target = tetrahedra()[1]
    handles = []
    for number in range(count):
        library = Library.open(bare)
        if number % 10 == 0:
            library.retrieve(target, 1)
        if number in (10, count - 1):
            handles.append(len(os.listdir("/proc/self/fd")))
    assert handles[1] <= handles[0] + 1


def test_a_draft_is_never_left_behind(bare, monkeypatch):
    with pytest.raises(FileExistsError):
        files.place_new(bare / "versions" / "00000001.json", b"x")
    assert [p.name for p in (bare / "versions").iterdir()] == ["00000001.json"]
