"""What flows through graft: parts, objects made of parts, contacts and demonstrations.

Numpy only. Everything is frozen; arrays are converted to contiguous float64 or int64 once and made read-only.
Lengths are in the object's own unit until they are multiplied by `PartObject.scale_to_metres`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats as Floats
from graft.checks import Ints as Ints
from graft.checks import checked_array, is_rotation, similarity_scale, unit_vector
from graft.errors import InputError

if TYPE_CHECKING:
    from graft.trajectory import Trajectory

JointType = Literal["fixed", "hinge", "slide", "ball", "free", "planar"]
JOINT_TYPES: tuple[str, ...] = ("fixed", "hinge", "slide", "ball", "free", "planar")


@dataclass(frozen=True, eq=False)
class Part:
    """One part of an object: a piece of surface, or of a point cloud when it has no faces.

    Attributes:
        name: Unique within its object.
        vertices: (v, 3) positions in the object frame, object units.
        faces: (f, 3) vertex indices; (0, 3) for a point cloud.
        normals: (v, 3) outward unit normals of a point cloud's points; None for meshes, whose faces tell.
        label: What kind of part it is ("handle"); several parts may share one. Defaults to the name.
        notes: What was dropped or repaired when the part was read.
        sweeps: How the part is solid, where its maker knows: each an array (k, m) of vertex indices, k loops of m that
            a solid is swept through, so that the hulls of neighbouring loops together fill the part. Empty when
            unknown.
    """

    name: str
    vertices: Floats
    faces: Ints = field(default_factory=lambda: np.empty((0, 3), np.int64))
    normals: Floats | None = None
    label: str = ""
    notes: tuple[str, ...] = ()
    sweeps: tuple[Ints, ...] = ()

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("part name: expected a name, got an empty string")
        where = f"part {self.name!r}"
        object.__setattr__(self, "vertices", checked_array(f"{where} vertices", self.vertices, (None, 3)))
        object.__setattr__(self, "faces", checked_array(f"{where} faces", self.faces, (None, 3), np.int64))
        if len(self.vertices) == 0:
            raise InputError(f"{where} vertices: expected at least one, got none")
        if self.normals is not None:
            object.__setattr__(
                self, "normals", checked_array(f"{where} normals", self.normals, (len(self.vertices), 3))
            )
        if len(self.faces) and (self.faces.min() < 0 or self.faces.max() >= len(self.vertices)):
            row = int(np.argwhere((self.faces < 0) | (self.faces >= len(self.vertices)))[0][0])
            raise InputError(
                f"{where} face {row}: vertex index out of range, {self.faces[row].tolist()} of "
                f"{len(self.vertices)} vertices"
            )
        sweeps = tuple(checked_array(f"{where} sweep", sweep, (None, None), np.int64) for sweep in self.sweeps)
        if any(s.size and not 0 <= s.min() <= s.max() < len(self.vertices) for s in sweeps):
            raise InputError(f"{where} sweep: vertex index out of range, the part has {len(self.vertices)} vertices")
        object.__setattr__(self, "sweeps", sweeps)
        object.__setattr__(self, "label", self.label or self.name)
        object.__setattr__(self, "notes", tuple(self.notes))

    @property
    def is_point_cloud(self) -> bool:
        """True when the part has points but no faces."""
        return len(self.faces) == 0

    def transformed(self, transform: Floats) -> Part:
        """Return the part moved by `transform` (4, 4), a similarity (rotation, uniform scale, translation)."""
        linear = transform[:3, :3]
        scale = float(np.cbrt(abs(np.linalg.det(linear))))
        normals = None if self.normals is None else self.normals @ (linear / scale).T
        return replace(self, vertices=self.vertices @ linear.T + transform[:3, 3], normals=normals)


@dataclass(frozen=True, eq=False)
class Joint:
    """An articulated or fixed connection between two parts, an edge of the part graph.

    Attributes:
        parent: Index of the parent part.
        child: Index of the child part.
        kind: One of `JOINT_TYPES`.
        name: As in the file.
        axis: (3,) unit axis in the object frame; None where the kind has none.
        origin: (3,) a point on the axis, object frame, object units.
        limits: (lower, upper) in radians (hinge) or object units (slide); None when unlimited.
    """

    parent: int
    child: int
    kind: JointType = "fixed"
    name: str = ""
    axis: Floats | None = None
    origin: Floats | None = None
    limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        where = f"joint {self.name!r}"
        if self.kind not in JOINT_TYPES:
            raise InputError(f"{where} kind: expected one of {', '.join(JOINT_TYPES)}, got {self.kind!r}")
        if self.axis is not None:
            object.__setattr__(self, "axis", unit_vector(f"{where} axis", self.axis))
        if self.origin is not None:
            object.__setattr__(self, "origin", checked_array(f"{where} origin", self.origin, (3,)))


@dataclass(frozen=True, eq=False)
class PartObject:
    """An object as a list of parts in one frame.

    Attributes:
        name: For people; a file's stem by default.
        parts: At least one, with unique names.
        joints: Edges given by the file; empty where the format has none (adjacency then comes from geometry).
        category: What the object is ("mug"); None when unknown.
        up: (3,) unit vector against gravity in the object frame; None when it lies as it is.
        scale_to_metres: Multiply object units by this to get metres; None when unknown.
        graspable: Indices of the parts a person takes to use it; the mask of the ASR, NSS and DTM metrics.
        notes: What was noticed when it was read (dropped faces, guessed units), one line each.
        source: Where it came from, as given by the user; "" for objects made in memory.
    """

    name: str
    parts: tuple[Part, ...]
    joints: tuple[Joint, ...] = ()
    category: str | None = None
    up: Floats | None = None
    scale_to_metres: float | None = None
    graspable: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(self.parts))
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "graspable", tuple(sorted({int(i) for i in self.graspable})))
        object.__setattr__(self, "notes", tuple(self.notes))
        where = f"object {self.name!r}"
        if not self.parts:
            raise InputError(f"{where}: expected at least one part, got none")
        seen: set[str] = set()
        for part in self.parts:
            if part.name in seen:
                raise InputError(f"{where}: duplicate part name {part.name!r}")
            seen.add(part.name)
        for index in self.graspable:
            self._check_part(f"{where} graspable", index)
        for joint in self.joints:
            self._check_part(f"{where} joint {joint.name!r} parent", joint.parent)
            self._check_part(f"{where} joint {joint.name!r} child", joint.child)
        if self.up is not None:
            object.__setattr__(self, "up", unit_vector(f"{where} up", self.up))
        scale = self.scale_to_metres
        if scale is not None and not (np.isfinite(scale) and scale > 0):
            raise InputError(f"{where} scale_to_metres: expected a positive number, got {scale}")

    def _check_part(self, where: str, index: int) -> None:
        if not 0 <= index < len(self.parts):
            raise InputError(f"{where}: part index {index} out of range, the object has {len(self.parts)} parts")

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts, in order."""
        return tuple(part.name for part in self.parts)

    def part_index(self, part: int | str) -> int:
        """Return the index of `part`, given as an index, a name, or a label that only one part has.

        Raises:
            InputError: No such part, or several; the message lists the names.
        """
        if isinstance(part, int | np.integer):
            self._check_part(f"object {self.name!r}", int(part))
            return int(part)
        found = [i for i, p in enumerate(self.parts) if p.name == part]
        found = found or [i for i, p in enumerate(self.parts) if p.label == part]
        if len(found) != 1:
            what = "no part" if not found else f"{len(found)} parts"
            names = ", ".join(self.part_names)
            raise InputError(f"object {self.name!r}: {what} called {part!r}; the parts are {names}")
        return found[0]

    @property
    def bounds(self) -> Floats:
        """(2, 3) lowest and highest corner of the axis-aligned bounding box, object units."""
        lows = np.array([p.vertices.min(axis=0) for p in self.parts])
        highs = np.array([p.vertices.max(axis=0) for p in self.parts])
        return np.stack([lows.min(axis=0), highs.max(axis=0)])

    @property
    def n_faces(self) -> int:
        """Number of triangles over all parts."""
        return sum(len(part.faces) for part in self.parts)

    def transformed(self, transform: ArrayLike) -> PartObject:
        """Return the object moved by `transform`.

        Args:
            transform: (4, 4) similarity: rotation, uniform positive scale, translation.

        Raises:
            InputError: The matrix is not a similarity, or mirrors.
        """
        matrix: Floats = checked_array("transform", transform, (4, 4))
        linear = matrix[:3, :3]
        scale = similarity_scale(linear)
        # The comparison is of the matrix over its scale: micrometres and megametres are judged alike.
        if not 0 < scale < np.inf or not is_rotation(linear / scale):
            raise InputError("transform: expected a rotation, a positive uniform scale and a translation")

        def joint(old: Joint) -> Joint:
            axis = None if old.axis is None else linear @ old.axis / scale
            origin = None if old.origin is None else linear @ old.origin + matrix[:3, 3]
            stretch = scale if old.kind == "slide" else 1.0
            limits = None if old.limits is None else (old.limits[0] * stretch, old.limits[1] * stretch)
            return replace(old, axis=axis, origin=origin, limits=limits)

        return replace(
            self,
            parts=tuple(part.transformed(matrix) for part in self.parts),
            joints=tuple(joint(j) for j in self.joints),
            up=None if self.up is None else linear @ self.up / scale,
            scale_to_metres=None if self.scale_to_metres is None else self.scale_to_metres / scale,
        )


