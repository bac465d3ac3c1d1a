"""Print what every stage of the main job costs, per target, from the file on disk to the contact.

    python benches/pipeline.py [OBJECTS]

Without OBJECTS the targets are zoo objects written to files first; with it, folders of labelled objects. The library
is the demo's. Medians over the targets, one warm-up each.
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import graft
from graft import zoo
from graft.contact import VOTERS
from graft.demo import demonstrations


def timed(call, *arguments, **options):
    """Return what the call returns and its milliseconds, the second of two calls."""
    call(*arguments, **options)
    start = time.perf_counter()
    result = call(*arguments, **options)
    return result, 1e3 * (time.perf_counter() - start)


def stages(path, library):
    """Return stage -> milliseconds for one target."""
    obj, load = timed(graft.load_object, path)
    _, geometry = timed(graft.build_graph, obj, descriptor=None)
    graph, whole = timed(graft.build_graph, obj)
    matches, retrieve = timed(library.retrieve, graph, k=VOTERS)
    _, transfer = timed(lambda: graft.agree([graft.transfer_contact(match) for match in matches]))
    return obj, {
        "load the file": load,
        "part graph without descriptor": geometry,
        "part graph": whole,
        f"match {len(library)} sources": retrieve,
        f"transfer {VOTERS} contacts, vote": transfer,
        "graph to contact": whole + retrieve + transfer,
    }


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("objects", type=Path, nargs="?", help="folder of labelled objects")
    folder = parser.parse_args().objects
    library = graft.Library()
    library.extend(demonstrations())
    with tempfile.TemporaryDirectory() as scratch:
        if folder is None:
            paths = []
            for category in zoo.unseen():
                paths.append(Path(scratch) / f"{category}.glb")
                graft.save_object(paths[-1], zoo.make(category))
        else:
            paths = sorted(path.parent for path in folder.glob("*/object.json"))
        found = [stages(path, library) for path in paths]
    faces, parts = ([f(obj) for obj, _ in found] for f in (lambda o: o.n_faces, lambda o: len(o.parts)))
    print(f"{len(found)} targets, {min(faces)} to {max(faces)} faces, {min(parts)} to {max(parts)} parts")
    print(f"{'stage':32} {'median ms':>10} {'slowest ms':>11}")
    for stage in found[0][1]:
        times = [row[stage] for _, row in found]
        print(f"{stage:32} {statistics.median(times):10.2f} {max(times):11.2f}")


if __name__ == "__main__":
    main()
