import json

import numpy as np
import pytest
from sample_episodes import assert_same, episode

h5py = pytest.importorskip("h5py")
pytest.importorskip("av")
pq = pytest.importorskip("pyarrow.parquet")

from graft.datagen.export import export_episodes, open_writer  # noqa: E402
from graft.datagen.read import read_episodes  # noqa: E402
from graft.errors import InputError  # noqa: E402

TARGETS = ["lift.hdf5", "lift"]
VIDEO_ERROR = 4.0
"""Mean difference of a pixel (of 255) that h264 may make of smooth ramps."""


def write(path, numbers, **options):
    with open_writer(path) as writer:
        for number in numbers:
            writer.append(episode(number, **options))
    return path


@pytest.mark.parametrize("target", TARGETS)
def test_what_is_written_is_read(tmp_path, target):
    path = write(tmp_path / target, range(5), cameras=("front", "wrist"))
    back = list(read_episodes(path))
    assert len(back) == 5
    for number, got in enumerate(back):
        assert_same(episode(number, cameras=("front", "wrist")), got, pixels=VIDEO_ERROR if target == "lift" else 0)


def test_export_there_and_back_loses_only_pixels(tmp_path):
    path = write(tmp_path / "a.hdf5", range(4), cameras=("front",))
    done = export_episodes(path, tmp_path / "b")
    assert (done.format, done.written, done.present, done.steps) == ("lerobot", 4, 0, 44)
    assert export_episodes(path, tmp_path / "b").present == 4
    export_episodes(tmp_path / "b", tmp_path / "c.hdf5")
    for one, other in zip(read_episodes(path), read_episodes(tmp_path / "c.hdf5"), strict=True):
        assert_same(one, other, pixels=VIDEO_ERROR)


@pytest.mark.parametrize("target", TARGETS)
def test_episodes_that_are_there_are_not_written_again(tmp_path, target):
    path = write(tmp_path / target, [0, 1, 0])
    with open_writer(path) as writer:
        assert writer.names == {"attempt_00000", "attempt_00001"}
        assert not writer.append(episode(1))
        assert writer.append(episode(2))
    assert [e.name for e in read_episodes(path)] == ["attempt_00000", "attempt_00001", "attempt_00002"]


@pytest.mark.parametrize("target", TARGETS)
def test_one_writer_at_a_time(tmp_path, target):
    with open_writer(tmp_path / target), pytest.raises(InputError, match="another process is writing here"):
        open_writer(tmp_path / target)
    open_writer(tmp_path / target).close()


def test_robomimic_reads_what_its_masks_say(tmp_path):
    path = write(tmp_path / "lift.hdf5", range(12))
    with h5py.File(path) as file:
        masks = {key: [name.decode() for name in file["mask"][key]] for key in file["mask"]}
        assert file["data"].attrs["total"] == 132
        assert json.loads(file["data"].attrs["env_args"])["type"] == 2
        assert sorted(file["data"]) == sorted(f"demo_{i}" for i in range(12))
    assert masks["valid"] == ["demo_9"]
    assert len(masks["train"]) == 11
    assert masks["success"] == [f"demo_{i}" for i in range(12) if i % 4 != 3]


def test_next_observations_are_those_after_the_action(tmp_path):
    path = write(tmp_path / "lift.hdf5", [0])
    with h5py.File(path) as file:
        demo = file["data/demo_0"]
        assert demo["obs/gripper_pos"][1:].tolist() == demo["next_obs/gripper_pos"][:-1].tolist()
        assert demo["next_obs/gripper_pos"][-1].tolist() == episode(0).observations["gripper_pos"][-1].tolist()


