"""`segment` and `segment_hierarchy`: automatic parts of anything that names an object."""

from __future__ import annotations

from graft.io.load import ObjectLike, as_object
from graft.objects import PartObject
from graft.parts import cut_hierarchy, cut_object


def segment(mesh: ObjectLike, *, n_parts: int | None = None, fuse: bool = False, seed: int = 0) -> PartObject:
    """Cut a fused mesh or point cloud into parts.

    Regions that more people would tell apart than not become parts: how likely they are to is a logistic function
    of how badly the regions see each other inside the closed solid (van Kaick et al. 2014), how their thickness
    differs (shape diameter, Shapira et al. 2008), and of their seam; it was fitted to people's cuts of household
    objects. Connected components of at least a hundredth of the area are parts of their own first. Any mesh is
    taken: open, non-manifold, inside out, a soup, millions of faces (cut on a coarser copy); the notes tell.

    Args:
        mesh: A path, a `PartObject`, a `trimesh.Trimesh` or `Scene`, `(vertices, faces)` or `(points, None)`.
        n_parts: How many parts; as many as people would make when None.
        fuse: Cut anew what has parts. Otherwise 2 to 32 parts are kept as they are: they carry meaning; more
            are a soup and are fused in any case.
        seed: Of the points that measures are taken at; the same seed gives the same parts.

    Returns:
        The object with parts part_0, part_1, …, by falling area; `notes` tell what was repaired.

    Raises:
        InputError: The object cannot be read, or an argument is out of range.
    """
    return cut_object(as_object(mesh), n_parts=n_parts, fuse=fuse, seed=seed)


def segment_hierarchy(mesh: ObjectLike, *, seed: int = 0) -> tuple[PartObject, ...]:
    """Cut a mesh or point cloud coarse to fine.

    Args:
        mesh: As for `segment`; what has parts is fused.
        seed: As for `segment`.

    Returns:
        One object per level, from one part to twice as many as people would make (at most 24). Each part is a
        union of parts of the next level.

    Raises:
        InputError: The object cannot be read.
    """
    return cut_hierarchy(as_object(mesh), seed=seed)[0]
