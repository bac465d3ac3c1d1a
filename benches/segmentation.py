"""Automatic parts: processor time and memory by number of faces, beside CGAL's shape diameter where it is installed.

    python benches/segmentation.py [MESH] [--most FACES]

MESH (any file that graft reads, its parts fused) is refined until it has enough faces: every triangle becomes four,
so the shape stays the same. Without it a dumbbell is cut. Each row is a process of its own.
"""

import argparse
import importlib.util
import multiprocessing
import resource
import time

import numpy as np
import trimesh

import graft
from graft.evaluate.cutters import Cutter, Ours, ShapeDiameter
from graft.objects import Floats, Ints
from graft.parts import fused

PEER_FACES = 40_000
"""CGAL is asked up to here."""


def start_mesh(path: str | None) -> tuple[Floats, Ints]:
    """Return the mesh that is refined."""
    if path is not None:
        part = fused(graft.load_object(path))
        return part.vertices, part.faces
    profile = [(0.001, -1.0), (0.35, -0.9), (0.4, -0.7), (0.35, -0.5), (0.1, -0.4)]
    line = np.array(profile + [(r, -z) for r, z in reversed(profile)])
    mesh = trimesh.creation.revolve(line, sections=72)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int64)


def measured(cutter: Cutter, vertices: Floats, faces: Ints, rounds: int, queue: "multiprocessing.Queue") -> None:
    """Refine, cut, and send faces, processor seconds, growth of the peak memory in MB, and parts."""
    for _ in range(rounds):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    faces = np.ascontiguousarray(faces, np.int64)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    labels = cutter.cut(vertices, faces, 2, 0)
    seconds = time.process_time() - start
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    queue.put((len(faces), seconds, grown, int(labels.max()) + 1))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?")
    parser.add_argument("--most", type=int, default=5_500_000, help="faces at most")
    options = parser.parse_args()
    vertices, faces = start_mesh(options.mesh)
    cutters: list[Cutter] = [Ours()]
    if importlib.util.find_spec("cgal_pybind") is not None:
        cutters.append(ShapeDiameter())
    context = multiprocessing.get_context("spawn")
    print(f"{'method':<22}{'faces':>10}{'cpu s':>9}{'MB more':>10}{'parts':>7}")
    rounds = 0
    while len(faces) * 4**rounds <= options.most:
        for cutter in cutters:
            if cutter.name != Ours().name and len(faces) * 4**rounds > PEER_FACES:
                continue
            queue = context.Queue()
            process = context.Process(target=measured, args=(cutter, vertices, faces, rounds, queue))
            process.start()
            count, seconds, grown, parts = queue.get()
            process.join()
            print(f"{cutter.name:<22}{count:>10}{seconds:>9.2f}{grown:>10.0f}{parts:>7}", flush=True)
        rounds += 1


if __name__ == "__main__":
    main()