def test_lerobot_counts_steps_and_videos(tmp_path):
    root = write(tmp_path / "lift", range(3), cameras=("front",))
    info = json.loads((root / "meta/info.json").read_text())
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"], info["fps"]) == (3, 33, 2, 20)
    assert not any("/" in key for key in info["features"])
    rows = pq.read_table(root / "data/chunk-000/file-000.parquet", partitioning=None).to_pydict()
    assert rows["index"] == list(range(33))
    assert rows["frame_index"] == [*range(11)] * 3
    assert rows["next.success"].count(True) == 3
    assert np.allclose(rows["timestamp"][:11], np.arange(11) / 20)
    meta = pq.read_table(root / "meta/episodes/chunk-000/file-000.parquet", partitioning=None).to_pylist()
    assert [(row["dataset_from_index"], row["dataset_to_index"]) for row in meta] == [(0, 11), (11, 22), (22, 33)]
    assert [row["tasks"] for row in meta] == [["lift the mug"], ["lift the mug"], ["pour"]]
    assert [row["videos/observation.images.front/file_index"] for row in meta] == [0, 1, 2]


def test_lerobot_statistics_are_those_of_all_steps(tmp_path):
    root = write(tmp_path / "lift", range(6), cameras=("front",))
    statistics = json.loads((root / "meta/stats.json").read_text())
    actions = np.concatenate([episode(i).actions for i in range(6)]).astype(np.float32).astype(float)
    assert np.allclose(statistics["action"]["mean"], actions.mean(axis=0))
    assert np.allclose(statistics["action"]["std"], actions.std(axis=0))
    assert np.allclose(statistics["action"]["max"], actions.max(axis=0))
    assert statistics["action"]["count"] == [66]
    frames = np.concatenate([np.stack(episode(i, cameras=("front",)).cameras["front"]) for i in range(6)]) / 255
    images = statistics["observation.images.front"]
    assert np.allclose(np.ravel(images["mean"]), frames.mean(axis=(0, 1, 2)))
    assert np.allclose(np.ravel(images["std"]), frames.std(axis=(0, 1, 2)))
    assert np.shape(images["min"]) == (3, 1, 1)


def test_tables_go_on_in_new_files(tmp_path, monkeypatch):
    monkeypatch.setattr("graft.datagen.writers.lerobot.DATA_BYTES", 4000)
    monkeypatch.setattr("graft.datagen.writers.lerobot.EPISODES_BYTES", 4000)
    monkeypatch.setattr("graft.datagen.writers.tables.CHUNK", 2)
    root = write(tmp_path / "lift", range(4))
    write(root, range(4, 9))
    files = sorted(str(p.relative_to(root)) for p in root.glob("data/*/*.parquet"))
    assert "data/chunk-001/file-000.parquet" in files
    assert [e.name for e in read_episodes(root)] == [f"attempt_{i:05d}" for i in range(9)]
    index = [i for f in files for i in pq.read_table(root / f, partitioning=None)["index"].to_pylist()]
    assert index == list(range(99))


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        (
            {"actions": np.zeros((11, 6))},
            r"action: LeRobot needs all episodes alike; .*float32 \(7,\), .*float32 \(6,\)",
        ),
        ({"observations": {}}, r"observation.state: .* the dataset has float32 \(9,\), this one none"),
        (
            {"trajectory": episode(1).trajectory.resampled(np.linspace(0, 0.5, 11) * 0.5)},
            "expected 20 steps per second",
        ),
    ],
)
def test_lerobot_takes_only_like_episodes(tmp_path, changes, match):
    root = write(tmp_path / "lift", [0])
    with open_writer(root) as writer:
        with pytest.raises(InputError, match=match):
            writer.append(episode(1, **changes))
        assert writer.append(episode(2))
    assert len(list(read_episodes(root))) == 2


def test_frames_are_checked(tmp_path):
    short = {"front": np.zeros((10, 8, 8, 3), np.uint8)}
    odd = {"front": np.zeros((11, 7, 8, 3), np.uint8)}
    floats = {"front": np.zeros((11, 8, 8, 3))}
    for target in TARGETS:
        with open_writer(tmp_path / target) as writer:
            with pytest.raises(InputError, match="camera 'front': expected 11 frames, got 10"):
                writer.append(episode(0, cameras=short))
            with pytest.raises(InputError, match=r"expected \(h, w, 3\) of uint8, got \(8, 8, 3\) of float64"):
                writer.append(episode(0, cameras=floats))
    with open_writer(tmp_path / "odd") as writer, pytest.raises(InputError, match="even height and width, got 7 x 8"):
        writer.append(episode(0, cameras=odd))
