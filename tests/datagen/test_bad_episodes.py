import json
import shutil

import numpy as np
import pytest
from sample_episodes import episode

h5py = pytest.importorskip("h5py")
pytest.importorskip("av")

from graft.datagen.episode import Episode  # noqa: E402
from graft.datagen.export import export_episodes, open_writer  # noqa: E402
from graft.datagen.read import read_episodes  # noqa: E402
from graft.errors import InputError  # noqa: E402


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good")
    for target in ("a.hdf5", "a"):
        with open_writer(folder / target) as writer:
            for number in range(2):
                writer.append(episode(number, cameras=("front",)))
    return folder


def replaced(key, value):
    def change(file):
        del file[f"data/demo_1/{key}"]
        if value is not None:
            file[f"data/demo_1/{key}"] = value

    return change


def holed(key, row):
    def change(file):
        file[f"data/demo_1/{key}"][row] = np.nan

    return change


def elsewhere(file):
    del file["data/demo_1/actions"]
    file["data/demo_1/actions"] = h5py.ExternalLink("/etc/passwd", "/x")


def outside(file):
    del file["data/demo_1/states"]
    file["data/demo_1"].create_dataset("states", (11, 13), "f8", external=[("/etc/passwd", 0, 11 * 13 * 8)])


def huge(file):
    del file["data/demo_1/rewards"]
    file["data/demo_1"].create_dataset("rewards", (1 << 40,), "f8", chunks=(1 << 10,))


def newer(file):
    file["data/demo_1"].attrs["graft_schema"] = 99


def unmade(file):
    del file["data"].attrs["env_args"]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (holed("actions", (3, 1)), r"/data/demo_1/actions: expected finite numbers, got nan at \[3, 1\]"),
        (holed("obs/object_pose", (10, 5)), r"/data/demo_1/obs/object_pose: expected finite numbers, got nan"),
        (holed("datagen_info/eef_pose", (2, 0, 0)), r"datagen_info/eef_pose: expected finite numbers"),
        (replaced("actions", None), "/data/demo_1/actions: expected an array, there is none"),
        (replaced("actions", np.zeros((10, 7))), r"/data/demo_1/actions: expected shape \(11, n\), got \(10, 7\)"),
        (replaced("actions", np.full((11, 7), 2.0)), r"actions: expected numbers in \[-1, 1\]"),
        (replaced("states", "words"), "/data/demo_1/states: expected numbers, got object"),
        (
            replaced("datagen_info", None),
            "demo_1: no datagen_info, which has the poses; MimicGen's prepare_src_dataset",
        ),
        (replaced("datagen_info/target_pose", np.zeros((11, 4, 4))), "T_world_target: expected rotations"),
        (replaced("datagen_info/object_poses/table", np.zeros((3, 4, 4))), r"object_poses/table: expected shape"),
        (replaced("datagen_info/gripper_action", np.zeros((11, 2))), r"gripper_action: expected shape \(11, 1\)"),
        (elsewhere, "/data/demo_1/actions: links to other places are not followed"),
        (outside, "/data/demo_1/states: arrays kept in other files are not read"),
        (huge, "/data/demo_1/rewards: larger than the"),
        (newer, "demo_1: schema 99, a newer graft than this one"),
        (unmade, "data: no attribute env_args"),
        (lambda file: file.move("data", "other"), "no group 'data', .* found mask, other"),
    ],
)
def test_broken_hdf5_is_one_line_with_file_and_key(tmp_path, good, change, match):
    path = tmp_path / "broken.hdf5"
    shutil.copy(good / "a.hdf5", path)
    with h5py.File(path, "a") as file:
        change(file)
    with pytest.raises(InputError, match=match) as error:
        list(read_episodes(path))
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("content", "match"),
    [(b"", "the file is empty"), (b"hello", "not an HDF5 file, or a broken one"), (None, "truncated HDF5 file")],
)
def test_files_that_are_none(tmp_path, good, content, match):
    path = tmp_path / "a.hdf5"
    path.write_bytes((good / "a.hdf5").read_bytes()[:5000] if content is None else content)
    with pytest.raises(InputError, match=f"a.hdf5: {match}"):
        list(read_episodes(path))
    with pytest.raises(InputError, match=f"a.hdf5: {match}"):
        open_writer(path)


@pytest.mark.parametrize("share", np.linspace(0.02, 0.98, 25).tolist())
def test_flipped_bytes_never_give_anything_but_one_line(tmp_path, good, share):
    path, data = tmp_path / "a.hdf5", bytearray((good / "a.hdf5").read_bytes())
    rng = np.random.default_rng(int(1000 * share))
    middle = int(share * len(data))
    data[middle : middle + 64] = rng.bytes(64)
    path.write_bytes(data)
    lines = []
    try:
        for found in read_episodes(path):
            for camera in found.cameras.values():
                list(camera)
    except InputError as error:
        lines.append(str(error))
    assert not any("\n" in line for line in lines)


