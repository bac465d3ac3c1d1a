"""Writers that are killed, interrupted at every step, or out of space."""

import random
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from sample_episodes import assert_same, episode

pytest.importorskip("h5py")
pytest.importorskip("av")
pq = pytest.importorskip("pyarrow.parquet")

from graft.datagen.export import open_writer  # noqa: E402
from graft.datagen.read import read_episodes  # noqa: E402
from graft.errors import InputError  # noqa: E402

HERE = Path(__file__).parent
WRITE = """
import sys
sys.path.insert(0, sys.argv[1])
from sample_episodes import episode
from graft.datagen.export import open_writer  # noqa: E402
with open_writer(sys.argv[2]) as writer:
    print("open", flush=True)
    for number in range(int(sys.argv[3])):
        if writer.append(episode(number, cameras=("front",) if number % 2 == 0 and "hdf5" in sys.argv[2] else ())):
            print(number, flush=True)
"""
COUNT = 24


def child(target, count=COUNT):
    return subprocess.Popen(
        [sys.executable, "-c", WRITE, str(HERE), str(target), str(count)], stdout=subprocess.PIPE, text=True
    )


def present(path):
    """Numbers of the episodes that can be read; none where the writer was killed before its first."""
    try:
        return [int(e.name.removeprefix("attempt_")) for e in read_episodes(path)]
    except InputError:
        return []


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("target", ["lift.hdf5", "lift"])
def test_killed_at_any_moment_nothing_finished_is_lost_or_twice(tmp_path, target, kills):
    path, chance, said = tmp_path / target, random.Random(target), set()
    for kill in range(kills):
        writing = child(path)
        assert writing.stdout.readline() == "open\n"
        for _ in range(chance.randrange(3) if kill < kills - 1 else COUNT):  # the last kill hits the closing
            said.update(int(word) for word in writing.stdout.readline().split())
        writing.send_signal(signal.SIGKILL)
        said.update(int(word) for word in writing.stdout.read().split())
        writing.wait()
        writing.stdout.close()
        numbers = present(path)
        assert numbers == list(range(len(numbers)))
        assert said <= set(numbers)
    last = child(path)
    last.communicate()
    assert last.returncode == 0
    found = list(read_episodes(path))
    assert len(found) == COUNT
    for number, got in enumerate(found):
        cameras = ("front",) if number % 2 == 0 and target.endswith("hdf5") else ()
        assert_same(episode(number, cameras=cameras), got)
    assert not [p for p in tmp_path.rglob("*") if p.name.startswith(".") or p.name.endswith(".parts")]


class Crash(BaseException):
    """What happens to a process that is killed: nothing of its own runs after it."""


def crashing_at(monkeypatch, step, *, after):
    """Let the step-th rename be the last thing that the writer does."""
    count, rename = [0], Path.replace

    def replace(self, target):
        count[0] += 1
        if count[0] > step or (count[0] == step and not after):
            raise Crash
        result = rename(self, target)
        if count[0] == step:
            raise Crash
        return result

    monkeypatch.setattr(Path, "replace", replace)
    return count


def write_all(path):
    with open_writer(path) as writer:
        for number in (0, 2):  # of two tasks
            writer.append(episode(number, cameras=("front",)))


def tree(root):
    """Content of every file, HDF5 by its episodes: its bytes have times of objects in them."""
    files = [root] if root.is_file() else sorted(p for p in root.rglob("*") if p.is_file())
    return {str(p.relative_to(root)): p.read_bytes() for p in files if p.suffix not in (".hdf5",)}


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("target", ["lift.hdf5", "lift"])
def test_stopped_at_every_rename_it_ends_as_if_never_stopped(tmp_path, monkeypatch, target, after):
    whole = tmp_path / "whole" / target
    with monkeypatch.context() as patch:
        renames = crashing_at(patch, 1 << 30, after=after)
        write_all(whole)
    assert renames[0] >= 3  # two episodes and, of HDF5, their gathering
    for step in range(1, renames[0] + 1):
        path = tmp_path / f"stopped_{step}" / target
        with monkeypatch.context() as patch:
            crashing_at(patch, step, after=after)
            with pytest.raises(Crash):
                write_all(path)
        write_all(path)
        assert tree(path) == tree(whole)
        for one, other in zip(read_episodes(path), read_episodes(whole), strict=True):
            assert_same(one, other)
        shutil.rmtree(path.parent)


