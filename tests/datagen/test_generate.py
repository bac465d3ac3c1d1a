"""Runs of attempts: the same whoever makes them, whatever stops them."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from generation_scenes import library, shown, targets

pytest.importorskip("mujoco")
pytest.importorskip("h5py")

from graft.datagen.config import GenerationConfig
from graft.datagen.generate import EPISODES, FAILURES, generate
from graft.datagen.read import read_episodes
from graft.errors import InputError
from graft.library import Library
from graft.objects import Part, PartObject

HERE = Path(__file__).parent
COUNT = 12
RUN = """
import sys
sys.path.insert(0, sys.argv[1])
from generation_scenes import targets
from graft.datagen.generate import generate
from graft.library import Library
if __name__ == "__main__":
    print("begin", flush=True)
    generate(Library.open(sys.argv[2]), targets(), sys.argv[3], n=int(sys.argv[4]), workers=int(sys.argv[5]),
             progress=lambda tally: print(tally.done, flush=True))
    print("end", flush=True)
"""


def content(out):
    """Name -> states of what was kept, and the failures, each in the order of the files."""
    path = out / EPISODES
    kept = (
        [(e.name, e.seed, e.states.tobytes(), e.actions.tobytes()) for e in read_episodes(path)]
        if path.exists()
        else []
    )
    return kept, (out / FAILURES).read_text()


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    library().save(folder)
    return folder


@pytest.fixture(scope="module")
def whole(saved, tmp_path_factory):
    """A run that nothing stopped, in this process."""
    out = tmp_path_factory.mktemp("whole")
    tally = generate(Library.open(saved), targets(), out, n=COUNT)
    return out, tally


def started(saved, out, workers, count=COUNT):
    script = out.parent / "run.py"
    script.write_text(RUN)
    return subprocess.Popen(
        [sys.executable, str(script), str(HERE), str(saved), str(out), str(count), str(workers)],
        stdout=subprocess.PIPE,
        text=True,
    )


def test_every_attempt_is_an_episode_or_a_failure(whole):
    out, tally = whole
    kept, failures = content(out)
    failed = [json.loads(line) for line in failures.splitlines()]
    assert (tally.done, tally.kept, tally.resumed) == (COUNT, len(kept), 0)
    assert len(kept) + len(failed) == COUNT
    # The wide one is held by no gripper; the two others by any.
    assert [f["object"] for f in failed if f["outcome"] == "no_grasp"] == ["wide"] * 4
    assert len(kept) >= 6
    assert {"reason", "seed", "demonstration"} <= set(failed[0])
    assert not list(out.glob("*.parts"))


def test_any_number_of_workers_makes_the_same(saved, whole, tmp_path):
    with started(saved, tmp_path / "out", 2) as running:
        running.communicate()
    assert running.returncode == 0
    assert content(tmp_path / "out") == content(whole[0])


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("workers", [0, 2])
def test_killed_at_any_moment_it_ends_as_if_never_stopped(saved, tmp_path, workers, kills):
    out, chance, before, killed, count = tmp_path / "out", random.Random(workers), 0, 0, 8 * kills
    for _ in range(kills):
        with started(saved, out, workers, count) as running:
            assert running.stdout.readline() == "begin\n"
            line = running.stdout.readline()
            if line == "end\n":
                break
            # What was told to be finished is not made again.
            assert int(line) > before
            time.sleep(chance.random() * 0.3)
            running.kill()
            rest = [int(word) for word in running.stdout.read().split() if word != "end"]
            before = rest[-1] if rest else int(line)
            killed += 1
    with started(saved, out, workers, count) as last:
        last.communicate()
    assert last.returncode == 0
    assert killed > kills / 2
    generate(Library.open(saved), targets(), tmp_path / "whole", n=count)
    assert content(out) == content(tmp_path / "whole")
    assert not [p for p in out.rglob("*") if p.name.startswith(".") or p.name.endswith(".parts")]


def test_a_run_goes_on_with_more_attempts(saved, whole, tmp_path):
    shown = Library.open(saved)
    first = generate(shown, targets(), tmp_path, n=5)
    again = generate(shown, targets(), tmp_path, n=COUNT)
    assert (first.done, again.resumed, again.fresh) == (5, 5, COUNT - 5)
    kept, failures = content(whole[0])
    found, told = content(tmp_path)
    assert sorted(found) == sorted(kept)
    assert told == failures
    assert generate(shown, targets(), tmp_path, n=COUNT).fresh == 0


def test_half_a_line_is_cut_off_and_made_again(saved, whole, tmp_path):
    shown = Library.open(saved)
    generate(shown, targets(), tmp_path, n=COUNT)
    path = tmp_path / FAILURES
    path.write_bytes(path.read_bytes()[:-20])
    assert generate(shown, targets(), tmp_path, n=COUNT).fresh == 1
    assert content(tmp_path) == content(whole[0])


def test_a_folder_with_another_run_is_refused(saved, tmp_path):
    shown = Library.open(saved)
    generate(shown, targets(), tmp_path, n=1)
    with pytest.raises(InputError, match="the folder has a run with another seed"):
        generate(shown, targets(), tmp_path, n=1, seed=1)
    with pytest.raises(InputError, match="the folder has a run with another config"):
        generate(shown, targets(), tmp_path, n=1, config=GenerationConfig(noise=0))


def test_two_runs_in_one_folder_are_refused(saved, tmp_path):
    with started(saved, tmp_path / "out", 0, count=200) as running:
        assert running.stdout.readline() == "begin\n"
        running.stdout.readline()
        with pytest.raises(InputError, match="another process is writing here"):
            generate(Library.open(saved), targets(), tmp_path / "out", n=1)
        running.kill()


@pytest.mark.parametrize("workers", [0, 1])
def test_a_full_disk_stops_the_run_which_goes_on_when_there_is_room(saved, whole, tmp_path, workers):
    out = tmp_path / "out"
    script = tmp_path / "full.py"
    # Files may not grow beyond this: less than an episode takes.
    script.write_text("import resource, signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n" + RUN.replace(
        'print("begin"', 'resource.setrlimit(resource.RLIMIT_FSIZE, (30000, 30000)); print("begin"'
    ))  # fmt: skip
    arguments = [sys.executable, str(script), str(HERE), str(saved), str(out), str(COUNT), str(workers)]
    ended = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert "cannot be written: File too large" in ended.stderr.splitlines()[-1]
    assert generate(Library.open(saved), targets(), out, n=COUNT).done == COUNT
    assert content(out) == content(whole[0])


def test_a_killed_worker_is_replaced_and_told(saved, tmp_path):
    with started(saved, tmp_path / "out", 1) as running:
        assert running.stdout.readline() == "begin\n"
        running.stdout.readline()
        children = Path(f"/proc/{running.pid}/task/{running.pid}/children")
        if not children.exists():
            running.kill()
            pytest.skip("only Linux tells children")
        # The last child is the worker; before it comes multiprocessing's tracker of resources.
        os.kill(int(children.read_text().split()[-1]), signal.SIGKILL)
        running.communicate()
    assert running.returncode == 0
    failed = [json.loads(line) for line in (tmp_path / "out" / FAILURES).read_text().splitlines()]
    died = [f for f in failed if f["outcome"] == "unstable"]
    assert [f["reason"] for f in died] == ["the worker died with code -9"]
    kept, _ = content(tmp_path / "out")
    assert len(kept) + len(failed) == COUNT


def test_lerobot_is_written_at_the_end(saved, tmp_path):
    pytest.importorskip("av"), pytest.importorskip("pyarrow")
    generate(Library.open(saved), targets()[:2], tmp_path, n=2, format="lerobot")
    names = [e.name for e in read_episodes(tmp_path / EPISODES)]
    assert [e.name for e in read_episodes(tmp_path / "lerobot")] == names
    assert names


def test_an_object_without_volume_fails_alone(saved, tmp_path):
    flat = PartObject("flat", (Part("sheet", np.eye(3), np.array([[0, 1, 2]])),), scale_to_metres=1.0)
    generate(Library.open(saved), [flat, targets()[0]], tmp_path, n=2)
    (failed,) = [json.loads(line) for line in (tmp_path / FAILURES).read_text().splitlines()]
    assert (failed["object"], failed["outcome"]) == ("flat", "invalid")


def test_bad_runs_are_one_line(tmp_path):
    good = library()
    bare = Library()
    bare.add(shown())
    for given, objects, n, line in (
        (Library(), targets(), 1, "library: it is empty"),
        (bare, targets(), 1, "library: no demonstration has a trajectory"),
        (good, [], 1, "objects: expected at least one"),
        (good, targets() + targets(), 1, "'narrow' is there twice"),
        (good, targets(), 0, "n: expected at least 1"),
    ):
        with pytest.raises(InputError, match=line):
            generate(given, objects, tmp_path / "none", n=n)
    assert not (tmp_path / "none").exists()
