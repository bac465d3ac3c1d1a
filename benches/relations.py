"""Print the mean and standard deviation of every relation of parts, for `STANDARD` in graph/relations.rs.

    python benches/relations.py OBJECTS

The population: every other folder of labelled objects under OBJECTS in the order of their names, every other YCB scan,
and two variants of every category of the zoo.
"""

import argparse
from pathlib import Path

import numpy as np

import graft
from graft import _core, zoo


def raw_relations(obj):
    """Return (n, 17) features of an object's parts before standardisation, NaN where unknown."""
    graph = graft.build_graph(obj, descriptor=None)
    up = None if obj.up is None else tuple(obj.up.tolist())
    boxes = graph.centers, graph.axes, graph.half_extents
    return _core.part_relations(*boxes, np.stack(graph.points), graph.areas, graph.diagonal, up, raw=True)


def population(objects):
    """Yield the objects that the constants are measured on."""
    folders = sorted(path.parent for path in objects.glob("*/object.json"))
    yield from (graft.load_object(folder) for folder in folders[::2])
    yield from (zoo.ycb_object(name) for name in zoo.ycb_names()[::2])
    yield from (zoo.make(category, seed) for category in zoo.categories() for seed in (0, 1))


def main():
    """Print the table as Rust."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("objects", type=Path, help="folder of labelled objects")
    rows = np.vstack([raw_relations(obj) for obj in population(parser.parse_args().objects)])
    mean, deviation = np.nanmean(rows, axis=0), np.nanstd(rows, axis=0)
    print(f"{len(rows)} parts")
    for k, (m, s) in enumerate(zip(mean, deviation, strict=True)):
        print(f"[{m:.4f}, {s:.4f}],", end="\n" if k % 6 == 5 else " ")
    print()


if __name__ == "__main__":
    main()
