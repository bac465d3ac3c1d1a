"""Have robomimic's and LeRobot's own loaders read what graft writes.

python benches/verify_formats.py [--work FOLDER] [--keep] [--python PYTHON]

Makes an environment with their packages in FOLDER (a temporary one by default; torch is most of it), writes sample
episodes with the graft that runs this, reads them in there, and compares. The folder is removed afterwards unless
--keep is given. Exits 1 when a loader fails or says something else than was written.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from graft.datagen.episode import Episode
from graft.datagen.export import export_episodes, open_writer
from graft.trajectory import Segment, Trajectory

HERE = Path(__file__).parent
EPISODES, STEPS = 12, 30

SHARED_PACKAGES = [
    "torch==2.6.0", "torchvision==0.21.0", "numpy<2.3", "datasets>=4,<5", "huggingface-hub>=0.34.2,<0.36", "pandas",
    "av>=15,<16", "h5py", "jsonlines", "packaging", "einops", "deepdiff", "termcolor", "psutil", "tqdm", "six",
    "matplotlib", "imageio", "safetensors", "mergedeep", "pyyaml-include", "typing-inspect", "regex",
]  # fmt: skip
"""What both import when they read; the oldest torch that both take keeps the environment small."""

BARE_PACKAGES = ["accelerate", "diffusers<0.36", "draccus==0.10.0"]
"""Imported, too, but what they need is not."""

LOADERS = {"robomimic": "praxis-robomimic==0.5.0", "lerobot": "lerobot==0.4.4"}
"""Each in a folder of its own, without its dependencies."""


def sample(number: int) -> Episode:
    """Return an episode of noise with a camera."""
    rng = np.random.default_rng(number)
    poses = np.tile(np.eye(4), (STEPS, 1, 1))
    poses[:, :3, 3] = rng.normal(size=(STEPS, 3))
    rows, columns = np.mgrid[0:96, 0:128]
    image = np.stack([rows, columns, rows * 0 + 10 * number], axis=2).astype(np.uint8)
    return Episode(
        name=f"attempt_{number:05d}",
        trajectory=Trajectory(
            np.arange(STEPS) / 20,
            poses,
            np.where(np.arange(STEPS) < 15, -1.0, 1.0),
            poses,
            {"object": poses},
            (Segment("reach", 0, 12, "object", "reached"), Segment("lift", 12, STEPS, "object")),
        ),
        actions=rng.uniform(-1, 1, (STEPS, 7)),
        states=rng.normal(size=(STEPS, 13)),
        observations={"gripper_pos": rng.normal(size=(STEPS + 1, 3)), "object_pose": rng.normal(size=(STEPS + 1, 7))},
        rewards=np.zeros(STEPS),
        dones=np.eye(STEPS, dtype=int)[-1],
        model_xml="<mujoco/>",
        env_args={"env_name": "graft/Lift-v0"},
        seed=number,
        outcome="success",
        task="lift the mug",
        cameras={"front": np.repeat(image[None], STEPS, axis=0)},
    )


def environment(work: Path, python: str) -> Path:
    """Build the environment, or take the one that is there; returns its interpreter."""
    own = work / "venv" / "bin" / "python"
    if (work / "ready").exists():
        return own
    subprocess.run([python, "-m", "venv", work / "venv"], check=True)
    install = [own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*install, *SHARED_PACKAGES], check=True)
    subprocess.run([*install, "--no-deps", *BARE_PACKAGES], check=True)
    for name, package in LOADERS.items():
        subprocess.run([*install, "--no-deps", "--target", work / name, package], check=True)
    (work / "ready").touch()
    return own


def read(work: Path, own: Path, name: str, path: Path) -> dict[str, Any]:
    """Read a path with a foreign loader; returns what it says."""
    offline = {"HF_HUB_OFFLINE": "1", "HF_HOME": str(work / "cache"), "PYTHONPATH": str(work / name)}
    command = [str(own), str(HERE / "formats" / f"read_{name}.py"), str(path)]
    done = subprocess.run(command, env={**os.environ, **offline}, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{name} cannot read {path.name}:\n{done.stderr[-3000:]}")
    said: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return said


def check(name: str, said: dict[str, Any]) -> None:
    """Compare what a loader says with what was written."""
    actions = np.concatenate([sample(i).actions for i in range(EPISODES)])
    steps = EPISODES * STEPS
    assert np.allclose(said["first_action"], actions[0], atol=1e-6), said["first_action"]
    if name == "robomimic":
        assert said["counts"] == {"all": [12, steps], "train": [11, 11 * STEPS], "valid": [1, STEPS]}, said["counts"]
        assert said["read"] == steps
        assert said["shapes"] == {"front_image": [10, 96, 128, 3], "gripper_pos": [10, 3], "object_pose": [10, 7]}
        assert said["env"]["env_name"] == "graft/Lift-v0"
        assert said["env"]["type"] == 2
        return
    assert [said[key] for key in ("episodes", "steps", "said_episodes", "said_steps")] == [12, steps, 12, steps]
    assert said["tasks"] == ["lift the mug"]
    assert said["shapes"]["observation.state"] == [10]
    assert said["shapes"]["observation.images.front"] == [3, 96, 128]
    assert np.allclose(said["mean_action"], actions.mean(axis=0), atol=1e-6)
    pixels = np.mean([np.mean(list(sample(i).cameras["front"])) for i in range(EPISODES)]) / 255
    assert abs(said["mean_pixel"] - pixels) < 0.02, (said["mean_pixel"], pixels)


def main() -> None:
    """Write, build, read, compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, help="where the environment goes")
    parser.add_argument("--keep", action="store_true", help="leave the environment there")
    parser.add_argument("--python", default=sys.executable, help="interpreter to make it from")
    options = parser.parse_args()
    work = options.work or Path(tempfile.mkdtemp(prefix="graft-formats-"))
    began = time.time()
    try:
        samples = work / "samples"
        shutil.rmtree(samples, ignore_errors=True)
        with open_writer(samples / "lift.hdf5") as writer:
            for number in range(EPISODES):
                writer.append(sample(number))
        export_episodes(samples / "lift.hdf5", samples / "lift")
        export_episodes(samples / "lift", samples / "back.hdf5")
        own = environment(work, options.python)
        for name, target in (("robomimic", "lift.hdf5"), ("robomimic", "back.hdf5"), ("lerobot", "lift")):
            said = read(work, own, name, samples / target)
            check(name, said)
            print(f"{LOADERS[name]} {said['loader']} reads {target}: {EPISODES} episodes, {EPISODES * STEPS} steps")
        print(f"{time.time() - began:.0f} s")
    finally:
        if not options.keep:
            shutil.rmtree(work, ignore_errors=True)


if __name__ == "__main__":
    main()
