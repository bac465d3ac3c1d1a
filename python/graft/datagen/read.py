"""Episodes from robomimic's files and from LeRobot datasets, one at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

from graft.datagen.episode import Episode
from graft.datagen.hdf5 import opened
from graft.datagen.layout import read_episode
from graft.datagen.writers.robomimic import demo_keys, part_files
from graft.errors import InputError
from graft.io.guards import parse_json, read_json

Format = Literal["robomimic", "lerobot"]
HDF5_SUFFIXES = (".hdf5", ".h5")


def format_of(path: str | Path) -> Format:
    """Return which format a path has: a folder is LeRobot's, .hdf5 and .h5 are robomimic's.

    Raises:
        InputError: Another suffix.
    """
    path = Path(path)
    if path.is_dir() or not path.suffix:
        return "lerobot"
    if path.suffix.lower() in HDF5_SUFFIXES:
        return "robomimic"
    raise InputError(f"expected {' or '.join(HDF5_SUFFIXES)} (robomimic) or a folder (LeRobot)", path=path)


def read_episodes(path: str | Path) -> Iterator[Episode]:
    """Give the episodes of a file or dataset, in order, in the memory of one.

    Reads what graft wrote, also where its writer was killed, and robomimic's files with MimicGen's `datagen_info`.
    Frames stay on disk until they are iterated.

    Args:
        path: An HDF5 file, or the folder of a LeRobot dataset that graft wrote.

    Raises:
        InputError: No such file, another layout, broken; one line with the file and the key.
    """
    path = Path(path)
    return _robomimic_episodes(path) if format_of(path) == "robomimic" else _lerobot_episodes(path)


def _robomimic_episodes(path: Path) -> Iterator[Episode]:
    parts = part_files(path)
    seen = set()
    for file_path in [path, *parts] if path.exists() or not parts else parts:
        with opened(file_path) as file:
            if "data" not in file or not hasattr(file["data"], "keys"):
                found = ", ".join(sorted(file)[:5]) or "nothing"
                raise InputError(
                    f"no group 'data', which robomimic keeps its episodes in; found {found}", path=file_path
                )
            data = file["data"]
            keys = demo_keys(data)
            if not keys:
                raise InputError("group 'data' has no episodes 'demo_0', 'demo_1', …", path=file_path)
            if "env_args" not in data.attrs:
                raise InputError("data: no attribute env_args, which names the environment", path=file_path)
            env_args = parse_json(data.attrs["env_args"], path=file_path)
            for key in keys:
                episode = read_episode(data[key], file_path, env_args)
                if not (file_path in parts and episode.name in seen):
                    seen.add(episode.name)
                    yield episode


def _lerobot_episodes(root: Path) -> Iterator[Episode]:
    from graft.datagen.writers.lerobot import EPISODES_BYTES, SCHEMA
    from graft.datagen.writers.shards import Shards
    from graft.datagen.writers.tables import EPISODES_PATH, IMAGES, RECORD_PATH, VIDEO_PATH, place, read_parquet
    from graft.datagen.writers.video import VideoFrames

    if not root.is_dir():
        raise InputError("no such dataset", path=root)
    info = read_json(root / "meta/info.json")
    if info.get("graft_schema") != SCHEMA:
        raise InputError(
            "graft did not write this dataset: it lacks the states, scenes and poses that graft keeps in 'graft/'",
            path=root,
        )
    cameras = [key for key in info["features"] if key.startswith(IMAGES)]
    for table_path in Shards(root, EPISODES_PATH, EPISODES_BYTES).files():
        for index in read_parquet(table_path, ["episode_index"])["episode_index"].to_pylist():
            record = root / RECORD_PATH.format(**place(index))
            with opened(record) as file:
                episode = read_episode(file["data/demo_0"], record, {})
            videos = {
                key.removeprefix(IMAGES): VideoFrames(
                    root / VIDEO_PATH.format(video_key=key, **place(index)), len(episode)
                )
                for key in cameras
            }
            yield replace(episode, cameras=videos)
