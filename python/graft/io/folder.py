"""A folder as an object: what kind it is, and one mesh per part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from graft.errors import InputError
from graft.io.cloud import TEXT_SUFFIXES
from graft.io.file import ROBOT_SUFFIXES, assemble, load_mesh_file, load_robot_file
from graft.io.guards import contained
from graft.io.mesh_file import MESH_SUFFIXES, read_raw
from graft.io.pieces import merged
from graft.io.sidecar import ObjectWords, read_object_words
from graft.objects import PartObject

DEMONSTRATION_FILE = "demonstration.json"

PARTNET_SIGNS = ("mobility.urdf", "semantics.txt")
"""A folder without any of these is not of PartNet-Mobility."""

LOOKED_FOR = (
    f"{DEMONSTRATION_FILE}, a PartNet-Mobility folder, one URDF or MJCF file, "
    f"meshes ({', '.join(MESH_SUFFIXES)}), or one point cloud ({', '.join(TEXT_SUFFIXES)}, .npz)"
)


def load_folder(
    folder: Path,
    *,
    parts: Literal["auto", "bodies", "geoms", "links", "visuals"],
    packages: Mapping[str, Path],
    missing: Literal["error", "skip"],
) -> PartObject:
    """Read a folder: the first that applies of what `LOOKED_FOR` lists; its name is the object's."""
    if (folder / DEMONSTRATION_FILE).is_file():
        from graft.io.demonstrations import load_demonstration

        return load_demonstration(folder).object
    if any((folder / name).is_file() for name in PARTNET_SIGNS):
        from graft.io.partnet import is_partnet, load_partnet

        if is_partnet(folder):
            partnet: PartObject = load_partnet(folder, missing=missing)
            return partnet
    files = [p for p in sorted(folder.iterdir()) if p.is_file() and not p.name.startswith(".")]
    robots = [p for p in files if p.suffix.lower() in ROBOT_SUFFIXES]
    meshes = [p for p in files if p.suffix.lower() in MESH_SUFFIXES]
    clouds = [p for p in files if p.suffix.lower() in (*TEXT_SUFFIXES, ".npz") and p.stem.lower() != "readme"]
    if len(robots) > 1:
        raise InputError(f"several robot files, name one: {', '.join(p.name for p in robots)}", path=folder)
    if robots:
        return load_robot_file(robots[0], parts=parts, packages=packages, missing=missing)
    if parts != "auto":
        raise InputError(f"parts: {parts!r} is a choice for MJCF and URDF, neither is here", path=folder)
    for path in meshes:
        contained(path, root=folder, reference=path.name, path=folder)
    if len(meshes) > 1:
        return _one_mesh_per_part(folder, meshes)
    if meshes:
        return _named(load_mesh_file(meshes[0], alone=True), meshes[0], folder)
    if len(clouds) == 1:
        contained(clouds[0], root=folder, reference=clouds[0].name, path=folder)
        return _named(load_mesh_file(clouds[0], alone=True), clouds[0], folder)
    if clouds:
        raise InputError(f"several point clouds, name one: {', '.join(p.name for p in clouds)}", path=folder)
    raise InputError(f"nothing to read here; looked for {LOOKED_FOR}", path=folder)


def _named(obj: PartObject, path: Path, folder: Path) -> PartObject:
    """Call an object that has no name of its own by its folder and not `mesh`."""
    return replace(obj, name=folder.resolve().name) if obj.name == path.stem else obj


def _one_mesh_per_part(folder: Path, paths: list[Path]) -> PartObject:
    """Read one part from each file, called by its stem; object.json's order, else that of the names."""
    stems = [path.stem for path in paths]
    for first, second in pairwise(paths):
        if first.stem == second.stem:
            raise InputError(f"duplicate part name {first.stem!r}: {first.name} and {second.name}", path=folder)
    words_file = folder / "object.json"
    words = read_object_words(words_file) if words_file.is_file() else ObjectWords()
    if words.part_names is not None:
        if sorted(words.part_names) != sorted(stems):
            raise InputError(
                f"part_names {', '.join(words.part_names)}; the meshes next to it are {', '.join(stems)}",
                path=words_file,
            )
        paths = [paths[stems.index(name)] for name in words.part_names]
    if any(g >= len(paths) for g in words.graspable):
        raise InputError(f"graspable_parts {list(words.graspable)}: there are {len(paths)} parts", path=words_file)
    obj = assemble(
        words.name or folder.resolve().name,
        [merged(path.stem, read_raw(path)) for path in paths],
        path=folder,
    )
    return replace(
        obj,
        category=words.category,
        up=None if words.up is None else np.array(words.up),
        scale_to_metres=words.scale_to_metres,
        graspable=words.graspable,
    )
