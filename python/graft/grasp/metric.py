"""Metres: from here on everything is metric, because grippers are.

`graft.objects` keeps an object in its own unit; grasps, motion and physics speak metres in the object's own frame.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats, checked_array, unit_vector
from graft.errors import InputError
from graft.objects import Contact, PartObject

LARGEST_OBJECT = 5.0
"""Diagonal, in metres, above which an object's unit is taken to be wrong: a wardrobe's is under 4."""

SMALLEST_OBJECT = 0.005
"""Diagonal, in metres, below which an object's unit is taken to be wrong: a pad of a gripper is larger."""


def metric_scale(obj: PartObject) -> float:
    """Return metres per object unit; an object that does not say is taken to be in metres.

    Raises:
        InputError: The diagonal of the axis-aligned box is then outside [SMALLEST_OBJECT, LARGEST_OBJECT] metres.
    """
    scale = 1.0 if obj.scale_to_metres is None else obj.scale_to_metres
    diagonal = scale * float(np.linalg.norm(obj.bounds[1] - obj.bounds[0]))
    if not SMALLEST_OBJECT <= diagonal <= LARGEST_OBJECT:
        said = "its unit is unknown and taken to be metres" if obj.scale_to_metres is None else f"at {scale:g} m a unit"
        raise InputError(
            f"object {obj.name!r}: expected a diagonal of {SMALLEST_OBJECT:g} to {LARGEST_OBJECT:g} m, got "
            f"{diagonal:.3g} m ({said}); give scale_to_metres (0.001 for millimetres)"
        )
    return scale


def in_metres(obj: PartObject) -> PartObject:
    """Return the object in metres, in its own frame, with `scale_to_metres` 1.

    Raises:
        InputError: See `metric_scale`.
    """
    scale = metric_scale(obj)
    moved = obj if scale == 1.0 else obj.transformed(np.diag([scale, scale, scale, 1.0]))
    return replace(moved, scale_to_metres=1.0)


def contact_in_metres(contact: Contact, obj: PartObject) -> Contact:
    """Return a contact of `obj`, given in object units, in metres.

    Raises:
        InputError: See `metric_scale`.
    """
    scale = metric_scale(obj)
    return contact.transformed(np.diag([scale, scale, scale, 1.0]))


@dataclass(frozen=True, eq=False)
class Support:
    """The plane that an object stands on: no gripper goes below it.

    Attributes:
        normal: (3,) unit vector away from the support, object frame.
        offset: Points p with normal . p = offset lie on it, metres.
    """

    normal: Floats
    offset: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", unit_vector("support normal", self.normal))
        if not np.isfinite(self.offset):
            raise InputError(f"support offset: expected a finite number, got {self.offset}")

    @classmethod
    def below(cls, obj: PartObject) -> Support | None:
        """Return the plane that an object in metres stands on along its up axis; None where it has none."""
        if obj.up is None:
            return None
        return cls(obj.up, min(float((part.vertices @ obj.up).min()) for part in obj.parts))

    def height(self, points: ArrayLike) -> Floats:
        """Return how far points (q, 3) lie above the plane (q,), metres."""
        heights: Floats = checked_array("points", points, (None, 3)) @ self.normal - self.offset
        return heights
