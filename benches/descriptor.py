"""Time, stability and retrieval of the geometric descriptor, per family and in total.

python benches/descriptor.py [--objects FOLDER [--constants]]

FOLDER holds one folder per object (mesh.ply, parts.seg, object.json). With --constants, print the arrays of
rust/graft-core/src/descriptor/constants.rs instead, measured on every other object of FOLDER and of the YCB scans.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from graft import zoo
from graft.features import FAMILIES, GeometricDescriptor
from graft.objects import Part, PartObject


def load(folder: Path) -> PartObject:
    """Read one labelled mesh."""
    about = json.loads((folder / "object.json").read_text())
    mesh = trimesh.load(folder / "mesh.ply", process=False)
    labels = np.loadtxt(folder / "parts.seg", dtype=int)
    parts = []
    for k, name in enumerate(about["part_names"]):
        used, faces = np.unique(mesh.faces[labels == k], return_inverse=True)
        parts.append(Part(f"{name}_{k}", mesh.vertices[used], faces.reshape(-1, 3)))
    return PartObject(folder.name, parts, category=about["category"], graspable=about["graspable_parts"])


def solids() -> list[PartObject]:
    """Return shapes of trimesh, for a run without data."""
    make = trimesh.creation
    meshes = [
        make.icosphere(4),
        make.torus(1, 0.2),
        make.cylinder(0.2, 2).subdivide(),
        make.box().subdivide(),
    ]
    return [PartObject(f"solid_{k}", [Part("a", m.vertices, m.faces)]) for k, m in enumerate(meshes)]


def turned(obj: PartObject, rng: np.random.Generator) -> PartObject:
    """Rotate and scale at random."""
    transform = np.eye(4)
    transform[:3, :3] = Rotation.random(rng=rng).as_matrix() * np.exp(rng.uniform(-1, 1))
    return obj.transformed(transform)


def retrieval(objects: list[PartObject], rows: list[np.ndarray]) -> tuple[float, float, float, float]:
    """Leave-category-out pair, top-1 and top-5 accuracy; 1-NN of (category, graspable) over other objects."""
    pairs, top1, top5, nearest = [], [], [], []
    for t, target in enumerate(objects):
        ranked = []
        for s, source in enumerate(objects):
            if source.category == target.category:
                continue
            distance = 1.0 - rows[s][list(source.graspable)] @ rows[t].T
            hits = [int(k) in target.graspable for k in distance.argmin(axis=1)]
            pairs += hits
            best = int(distance.min(axis=1).argmin())
            ranked.append((distance.min(), s, hits[best]))
        ranked.sort()
        top1.append(ranked[0][2])
        top5.append(np.mean([hit for *_, hit in ranked[:5]]))
        if sum(o.category == target.category for o in objects) > 1:
            for k, vector in enumerate(rows[t]):
                near = [(float((rows[s] @ vector).max()), s) for s in range(len(objects)) if s != t]
                s = max(near)[1]
                found = int((rows[s] @ vector).argmax())
                same = (found in objects[s].graspable) == (k in target.graspable)
                nearest.append(same and objects[s].category == target.category)
    return float(np.mean(pairs)), float(np.mean(top1)), float(np.mean(top5)), float(np.mean(nearest))


def print_constants(objects: list[PartObject]) -> None:
    """Print mean and deviation of every raw feature over the parts of `objects` and four seeds, as Rust."""
    print(f"// {sum(len(o.parts) for o in objects)} parts of {len(objects)} objects")
    for family in FAMILIES:
        describe = [GeometricDescriptor(families=(family,), seed=seed).raw_features for seed in range(4)]
        rows = np.concatenate([raw(o) for raw in describe for o in objects])
        pairs = [f"[{m:.4f}, {d:.4f}]" for m, d in zip(np.nanmean(rows, 0), np.nanstd(rows, 0), strict=True)]
        print(f"pub const {family.upper()}: … = [")
        for k in range(0, len(pairs), 6):
            print("    " + ", ".join(pairs[k : k + 6]) + ",")
        print("];")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=Path)
    parser.add_argument("--constants", action="store_true")
    arguments = parser.parse_args()
    folder = arguments.objects
    if arguments.constants:
        if folder is None:
            parser.error("--constants needs --objects")
        scans = [zoo.ycb_object(name) for name in sorted(zoo.ycb_names())[::2]]
        print_constants([load(p.parent) for p in sorted(folder.glob("*/object.json"))[::2]] + scans)
        return
    objects = [load(p.parent) for p in sorted(folder.glob("*/object.json"))] if folder else solids()
    n = sum(len(o.parts) for o in objects)
    moved = [turned(o, np.random.default_rng(k)) for k, o in enumerate(objects)]
    print(f"{len(objects)} objects, {n} parts; objects turned and scaled at random; CPU time, all threads")
    print("families       ms/part  1-cos turned (median, max)  1-cos other seed (median, max)")
    for families in [*((f,) for f in FAMILIES), FAMILIES]:
        descriptor = GeometricDescriptor(families=families)
        start = time.process_time()
        rows = [descriptor.describe(o) for o in objects]
        spent = 1e3 * (time.process_time() - start) / n
        again = [descriptor.describe(o) for o in moved]
        other = [GeometricDescriptor(families=families, seed=1).describe(o) for o in objects]
        turn, seed = (
            np.concatenate([1 - (a * b).sum(1) for a, b in zip(rows, r, strict=True)]) for r in (again, other)
        )
        name = "total" if len(families) > 1 else families[0]
        print(f"{name:14} {spent:7.2f}  {np.median(turn):.1e} {turn.max():.1e}  {np.median(seed):.4f} {seed.max():.4f}")
        if folder:
            for half, which in (
                ("tuning", slice(0, None, 2)),
                ("held-out", slice(1, None, 2)),
                ("all", slice(None)),
            ):
                scores = " ".join(f"{x:.3f}" for x in retrieval(objects[which], again[which]))
                print(f"    {half:9} pair, top-1, top-5 across categories; 1-NN within: {scores}")


if __name__ == "__main__":
    main()
