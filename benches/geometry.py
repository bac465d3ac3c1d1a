"""Minimal boxes against trimesh on the same parts, and whole part graphs.

    python benches/geometry.py [OBJECTS_DIR]

OBJECTS_DIR has one folder per object with a mesh.ply and a parts.seg (one part number per face). Without it
the parts are meshes made on the fly.
"""

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from graft import _core
from graft.graph import build_graph
from graft.objects import Part, PartObject

TURNS = Rotation.random(8, rng=np.random.default_rng(0)).as_matrix()
"""Poses in which every part is boxed."""


def milliseconds(work: Callable[[], object], repeats: int) -> float:
    """Return the median wall time of `work`."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def labelled_objects(folder: Path) -> list[PartObject]:
    """Read every labelled mesh under a folder."""
    objects = []
    for path in sorted(folder.glob("*/mesh.ply")):
        mesh = trimesh.load(path, process=False)
        labels = np.loadtxt(path.with_name("parts.seg"), dtype=int)
        parts = []
        for label in np.unique(labels):
            used, faces = np.unique(mesh.faces[labels == label], return_inverse=True)
            parts.append(Part(str(label), mesh.vertices[used], faces.reshape(-1, 3)))
        objects.append(PartObject(path.parent.name, tuple(parts)))
    return objects


def made_objects() -> list[PartObject]:
    """Make three objects of five parts and about 30,000 faces: round, blocky and bumpy ones."""
    rng = np.random.default_rng(0)
    round_parts = [
        trimesh.creation.torus(1.0, 0.2, major_sections=64, minor_sections=48),
        trimesh.creation.capsule(height=2.0, radius=0.4, count=[56, 56]),
        trimesh.creation.cylinder(radius=0.6, height=1.0, sections=1500),
        trimesh.creation.cone(radius=0.5, height=1.0, sections=3000),
        trimesh.creation.uv_sphere(radius=0.7, count=[56, 56]),
    ]
    blocky = [trimesh.creation.box([1.0 + k, 0.5, 0.2 * k + 0.1]) for k in range(5)]
    for _ in range(5):
        blocky = [mesh.subdivide() for mesh in blocky]
    bumpy = []
    for k in range(5):
        mesh = trimesh.creation.icosphere(subdivisions=4)
        mesh.vertices *= (1 + 0.05 * rng.normal(size=(len(mesh.vertices), 1))) * [1, 0.4 + 0.1 * k, 0.7]
        bumpy.append(mesh)
    return [
        PartObject(
            name,
            tuple(Part(f"p{k}", m.vertices + np.array([0, 0, 1.5 * k]), m.faces) for k, m in enumerate(meshes)),
        )
        for name, meshes in (("round", round_parts), ("blocky", blocky), ("bumpy", bumpy))
    ]


def worst_turned(objects: list[PartObject]) -> tuple[float, str]:
    """Return by what share the volume of a part's box changes at most when the part is turned, and which part's."""
    worst, name = 0.0, ""
    for obj in objects:
        for part in obj.parts:
            turned = (np.ascontiguousarray(part.vertices @ turn.T) for turn in TURNS)
            volumes = [8 * _core.oriented_box(points)[2].prod() for points in turned]
            spread = max(volumes) / max(min(volumes), 1e-300) - 1
            if spread > worst:
                worst, name = spread, f"{obj.name}/{part.name}"
    return worst, name


def main() -> None:
    """Print the tables."""
    objects = labelled_objects(Path(sys.argv[1])) if len(sys.argv) > 1 else made_objects()
    ours, peer, sizes = [], [], []
    for obj in objects:
        for part in obj.parts:
            points = np.ascontiguousarray(part.vertices[np.unique(part.faces)])
            ours.append(milliseconds(lambda points=points: _core.oriented_box(points), 5))
            peer.append(milliseconds(lambda points=points: trimesh.bounds.oriented_bounds(points), 1))
            box = 8 * _core.oriented_box(points)[2].prod()
            sizes.append(box / trimesh.bounds.oriented_bounds(points)[1].prod())
    ratios = [b / a for a, b in zip(ours, peer, strict=True)]
    print(f"minimal boxes of {len(ours)} parts        graft    trimesh")
    print(f"  median, ms                 {statistics.median(ours):9.2f} {statistics.median(peer):9.2f}")
    print(f"  slowest, ms                {max(ours):9.2f} {max(peer):9.2f}")
    print(f"  sum, ms                    {sum(ours):9.1f} {sum(peer):9.1f}")
    print(f"  trimesh's time over graft's: median {statistics.median(ratios):.1f}, least {min(ratios):.1f}")
    print(f"  graft's volume over trimesh's: largest {max(sizes):.9f}, median {statistics.median(sizes):.4f}")
    spread, name = worst_turned(objects)
    print(f"  volume in {len(TURNS)} poses, largest over smallest less 1: {spread:.1e} ({name})")
    print("whole part graphs")
    print(f"  {'object':20} {'faces':>7} {'parts':>5} {'bare, ms':>9} {'with descriptor':>16}")
    for obj in sorted(objects, key=lambda o: -o.n_faces)[:12]:
        print(
            f"  {obj.name:20} {obj.n_faces:7d} {len(obj.parts):5d} "
            f"{milliseconds(lambda obj=obj: build_graph(obj, descriptor=None), 5):9.2f} "
            f"{milliseconds(lambda obj=obj: build_graph(obj), 5):16.2f}"
        )


if __name__ == "__main__":
    main()
