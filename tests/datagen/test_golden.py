"""The layouts that trainers read, key by key. A change here breaks somebody's files: raise the schema, or change back.

GRAFT_GOLDEN=write rewrites the files.
"""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from sample_episodes import episode

h5py = pytest.importorskip("h5py")
pytest.importorskip("av")
pq = pytest.importorskip("pyarrow.parquet")

from graft.datagen.export import open_writer  # noqa: E402

GOLDEN = Path(__file__).parents[1] / "golden"
SYMBOLS = {11: "T", 7: "A", 13: "s", 32: "h", 48: "w", 2: "demos"}
"""Sizes of the sample episodes; all different."""


def written(path):
    with open_writer(path) as writer:
        for number in range(2):
            writer.append(episode(number, cameras=("front",)))
    return path


def symbols(shape):
    return [SYMBOLS.get(size, size) for size in shape]


def kind(value):
    return type(value).__name__ if isinstance(value, str) else str(np.asarray(value).dtype)


def hdf5_schema(path):
    schema = {}

    def visit(name, item):
        if name.startswith("data/demo_1"):
            return
        entry = {key: kind(item.attrs[key]) for key in sorted(item.attrs)}
        if isinstance(item, h5py.Dataset):
            string = item.dtype.kind == "S"
            schema[name] = ["bytes" if string else str(item.dtype), symbols(item.shape)]
        elif entry:
            schema[name] = entry

    with h5py.File(path) as file:
        schema["/"] = {key: kind(value) for key, value in file.attrs.items()}
        file.visititems(visit)
    return schema


def lerobot_schema(root):
    info = json.loads((root / "meta/info.json").read_text())
    info["graft_version"] = "version"
    statistics = json.loads((root / "meta/stats.json").read_text())
    schema = {
        "files": sorted(str(p.relative_to(root)) for p in root.rglob("*") if p.is_file()),
        "meta/info.json": info,
        "meta/stats.json": {
            feature: {key: list(np.shape(value)) for key, value in values.items()}
            for feature, values in statistics.items()
        },
    }
    for name in ("data/chunk-000/file-000", "meta/episodes/chunk-000/file-000", "meta/tasks"):
        table = pq.read_table(root / f"{name}.parquet", partitioning=None)
        # The items of lists are called "item" or "element", depending on the version of pyarrow.
        schema[name] = {field.name: str(field.type).replace("element", "item") for field in table.schema}
        if table.schema.metadata:
            schema[name + " pandas"] = json.loads(table.schema.metadata[b"pandas"])
    schema["record"] = hdf5_schema(root / "graft/chunk-000/file-000.hdf5")
    return schema


@pytest.mark.parametrize(
    ("target", "schema"), [("lift.hdf5", hdf5_schema), ("lift", lerobot_schema)], ids=["robomimic", "lerobot"]
)
def test_layouts_are_those_of_the_golden_files(tmp_path, target, schema):
    golden = GOLDEN / ("robomimic.json" if target == "lift.hdf5" else "lerobot.json")
    found = json.loads(json.dumps(schema(written(tmp_path / target))))
    if os.environ.get("GRAFT_GOLDEN") == "write":
        golden.write_text(json.dumps(found, indent=1) + "\n")
    assert found == json.loads(golden.read_text())
