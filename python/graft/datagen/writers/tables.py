"""The tables of a LeRobot dataset v3.0: features, rows of steps, rows of episodes, tasks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from graft.datagen.episode import Episode
from graft.datagen.writers.statistics import Statistics
from graft.datagen.writers.video import video_info
from graft.errors import InputError

CHUNK = 1000
"""Files in a folder, LeRobot's default."""

DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
RECORD_PATH = "graft/chunk-{chunk_index:03d}/file-{file_index:03d}.hdf5"

STATE = "observation.state"
"""All observations side by side, in the order of their names."""

IMAGES = "observation.images."
TASK_INDEX_COLUMN = "__index_level_0__"
"""What pandas calls an index without a name in Parquet; LeRobot looks tasks up by it."""


def place(index: int) -> dict[str, int]:
    """Return chunk and number in it of the file with a running number."""
    return {"chunk_index": index // CHUNK, "file_index": index % CHUNK}


def whole_rate(episode: Episode) -> int:
    """Return an episode's steps per second, which LeRobot wants to be a whole number."""
    rate = episode.rate
    if round(rate) < 1 or abs(rate - round(rate)) > 1e-3 * rate:
        raise InputError(f"episode {episode.name!r}: LeRobot needs a whole number of steps per second, got {rate:.6g}")
    return round(rate)


def features_of(episode: Episode, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, dict[str, Any]]:
    """Return the features of a dataset whose first episode this is.

    Args:
        episode: The episode.
        shapes: Camera -> (h, w, 3).
    """
    fps = whole_rate(episode)
    dof = episode.actions.shape[1]
    result: dict[str, dict[str, Any]] = {
        "action": {"dtype": "float32", "shape": [dof], "names": [f"action.{i}" for i in range(dof)]}
    }
    state = [f"{name}.{i}" for name, rows in episode.observations.items() for i in range(rows.shape[1])]
    if state:
        result[STATE] = {"dtype": "float32", "shape": [len(state)], "names": state}
    for camera, shape in shapes.items():
        names = ["height", "width", "channels"]
        result[IMAGES + camera] = {
            "dtype": "video", "shape": list(shape), "names": names, "info": video_info(shape, fps)
        }  # fmt: skip
    one = {"shape": [1], "names": None}
    result |= {
        "next.reward": {"dtype": "float32", **one},
        "next.done": {"dtype": "bool", **one},
        "next.success": {"dtype": "bool", **one},
        "timestamp": {"dtype": "float32", **one},
    }
    return result | {key: {"dtype": "int64", **one} for key in _COUNTERS}


_COUNTERS = ("frame_index", "episode_index", "index", "task_index")


def step_columns(episode: Episode, *, index: int, start: int, task: int) -> dict[str, np.ndarray[Any, Any]]:
    """Return feature -> (T, ...) of everything but the images.

    Args:
        episode: The episode.
        index: Its number.
        start: Number of its first step in the dataset.
        task: Number of its task.
    """
    n = len(episode)
    steps = np.arange(n)
    success = np.zeros(n, bool)
    success[-1] = episode.succeeded
    columns: dict[str, np.ndarray[Any, Any]] = {"action": episode.actions.astype(np.float32)}
    if episode.observations:
        columns[STATE] = np.concatenate([o[:-1] for o in episode.observations.values()], axis=1).astype(np.float32)
    columns |= {
        "next.reward": episode.rewards.astype(np.float32),
        "next.done": episode.dones.astype(bool),
        "next.success": success,
        "timestamp": (steps / whole_rate(episode)).astype(np.float32),
        "frame_index": steps,
        "episode_index": np.full(n, index),
        "index": start + steps,
        "task_index": np.full(n, task),
    }
    return columns


def step_table(columns: Mapping[str, np.ndarray[Any, Any]]) -> pa.Table:
    """Return the rows of an episode's steps."""

    def array(column: np.ndarray[Any, Any]) -> pa.Array:
        flat = pa.array(column.ravel())
        wide = column.ndim == 2 and column.shape[1] > 1
        return pa.FixedSizeListArray.from_arrays(flat, column.shape[1]) if wide else flat

    return pa.table({key: array(column) for key, column in columns.items()})


def episode_table(row: Mapping[str, Any], statistics: Mapping[str, Statistics]) -> pa.Table:
    """Return the row of an episode in meta/episodes."""
    columns = {key: pa.array([value], _TYPES.get(type(value))) for key, value in row.items() if key != "graft/seed"}
    columns["graft/seed"] = pa.array([row["graft/seed"]], pa.uint64())
    for feature, values in statistics.items():
        for key, value in values.items():
            kind = pa.int64() if key == "count" else pa.float64()
            data = value.astype(np.int64 if key == "count" else np.float64)
            for _ in range(value.ndim):
                kind = pa.list_(kind)
            columns[f"stats/{feature}/{key}"] = pa.array([data.tolist()], kind)
    return pa.table(columns)


_TYPES = {int: pa.int64(), float: pa.float64(), str: pa.string(), list: pa.list_(pa.string())}


def task_table(tasks: Mapping[str, int]) -> pa.Table:
    """Return meta/tasks.parquet: the tasks as a pandas index, described by hand so that pandas is not needed."""
    words = {"pandas_type": "unicode", "numpy_type": "object", "metadata": None}
    described = {
        "index_columns": [TASK_INDEX_COLUMN],
        "column_indexes": [{"name": None, "field_name": None, **words, "metadata": {"encoding": "UTF-8"}}],
        "columns": [
            {
                "name": "task_index", "field_name": "task_index",
                "pandas_type": "int64", "numpy_type": "int64", "metadata": None,
            },
            {"name": None, "field_name": TASK_INDEX_COLUMN, **words},
        ],
        "pandas_version": "2.0.0",
    }  # fmt: skip
    table = pa.table(
        {
            "task_index": pa.array(list(tasks.values()), pa.int64()),
            TASK_INDEX_COLUMN: pa.array(list(tasks), pa.string()),
        }
    )
    return table.replace_schema_metadata({"pandas": json.dumps(described)})


def parquet_bytes(table: pa.Table) -> bytes:
    """Return a table as a Parquet file."""
    sink = pa.BufferOutputStream()
    # Dictionaries do not pay for floats, and writing them takes half of the time.
    pq.write_table(table, sink, compression="snappy", use_dictionary=False)
    return bytes(sink.getvalue())


def read_parquet(path: Path, columns: list[str] | None = None) -> pa.Table:
    """Read a Parquet file.

    Raises:
        InputError: Not there, broken, or without one of the columns.
    """
    try:
        with pq.ParquetFile(path) as file:
            table = file.read(columns=columns)
    except FileNotFoundError:
        raise InputError("no such file", path=path) from None
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"not a Parquet file, or a broken one: {str(error).splitlines()[0]}", path=path) from None
    missing = [key for key in columns or () if key not in table.column_names]
    if missing:
        raise InputError(f"column {missing[0]!r} is missing", path=path)
    return table
