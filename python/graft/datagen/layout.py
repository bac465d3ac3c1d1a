"""One episode as a group of HDF5: robomimic's keys, MimicGen's `datagen_info`, and what graft adds as attributes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graft.checks import Floats
from graft.datagen.episode import IMAGE_SUFFIX, SUCCESS, Episode, Image, checked_frame
from graft.datagen.hdf5 import has, numbers, numbers_in, opened, stored_array, subgroup
from graft.errors import InputError
from graft.io.guards import malformed_is_input_error, parse_json
from graft.trajectory import Segment, Trajectory, segments_from_signals

SCHEMA = 1
"""Version of what graft adds to the files of robomimic: attribute `graft_schema` of the file and of each episode."""

DEFAULT_RATE = 20.0
"""Steps per second where a file tells no times and its env_args no control_freq: robosuite's default."""

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""Of images: level 1 halves rendered frames at several times the speed of the default 4."""


def write_episode(group: Any, episode: Episode, *, cameras: bool = True) -> None:
    """Write an episode into an empty group, its frames one by one.

    Args:
        group: An h5py group.
        episode: The episode.
        cameras: False leaves the images out.
    """
    trajectory = episode.trajectory
    words = {
        "num_samples": len(episode),
        "model_file": episode.model_xml,
        "graft_schema": SCHEMA,
        "name": episode.name,
        "seed": np.uint64(episode.seed),
        "outcome": episode.outcome,
        "task": episode.task,
        "source": episode.source,
        "env_args": json.dumps(episode.env_args),
        "settings": json.dumps(episode.settings),
        "versions": json.dumps(episode.versions),
    }
    for key, value in words.items():
        group.attrs[key] = value
    arrays: dict[str, Any] = {
        "actions": episode.actions,
        "rewards": episode.rewards,
        "dones": episode.dones,
        "states": episode.states,
        "times": trajectory.times,
        "datagen_info/eef_pose": trajectory.T_world_gripper,
        "datagen_info/target_pose": trajectory.T_world_target,
        "datagen_info/gripper_action": trajectory.gripper[:, None],
    }
    arrays |= {f"obs/{name}": rows[:-1] for name, rows in episode.observations.items()}
    arrays |= {f"next_obs/{name}": rows[1:] for name, rows in episode.observations.items()}
    arrays |= {f"datagen_info/object_poses/{name}": poses for name, poses in trajectory.T_world_object.items()}
    arrays |= {f"datagen_info/subtask_term_signals/{name}": on for name, on in trajectory.term_signals.items()}
    for key, array in arrays.items():
        group.create_dataset(key, data=array)
    segments = [[s.name, s.start, s.end, s.anchor, s.signal] for s in trajectory.segments]
    group["datagen_info"].attrs["segments"] = json.dumps(segments)
    for name in episode.cameras if cameras else ():
        _write_frames(group, name, episode)


def _write_frames(group: Any, name: str, episode: Episode) -> None:
    dataset, count = None, 0
    for frame in episode.cameras[name]:
        where = f"episode {episode.name!r} camera {name!r} frame {count}"
        image = checked_frame(where, frame, None if dataset is None else dataset.shape[1:])
        if dataset is None:
            shape = (len(episode), *image.shape)
            dataset = group.create_dataset(
                f"obs/{name}{IMAGE_SUFFIX}", shape, np.uint8, chunks=(1, *image.shape), **COMPRESSION
            )
        if count < len(episode):
            dataset[count] = image
        count += 1
    check_frame_count(episode, name, count)


def check_frame_count(episode: Episode, name: str, count: int) -> None:
    """Refuse a camera that gave more or fewer frames than the episode has steps."""
    if count != len(episode):
        raise InputError(f"episode {episode.name!r} camera {name!r}: expected {len(episode)} frames, got {count}")


class StoredFrames:
    """The frames of a camera in an HDF5 file, read one by one each time they are iterated."""

    def __init__(self, path: Path, key: str) -> None:
        self.path, self.key = path, key

    def __iter__(self) -> Iterator[Image]:
        with opened(self.path) as file:
            dataset = stored_array(file, self.key, self.path)
            for i in range(len(dataset)):
                yield np.asarray(dataset[i], np.uint8)


def read_trajectory(
    group: Any, path: Path, *, rate: float, anchors: Mapping[str, str | None] | None = None
) -> Trajectory:
    """Return the trajectory of an episode from MimicGen's `datagen_info`.

    Args:
        group: An h5py group.
        path: Its file, for messages.
        rate: Steps per second where the episode has no `times`.
        anchors: Segment -> object, where graft did not write the file; see `segments_from_signals`.
    """
    if not has(group, "datagen_info", path):
        raise InputError(
            f"{group.name}: no datagen_info, which has the poses; MimicGen's prepare_src_dataset adds it", path=path
        )
    info = subgroup(group, "datagen_info", path)
    targets = numbers(info, "target_pose", path, (None, 4, 4))
    n = len(targets)
    gripper = numbers(info, "gripper_action", path, None).reshape(n, -1)
    if gripper.shape[1] != 1:
        raise InputError(f"{info.name}/gripper_action: expected shape ({n}, 1), got {gripper.shape}", path=path)
    has_times = has(group, "times", path)
    signals = numbers_in(info, "subtask_term_signals", path, (n,))
    written = info.attrs.get("segments") if "graft_schema" in group.attrs else None
    with malformed_is_input_error(path, f"{info.name} segments"):
        if written is not None and anchors is None:
            segments = tuple(Segment(*entry) for entry in json.loads(written))
        else:
            segments = segments_from_signals(signals, n, anchors=anchors)
        return Trajectory(
            times=numbers(group, "times", path, (n,)) if has_times else np.arange(n) / rate,
            T_world_target=targets,
            gripper=gripper[:, 0],
            T_world_gripper=numbers(info, "eef_pose", path, (n, 4, 4)),
            T_world_object=numbers_in(info, "object_poses", path, (n, 4, 4)),
            segments=segments,
        )


def read_episode(group: Any, path: Path, env_args: Mapping[str, Any]) -> Episode:
    """Return the episode in a group; its frames stay in the file until they are asked for.

    Files of others have no seed, outcome, task and name of their own: 0, by the last `dones`, the environment's name
    and the group's name are taken.

    Args:
        group: An h5py group.
        path: Its file.
        env_args: Those of the file.
    """
    attributes = {key: group.attrs[key] for key in group.attrs}
    ours = "graft_schema" in attributes
    if ours and attributes["graft_schema"] > SCHEMA:
        raise InputError(
            f"{group.name}: schema {attributes['graft_schema']}, a newer graft than this one ({SCHEMA}) wrote it",
            path=path,
        )
    env_args = parse_json(attributes["env_args"], path=path) if ours else env_args
    rate = env_args.get("env_kwargs", {}).get("control_freq", DEFAULT_RATE) if not ours else DEFAULT_RATE
    trajectory = read_trajectory(group, path, rate=float(rate))
    n = len(trajectory)
    observations, cameras = _observations(group, path, n)
    dones = numbers(group, "dones", path, (n,)).astype(np.int64)
    name = group.name.rsplit("/", 1)[-1]
    with malformed_is_input_error(path, f"episode {group.name}"):
        return Episode(
            name=_text(attributes, "name", name),
            trajectory=trajectory,
            actions=numbers(group, "actions", path, (n, None)),
            states=numbers(group, "states", path, (n, None)),
            observations=observations,
            rewards=numbers(group, "rewards", path, (n,)),
            dones=dones,
            model_xml=_text(attributes, "model_file", ""),
            env_args=env_args,
            seed=int(attributes["seed"]) if ours else 0,
            outcome=_text(attributes, "outcome", SUCCESS if dones[-1] else "unknown"),
            task=_text(attributes, "task", str(env_args.get("env_name", ""))),
            source=_text(attributes, "source", ""),
            settings=parse_json(attributes["settings"], path=path) if ours else {},
            versions=parse_json(attributes["versions"], path=path) if ours else {},
            cameras=cameras,
        )


def _text(attributes: Mapping[str, Any], key: str, default: str) -> str:
    value = attributes.get(key, default)
    return value.decode() if isinstance(value, bytes) else str(value)


def _observations(group: Any, path: Path, n: int) -> tuple[dict[str, Floats], dict[str, StoredFrames]]:
    """Return the observations with the one after the last action, and the cameras."""
    observations: dict[str, Floats] = {}
    cameras: dict[str, StoredFrames] = {}
    if not has(group, "obs", path):
        return observations, cameras
    for key in subgroup(group, "obs", path):
        dataset = stored_array(group, f"obs/{key}", path)
        if dataset.ndim == 4 and dataset.dtype == np.uint8:
            if len(dataset) != n:
                raise InputError(f"{dataset.name}: expected {n} frames, got {len(dataset)}", path=path)
            cameras[key.removesuffix(IMAGE_SUFFIX)] = StoredFrames(path, dataset.name)
            continue
        before = numbers(group, f"obs/{key}", path, None).reshape(len(dataset), -1)
        after = before
        if has(group, f"next_obs/{key}", path):
            after = numbers(group, f"next_obs/{key}", path, None).reshape(len(dataset), -1)
        observations[key] = np.concatenate([before, after[-1:]])
    return observations, cameras