def test_opening_takes_back_what_was_not_finished(tmp_path, monkeypatch):
    path = tmp_path / "lift"
    with open_writer(path) as writer:
        writer.append(episode(0, cameras=("front",)))
    whole = tree(path)
    with monkeypatch.context() as patch:
        crashing_at(patch, 5, after=True)  # stats and info on opening, record, video, steps; not the row
        with pytest.raises(Crash), open_writer(path) as writer:
            writer.append(episode(3, cameras=("front",)))
    assert tree(path).keys() != whole.keys()
    open_writer(path).close()
    assert tree(path).keys() == whole.keys()
    steps = pq.read_table(path / "data/chunk-000/file-000.parquet", partitioning=None)
    assert set(steps["episode_index"].to_pylist()) == {0}
    assert not (path / "graft/chunk-000/file-001.hdf5").exists()


def limited(size):
    """Let no file grow beyond a size: what a full disk does, for one process."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard if size is None else size, hard))


@pytest.mark.parametrize("target", ["lift.hdf5", "lift"])
@pytest.mark.parametrize("size", [500, 3000, 12000])
def test_out_of_space_the_run_stops_says_so_and_resumes(tmp_path, target, size):
    path = tmp_path / target
    options = {"cameras": ("front",)}
    writer = open_writer(path)
    writer.append(episode(0, **options))
    try:
        limited(size)
        with pytest.raises(InputError, match=f"{target}.*: cannot be written: File too large") as error:
            writer.append(episode(1, **options, model_xml="x" * 20000))
    finally:
        limited(None)
    assert "\n" not in str(error.value)
    assert writer.append(episode(1, **options))  # it goes on in the same process
    writer.close()
    with open_writer(path) as writer:  # and in the next
        assert not writer.append(episode(1, **options))
        writer.append(episode(2, **options))
    assert [e.name for e in read_episodes(path)] == [f"attempt_{i:05d}" for i in range(3)]
    assert not [p for p in tmp_path.rglob(".*")]


def test_out_of_space_while_gathering_keeps_the_parts(tmp_path):
    path = tmp_path / "lift.hdf5"
    writer = open_writer(path)
    for number in range(3):
        writer.append(episode(number))
    try:
        limited(20000)
        with pytest.raises(InputError, match=r"lift.hdf5: cannot be written: File too large"):
            writer.close()
    finally:
        limited(None)
    assert not path.exists()
    assert len(list(read_episodes(path))) == 3
    open_writer(path).close()
    assert [p.name for p in tmp_path.iterdir()] == ["lift.hdf5"]
    assert len(list(read_episodes(path))) == 3


MEMORY = """
import sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from sample_episodes import episode
from graft.datagen.export import open_writer  # noqa: E402
from graft.datagen.read import read_episodes  # noqa: E402
from graft.datagen.writers import lerobot
lerobot.DATA_BYTES = lerobot.EPISODES_BYTES = 1 << 16  # so that 150 episodes fill several files
pages = lambda: int(Path("/proc/self/statm").read_text().split()[1]) * 4096
with open_writer(sys.argv[2]) as writer:
    for number in range(500):
        writer.append(episode(number))
        if number == 150:
            before = pages()
    written = pages()
for read in read_episodes(sys.argv[2]):
    pass
print(written - before, pages() - before)
"""
PER_350_EPISODES = 6 << 20
"""Bytes. The arrays of 350 episodes are 6 MB, their files 17 MB: memory that grew with them would show."""

CACHE = 40 << 20
"""Bytes. HDF5 keeps up to 32 MB of metadata of the file that it gathers."""


@pytest.mark.slow
@pytest.mark.parametrize("target", ["lift.hdf5", "lift"])
def test_memory_is_flat_over_500_episodes(tmp_path, target):
    command = [sys.executable, "-c", MEMORY, str(HERE), str(tmp_path / target)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    while_writing, in_all = map(int, done.stdout.split())
    assert while_writing < PER_350_EPISODES
    assert in_all < PER_350_EPISODES + CACHE