def test_other_datasets_are_left_alone(tmp_path):
    theirs = tmp_path / "theirs.hdf5"
    with h5py.File(theirs, "w") as file:
        file["data/demo_0/actions"] = np.zeros((3, 2))
    with pytest.raises(InputError, match=r"theirs.hdf5: graft did not write this file; nothing is added to it"):
        open_writer(theirs)
    with h5py.File(theirs) as file:
        assert list(file["data/demo_0"]) == ["actions"]
    root = tmp_path / "theirs"
    (root / "meta").mkdir(parents=True)
    (root / "meta/info.json").write_text(json.dumps({"codebase_version": "v3.0", "features": {}}))
    with pytest.raises(InputError, match="graft did not write this dataset"):
        open_writer(root)
    with pytest.raises(InputError, match="graft did not write this dataset: it lacks the states"):
        list(read_episodes(root))
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["info.json", "meta", "theirs", "theirs.hdf5"]
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "me.png").write_bytes(b"x")
    with pytest.raises(InputError, match=r"holds other files, nothing is written: me.png"):
        open_writer(tmp_path / "photos")


def test_a_broken_lerobot_dataset(tmp_path, good):
    def broken(name):
        shutil.copytree(good / "a", tmp_path / name)
        return tmp_path / name

    cut = broken("cut")
    video = cut / "videos/observation.images.front/chunk-000/file-001.mp4"
    video.write_bytes(video.read_bytes()[:400])
    last = list(read_episodes(cut))[-1]
    with pytest.raises(InputError, match=r"file-001.mp4: not a video, or a broken one"):
        list(last.cameras["front"])
    torn = broken("torn")
    table = torn / "meta/episodes/chunk-000/file-000.parquet"
    table.write_bytes(table.read_bytes()[:-30])
    for use in (lambda: list(read_episodes(torn)), lambda: open_writer(torn)):
        with pytest.raises(InputError, match=r"file-000.parquet: not a Parquet file, or a broken one"):
            use()
    lost = broken("lost")
    (lost / "graft/chunk-000/file-001.hdf5").unlink()
    with pytest.raises(InputError, match=r"file-001.hdf5: no such file"):
        list(read_episodes(lost))


def test_export_refuses_before_it_writes(tmp_path, good):
    with pytest.raises(InputError, match="source and target are the same"):
        export_episodes(good / "a", good / "a")
    with pytest.raises(InputError, match=r"nowhere.hdf5: no such file"):
        export_episodes(tmp_path / "nowhere.hdf5", tmp_path / "out")
    with pytest.raises(InputError, match=r"a.hdf5: a LeRobot dataset is a folder"):
        export_episodes(good / "a", tmp_path / "a.hdf5", "lerobot")
    with pytest.raises(InputError, match=r"a.txt: expected .hdf5 or .h5"):
        export_episodes(good / "a", tmp_path / "a.txt")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"name": ""}, "expected a name"),
        ({"actions": np.full((11, 7), 1.01)}, r"attempt_00000' actions: expected numbers in \[-1, 1\]"),
        ({"actions": np.zeros((11, 0))}, "actions: expected numbers"),
        ({"states": np.zeros((12, 3))}, r"states: expected shape \(11, n\), got \(12, 3\)"),
        ({"observations": {"x": np.zeros((11, 3))}}, r"observation 'x': expected shape \(12, n\)"),
        ({"observations": {"a/b": np.zeros((12, 3))}}, "observation 'a/b': expected letters"),
        ({"observations": {"f_image": np.zeros((12, 3))}, "cameras": {"f": []}}, "has the name of a camera's images"),
        ({"cameras": {"f": iter([])}}, "camera 'f': expected frames that can be iterated again"),
        ({"seed": -1}, r"expected a whole number from 0 to 2\^64 - 1, got -1"),
        ({"seed": 2**64}, "expected a whole number from 0"),
        ({"outcome": ""}, "outcome: expected a word"),
        ({"env_args": {}}, "env_args: expected an env_name, got None"),
        ({"settings": {"x": float("nan")}}, "settings: .*JSON"),
        ({"rewards": [np.inf] * 11}, "rewards: expected finite numbers"),
    ],
)
def test_bad_episodes(changes, match):
    with pytest.raises(InputError, match=match):
        episode(0, **changes)


def test_an_episode_needs_reached_poses_and_even_steps():
    from dataclasses import replace

    whole = episode(0)
    with pytest.raises(InputError, match="expected the poses that the gripper reached"):
        replace(whole, trajectory=replace(whole.trajectory, T_world_gripper=None))
    uneven = replace(whole, trajectory=replace(whole.trajectory, times=np.arange(11.0) ** 2))
    assert isinstance(uneven, Episode)
    with pytest.raises(InputError, match="expected even steps, got 1 to 19 s"):
        _ = uneven.rate
