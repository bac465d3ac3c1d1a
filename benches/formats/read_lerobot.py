"""Run in an environment with lerobot: read a dataset with LeRobot's own class and print what it says of it."""

import json
import sys
from pathlib import Path

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

root = Path(sys.argv[1])
data = LeRobotDataset("graft/sample", root=root, video_backend="pyav")
loader = torch.utils.data.DataLoader(data, batch_size=16, shuffle=False)
steps, episodes, tasks, pixels = 0, set(), set(), 0.0
for batch in loader:
    steps += len(batch["index"])
    episodes.update(batch["episode_index"].tolist())
    tasks.update(batch["task"])
    for key in data.meta.video_keys:
        pixels += float(batch[key].mean())
shifted = LeRobotDataset(
    "graft/sample", root=root, video_backend="pyav", episodes=[1], delta_timestamps={"action": [0.0, 1 / data.fps]}
)
print(
    json.dumps(
        {
            "loader": "LeRobotDataset",
            "episodes": len(episodes),
            "steps": steps,
            "said_episodes": data.num_episodes,
            "said_steps": data.num_frames,
            "tasks": sorted(tasks),
            "shapes": {key: list(value.shape) for key, value in data[0].items() if hasattr(value, "shape")},
            "first_action": data[0]["action"].tolist(),
            "mean_action": data.meta.stats["action"]["mean"].tolist(),
            "two_actions": list(shifted[0]["action"].shape),
            "mean_pixel": pixels / len(loader),
        }
    )
)
