"""Episodes of noise, the same for the same number, and how two of them are compared."""

import numpy as np
from scipy.spatial.transform import Rotation

from graft.datagen.episode import Episode
from graft.trajectory import Segment, Trajectory


def poses(rng, steps):
    result = np.tile(np.eye(4), (steps, 1, 1))
    result[:, :3, :3] = Rotation.random(steps, rng=rng).as_matrix()
    result[:, :3, 3] = rng.normal(size=(steps, 3))
    return result


def trajectory(rng, steps=11, rate=20.0):
    return Trajectory(
        times=np.arange(steps) / rate,
        T_world_target=poses(rng, steps),
        gripper=np.where(np.arange(steps) < steps // 2, -1.0, 1.0),
        T_world_gripper=poses(rng, steps),
        T_world_object={"object": poses(rng, steps), "table": poses(rng, steps)},
        segments=(Segment("reach", 0, 4, "object", "reached"), Segment("lift", 4, steps)),
    )


def episode(number=0, *, steps=11, cameras=(), **changes):
    rng = np.random.default_rng(number)
    words = {
        "name": f"attempt_{number:05d}",
        "trajectory": trajectory(rng, steps),
        "actions": rng.uniform(-1, 1, (steps, 7)),
        "states": rng.normal(size=(steps, 13)),
        "observations": {
            "object_pose": rng.normal(size=(steps + 1, 6)),
            "gripper_pos": rng.normal(size=(steps + 1, 3)),
        },
        "rewards": np.arange(steps) * 0.5,
        "dones": np.eye(steps, dtype=int)[-1],
        "model_xml": f"<mujoco model='{number}'/>",
        "env_args": {"env_name": "graft/Lift-v0", "env_kwargs": {"gripper": "panda_hand"}},
        "seed": 2**64 - 1 - number,
        "outcome": "slippage" if number % 4 == 3 else "success",
        "task": "pour" if number % 3 == 2 else "lift the mug",
        "source": f"mug_{number % 2}",
        "settings": {"noise": 0.05, "planner": None},
        "cameras": cameras if isinstance(cameras, dict) else {name: smooth_frames(number, steps) for name in cameras},
    }
    return Episode(**(words | changes))


def smooth_frames(number, steps, height=32, width=48):
    """Colour ramps that a video codec keeps nearly as they are."""
    rows, columns = np.mgrid[0:height, 0:width]
    ramp = np.stack([rows * 4, columns * 4, rows * 0 + 10 * number % 200], axis=2)
    return np.stack([np.clip(ramp + 2 * step, 0, 255) for step in range(steps)]).astype(np.uint8)


def assert_same(one, other, *, pixels=0.0):
    """Every field to the last bit, pixels to a mean difference."""
    for name in ("actions", "states", "rewards", "dones"):
        assert getattr(one, name).tolist() == getattr(other, name).tolist(), name
    for name in ("name", "model_xml", "env_args", "seed", "outcome", "task", "source", "settings", "versions"):
        assert getattr(one, name) == getattr(other, name), name
    assert_same_trajectory(one.trajectory, other.trajectory)
    assert list(one.observations) == list(other.observations)
    for name, rows in one.observations.items():
        assert rows.tolist() == other.observations[name].tolist(), name
    assert list(one.cameras) == list(other.cameras)
    for name in one.cameras:
        a, b = (np.stack(list(x.cameras[name])).astype(float) for x in (one, other))
        assert a.shape == b.shape
        assert np.abs(a - b).mean() <= pixels


def assert_same_trajectory(one, other):
    for name in ("times", "T_world_target", "gripper", "T_world_gripper"):
        assert getattr(one, name).tolist() == getattr(other, name).tolist(), name
    assert list(one.T_world_object) == list(other.T_world_object)
    for name, rows in one.T_world_object.items():
        assert rows.tolist() == other.T_world_object[name].tolist(), name
    assert one.segments == other.segments
