"""LeRobot datasets, version 3.0, in which every finished episode stays readable whatever kills the writer.

LeRobot's own writer keeps Parquet files open, and loses them when it dies before `finalize`. Here files are whole at
any time: each is written beside its place and renamed. An episode is there from the moment its row is in meta/episodes;
before that come its record, videos and steps, after it info.json and stats.json. What a killed writer did out of that
order the next one takes back or makes up for, from the files alone.

Beside LeRobot's files there is a folder `graft/`, which LeRobot does not look into: for each episode an HDF5 file in
robomimic's layout, without images, with what LeRobot has no place for (states, the scene, poses, segments, seed,
settings) in double precision. It makes episodes replayable and lets `graft export` lose nothing but pixels.
"""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from graft import __version__
from graft.datagen.durable import locked, put, remove_drafts, swap
from graft.datagen.episode import Episode, checked_frame
from graft.datagen.hdf5 import load_h5py
from graft.datagen.layout import check_frame_count
from graft.datagen.writers.robomimic import write_part
from graft.datagen.writers.shards import Shards
from graft.datagen.writers.statistics import STATISTICS, ImageStatistics, Statistics, Total, of_rows
from graft.datagen.writers.tables import (
    CHUNK,
    DATA_PATH,
    EPISODES_PATH,
    IMAGES,
    RECORD_PATH,
    VIDEO_PATH,
    episode_table,
    features_of,
    parquet_bytes,
    place,
    read_parquet,
    step_columns,
    step_table,
    task_table,
    whole_rate,
)
from graft.datagen.writers.video import load_av, write_video
from graft.errors import InputError
from graft.io.atomic import write_whole
from graft.io.guards import read_json

VERSION = "v3.0"
SCHEMA = 1
"""Version of the folder `graft/`; in info.json as `graft_schema`."""

DATA_BYTES = 2 << 20
"""Of a data file in memory: some 80 episodes of 200 steps with 20 numbers; an episode costs half of it in writing."""

EPISODES_BYTES = 1 << 18
"""Of a file of meta/episodes in memory: some 50 episodes."""

VIDEO_MEGABYTES = 200
"""What LeRobot may fill a video file up to if it appends; here each episode has its own. LeRobot's default."""


