"""Run in an environment with robomimic: read a file with robomimic's own class and print what it says of it."""

import json
import sys

import h5py
import robomimic.utils.file_utils as FileUtils
import robomimic.utils.obs_utils as ObsUtils
import torch
from robomimic.utils.dataset import SequenceDataset

path = sys.argv[1]
with h5py.File(path) as file:
    keys = sorted(file["data/demo_0/obs"])
images = [key for key in keys if key.endswith("_image")]
low = [key for key in keys if key not in images]
ObsUtils.initialize_obs_utils_with_obs_specs({"obs": {"low_dim": low, "rgb": images}})
meta = FileUtils.get_shape_metadata_from_dataset({"path": path}, ["actions"])


def dataset(obs_keys, **options):
    """Return robomimic's dataset of these observations."""
    return SequenceDataset(
        hdf5_path=path,
        obs_keys=obs_keys,
        action_keys=["actions"],
        dataset_keys=["actions", "rewards", "dones"],
        action_config={"actions": {"normalization": None}},
        **options,
    )


counts = {}
for mask in (None, "train", "valid"):
    data = dataset(keys, seq_length=10, filter_by_attribute=mask, load_next_obs=False)
    counts[mask or "all"] = [data.n_demos, len(data)]
    if mask is None:
        first = data[0]
        read = sum(len(batch["actions"]) for batch in torch.utils.data.DataLoader(data, batch_size=16))
after = dataset(low, load_next_obs=True, hdf5_cache_mode="all")[0]["next_obs"]
print(
    json.dumps(
        {
            "loader": "SequenceDataset",
            "env": FileUtils.get_env_metadata_from_dataset(path),
            "action_size": meta["ac_dim"],
            "counts": counts,
            "read": read,
            "shapes": {key: list(value.shape) for key, value in first["obs"].items()},
            "next_shapes": {key: list(value.shape) for key, value in after.items()},
            "first_action": first["actions"][0].tolist(),
        }
    )
)
