"""From one labelled mesh or point cloud to parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.io.pieces import RawMesh
from graft.objects import Ints


def split_by_labels(
    mesh: RawMesh, labels: Ints, names: tuple[str, ...] | None, *, path: str | Path
) -> tuple[list[RawMesh], list[int]]:
    """Cut a mesh along its face labels, or a cloud by its point labels.

    A vertex between two parts goes to both.

    Args:
        mesh: f triangles cut from p polygons, or v points and no faces.
        labels: One per polygon or per triangle; one per point of a cloud. A mesh may also be labelled per
            vertex: each triangle then takes the label that two of its corners share, else the lowest.
        names: Name of each label number; part_<number> when None.
        path: For messages.

    Returns:
        The pieces and their label numbers, in the order of the numbers.

    Raises:
        InputError: Another number of labels, or a label without a name.
    """
    cloud = not len(mesh.faces)
    if cloud:
        if len(labels) != len(mesh.vertices):
            raise InputError(f"{len(labels)} labels for {len(mesh.vertices)} points", path=path)
    elif len(labels) == len(mesh.faces):
        pass
    elif len(labels) == mesh.n_polygons and mesh.polygon is not None:
        labels = labels[mesh.polygon]
    elif len(labels) == len(mesh.vertices):
        corners = np.sort(labels[mesh.faces], axis=1)
        labels = np.where(corners[:, 1] == corners[:, 2], corners[:, 1], corners[:, 0])
    else:
        raise InputError(f"{len(labels)} labels for {mesh.n_polygons} faces", path=path)
    numbers, place = np.unique(labels, return_inverse=True)
    if names is not None and len(numbers) and not (numbers[0] >= 0 and numbers[-1] < len(names)):
        wrong = int(numbers[0] if numbers[0] < 0 else numbers[-1])
        raise InputError(f"label {wrong} has no name: part_names has {len(names)}, counted from 0", path=path)
    pieces = []
    for index, number in enumerate(numbers.tolist()):
        chosen = np.flatnonzero(place == index)
        name = names[number] if names is not None else f"part_{number}"
        pieces.append(mesh.with_points(name, chosen) if cloud else mesh.with_faces(name, chosen))
    return pieces, numbers.tolist()
