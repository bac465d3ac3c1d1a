"""Objects whose parts nobody drew: cut by graft itself, with the mask of the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graft.objects import PartObject
from graft.parts import cut_part, fused, with_labels


def automatic_parts(obj: PartObject, seed: int = 0) -> PartObject:
    """Return `obj` fused and cut anew.

    A new part is graspable when at least half of its area was, or, when that is true of none, the part with the
    largest share.

    Args:
        obj: With parts as drawn.
        seed: Of the segmentation.
    """
    whole = fused(obj)
    labels = cut_part(whole, seed=seed).labels
    if whole.is_point_cloud:
        areas = np.ones(len(whole.vertices))
        sizes = [len(part.vertices) for part in obj.parts]
    else:
        corners = whole.vertices[whole.faces]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        sizes = [len(part.faces) for part in obj.parts]
    mask = np.repeat([i in obj.graspable for i in range(len(obj.parts))], sizes)
    shares = np.bincount(labels, areas * mask) / np.maximum(np.bincount(labels, areas), np.finfo(float).tiny)
    graspable = np.flatnonzero(shares >= 0.5).tolist() or [int(np.argmax(shares))]
    return replace(with_labels(obj, whole, labels), graspable=tuple(graspable) if obj.graspable else ())