@dataclass(frozen=True, eq=False)
class Contact:
    """A place on an object's surface where a gripper takes it.

    Attributes:
        point: (3,) on the surface, object frame, object units.
        normal: (3,) outward unit normal there.
        part: Index of the part it lies on.
        approach: (3,) unit direction in which the gripper comes; None when not demonstrated.
    """

    point: Floats
    normal: Floats
    part: int
    approach: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", checked_array("contact point", self.point, (3,)))
        object.__setattr__(self, "normal", unit_vector("contact normal", self.normal))
        if self.approach is not None:
            object.__setattr__(self, "approach", unit_vector("contact approach", self.approach))

    def transformed(self, transform: ArrayLike) -> Contact:
        """Return the contact moved by `transform` (4, 4), a similarity."""
        matrix: Floats = checked_array("transform", transform, (4, 4))
        linear = matrix[:3, :3]
        scale = similarity_scale(linear)
        approach = None if self.approach is None else linear @ self.approach / scale
        normal = linear @ self.normal / scale
        return replace(self, point=linear @ self.point + matrix[:3, 3], normal=normal, approach=approach)


@dataclass(frozen=True, eq=False)
class Demonstration:
    """An object together with the contact that was demonstrated on it.

    Attributes:
        object: The object.
        contact: Where it was taken.
        name: Unique in a library; the object's name by default.
        metadata: Strings and numbers that travel with it (task, author, licence).
        grasp: (4, 4) T_object_gripper in which it was taken, in metres whatever the object's unit; None when not
            demonstrated. The gripper frame is that of `graft.grasp.gripper`.
        trajectory: What the gripper did; the object is called `graft.trajectory.DEMONSTRATED` in it. None when not
            demonstrated.
    """

    object: PartObject
    contact: Contact
    name: str = ""
    metadata: Mapping[str, Any] = field(default_factory=dict)
    grasp: Floats | None = None
    trajectory: Trajectory | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", self.name or self.object.name)
        self.object.part_index(self.contact.part)
        if self.grasp is not None:
            where = f"demonstration {self.name!r} grasp"
            object.__setattr__(self, "grasp", checked_array(where, self.grasp, (4, 4)))
            if not is_rotation(self.grasp[:3, :3]) or self.grasp[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
                raise InputError(f"{where}: expected a rotation and a translation in metres")


def unique_names(names: Iterable[str]) -> tuple[str, ...]:
    """Return `names` with repeats numbered from 2: handle, handle_2, handle_3."""
    taken: set[str] = set()
    result = []
    for name in names:
        candidate, count = name, 1
        while candidate in taken:
            count += 1
            candidate = f"{name}_{count}"
        taken.add(candidate)
        result.append(candidate)
    return tuple(result)


def joint_pairs(joints: Sequence[Joint]) -> Ints:
    """Return (j, 2) part indices of the joints, for the part graph's adjacency."""
    return np.array([(j.parent, j.child) for j in joints], np.int64).reshape(-1, 2)