class LeRobotWriter:
    """Writes episodes into a LeRobot dataset; a context manager.

    Args:
        root: The folder; one that graft wrote before gets more episodes.

    Raises:
        InputError: Another process is writing it, or the folder holds something else.
    """

    def __init__(self, root: str | Path) -> None:
        load_h5py(), load_av()
        self.root = Path(root)
        self._names: set[str] = set()
        self._tasks: dict[str, int] = {}
        self._info: dict[str, Any] = {}
        self._total = Total()
        self._steps = 0
        self._data = Shards(self.root, DATA_PATH, DATA_BYTES)
        self._episodes = Shards(self.root, EPISODES_PATH, EPISODES_BYTES)
        self._exit = ExitStack()
        check_folder(self.root)
        try:
            self._exit.enter_context(locked(self.root / "graft" / "lock"))
            self._recover()
        except BaseException:
            self._exit.close()
            raise

    @property
    def names(self) -> frozenset[str]:
        """Names of the episodes that are there."""
        return frozenset(self._names)

    def append(self, episode: Episode) -> bool:
        """Write an episode; it is on disk, and LeRobot can read it, when this returns.

        Returns:
            False if an episode of that name is there already; nothing is written then.

        Raises:
            InputError: The episode does not fit those before (other features, other rate), or the system refuses (disk
                full); the episodes before are safe, and this one can be tried again.
        """
        if episode.name in self._names:
            return False
        index = len(self._names)
        shapes = {name: _first_shape(episode, name) for name in episode.cameras}
        self._check_features(episode, shapes)
        write_part(self.root / RECORD_PATH.format(**place(index)), episode, cameras=False)
        statistics = {IMAGES + name: self._write_video(episode, name, index) for name in shapes}
        task = self._task(episode.task)
        columns = step_columns(episode, index=index, start=self._steps, task=task)
        statistics |= {
            key: of_rows(np.asarray(rows, np.float64).reshape(len(episode), -1)) for key, rows in columns.items()
        }
        statistics = {feature: statistics[feature] for feature in self._info["features"]}
        row = self._row(episode, index, list(shapes))
        self._data.append(step_table(columns))
        self._episodes.append(episode_table(row, statistics))
        self._enter(episode.name, len(episode), statistics)
        self._write_summary()
        return True

    def close(self) -> None:
        """Let go of the folder; there is nothing to finish."""
        self._exit.close()

    def __enter__(self) -> LeRobotWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _check_features(self, episode: Episode, shapes: dict[str, tuple[int, ...]]) -> None:
        features = features_of(episode, shapes)
        if not self._info:
            self._info = {
                "codebase_version": VERSION,
                "robot_type": str(episode.env_args["env_name"]),
                "total_episodes": 0,
                "total_frames": 0,
                "total_tasks": 0,
                "chunks_size": CHUNK,
                "data_files_size_in_mb": DATA_BYTES >> 20,
                "video_files_size_in_mb": VIDEO_MEGABYTES,
                "fps": whole_rate(episode),
                "splits": {},
                "data_path": DATA_PATH,
                "video_path": VIDEO_PATH if shapes else None,
                "features": features,
                "graft_schema": SCHEMA,
                "graft_version": __version__,
            }
            try:
                put(self.root / "meta/info.json", _json(self._info))
            except InputError:
                self._info = {}
                raise
        for key in sorted({*features, *self._info["features"]}):
            ours, there = features.get(key), self._info["features"].get(key)
            if ours != there:
                raise InputError(
                    f"episode {episode.name!r} {key}: LeRobot needs all episodes alike; the dataset has "
                    f"{_described(there)}, this one {_described(ours)}",
                    path=self.root,
                )
        if whole_rate(episode) != self._info["fps"]:
            raise InputError(
                f"episode {episode.name!r}: expected {self._info['fps']} steps per second as the episodes before, "
                f"got {whole_rate(episode)}",
                path=self.root,
            )

    def _write_video(self, episode: Episode, camera: str, index: int) -> Statistics:
        watched = ImageStatistics()
        path = self.root / VIDEO_PATH.format(video_key=IMAGES + camera, **place(index))
        where = f"episode {episode.name!r} camera {camera!r}"
        shape = tuple(self._info["features"][IMAGES + camera]["shape"])
        frames = (checked_frame(where, frame, shape) for frame in episode.cameras[camera])
        write_video(path, watched.watched(frames), self._info["fps"])
        check_frame_count(episode, camera, watched.frames)
        return watched.result()

    def _task(self, task: str) -> int:
        """Return the number of a task, entering it before the steps that name it."""
        if task not in self._tasks:
            tasks = self._tasks | {task: len(self._tasks)}
            put(self.root / "meta/tasks.parquet", parquet_bytes(task_table(tasks)))
            self._tasks = tasks
        return self._tasks[task]

    def _row(self, episode: Episode, index: int, cameras: list[str]) -> dict[str, Any]:
        def at(prefix: str, number: int) -> dict[str, int]:
            return {f"{prefix}/{key}": value for key, value in place(number).items()}

        row: dict[str, Any] = {"episode_index": index, "tasks": [episode.task], "length": len(episode)}
        row |= at("data", self._data.index)
        row |= {"dataset_from_index": self._steps, "dataset_to_index": self._steps + len(episode)}
        for camera in cameras:
            key = f"videos/{IMAGES}{camera}"
            row |= at(key, index)
            row |= {f"{key}/from_timestamp": 0.0, f"{key}/to_timestamp": len(episode) / self._info["fps"]}
        row |= at("meta/episodes", self._episodes.index)
        return row | {
            "graft/name": episode.name,
            "graft/outcome": episode.outcome,
            "graft/source": episode.source,
            "graft/seed": episode.seed,
        }

    def _enter(self, name: str, length: int, statistics: dict[str, Statistics]) -> None:
        self._names.add(name)
        self._steps += length
        self._total.add(statistics)
        self._info |= {
            "total_episodes": len(self._names),
            "total_frames": self._steps,
            "total_tasks": len(self._tasks),
            "splits": {"train": f"0:{len(self._names)}"},
        }

    def _write_summary(self) -> None:
        """Write what follows from meta/episodes; the next writer makes up for it where it is missing."""
        swap(self.root / "meta/stats.json", _json(self._total.document()))
        write_whole(self.root / "meta/info.json", _json(self._info))

    def _recover(self) -> None:
        """Bring everything to the episodes of meta/episodes, whose rows are the only truth."""
        remove_drafts(self.root)
        info = self.root / "meta/info.json"
        if not info.is_file():
            return
        self._info = read_json(info)
        for path in self._episodes.files():
            table = read_parquet(path)
            for row in table.to_pylist():
                self._enter(row["graft/name"], row["length"], _statistics(row, self._info["features"]))
        written = self.root / "meta/tasks.parquet"
        if written.is_file():
            self._tasks = {name: i for i, name in enumerate(read_parquet(written).column(1).to_pylist())}
            self._info["total_tasks"] = len(self._tasks)
        self._data.resume(len(self._names))
        self._episodes.resume(len(self._names))
        self._remove_unfinished(len(self._names))
        if self._names:
            self._write_summary()

    def _remove_unfinished(self, index: int) -> None:
        """Remove record and videos of the episode that a killed writer did not get to enter."""
        videos = [key for key in self._info["features"] if key.startswith(IMAGES)]
        (self.root / RECORD_PATH.format(**place(index))).unlink(missing_ok=True)
        for key in videos:
            (self.root / VIDEO_PATH.format(video_key=key, **place(index))).unlink(missing_ok=True)


def check_folder(root: Path) -> None:
    """Refuse a file, and a folder that holds anything but a dataset of graft's or the beginning of one."""
    if not root.exists():
        return
    if not root.is_dir():
        raise InputError("expected a folder for a LeRobot dataset, it is a file", path=root)
    info = root / "meta/info.json"
    if info.is_file():
        if read_json(info).get("graft_schema") != SCHEMA:
            raise InputError("graft did not write this dataset; nothing is added to it", path=info)
    else:
        others = sorted(p.name for p in root.iterdir() if p.name not in ("graft", "meta"))
        if others:
            raise InputError(f"the folder holds other files, nothing is written: {', '.join(others[:5])}", path=root)


def _statistics(row: dict[str, Any], features: dict[str, Any]) -> dict[str, Statistics]:
    return {
        feature: {key: np.array(row[f"stats/{feature}/{key}"], np.float64) for key in STATISTICS}
        for feature in features
    }


def _first_shape(episode: Episode, camera: str) -> tuple[int, ...]:
    where = f"episode {episode.name!r} camera {camera!r}"
    for frame in episode.cameras[camera]:
        return checked_frame(where, frame, None).shape
    raise InputError(f"{where}: expected {len(episode)} frames, got none")


def _described(feature: dict[str, Any] | None) -> str:
    return "none" if feature is None else f"{feature['dtype']} {tuple(feature['shape'])}"


def _json(document: dict[str, Any]) -> bytes:
    return json.dumps(document, indent=1, allow_nan=False).encode()
