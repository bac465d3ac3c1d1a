"""A ranked set of grasps as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from graft.checks import Floats, Ints, checked_array, is_rotation
from graft.errors import InputError
from graft.grasp.gripper import Gripper


@dataclass(frozen=True, eq=False)
class Grasp:
    """Where a gripper closes.

    Attributes:
        pose: (4, 4) T_object_gripper, metres; the gripper frame is that of `graft.grasp.gripper`.
        width: Distance between the pads when they touch, metres.
        score: Higher is better.
        contacts: (2, 3) where the pads at +y and -y meet the surface, object frame, metres.
        distance: From the contact that was asked for to the nearest place between the pads, metres; 0 where none was.
        gripper: What closes.
    """

    pose: Floats
    width: float
    score: float
    contacts: Floats
    distance: float
    gripper: Gripper


@dataclass(frozen=True, eq=False)
class GraspSet:
    """Grasps in the order of their scores, best first unless made otherwise.

    Attributes:
        poses: (n, 4, 4) T_object_gripper, metres.
        widths: (n,) metres.
        scores: (n,) higher is better.
        contacts: (n, 2, 3) metres, object frame.
        distances: (n,) metres.
        gripper: What closes.
        terms: Name -> (n,) what the scores are made of.
        rejected: Reason -> how many candidates fell for it, so that an empty set says why.
    """

    poses: Floats
    widths: Floats
    scores: Floats
    contacts: Floats
    distances: Floats
    gripper: Gripper
    terms: Mapping[str, Floats] = field(default_factory=dict)
    rejected: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", checked_array("poses", self.poses, (None, 4, 4)))
        n = len(self.poses)
        object.__setattr__(self, "widths", checked_array("widths", self.widths, (n,)))
        object.__setattr__(self, "scores", checked_array("scores", self.scores, (n,)))
        object.__setattr__(self, "contacts", checked_array("contacts", self.contacts, (n, 2, 3)))
        object.__setattr__(self, "distances", checked_array("distances", self.distances, (n,)))
        terms = {name: checked_array(f"term {name}", term, (n,)) for name, term in self.terms.items()}
        object.__setattr__(self, "terms", terms)
        object.__setattr__(self, "rejected", dict(self.rejected))

    def __len__(self) -> int:
        return len(self.poses)

    def __iter__(self) -> Iterator[Grasp]:
        return (self[i] for i in range(len(self)))

    @overload
    def __getitem__(self, key: int) -> Grasp: ...
    @overload
    def __getitem__(self, key: slice | Ints) -> GraspSet: ...
    def __getitem__(self, key: int | slice | Ints) -> Grasp | GraspSet:
        if isinstance(key, int | np.integer):
            if not -len(self) <= key < len(self):
                raise IndexError(f"grasp {key} of {len(self)}")
            return Grasp(
                self.poses[key],
                float(self.widths[key]),
                float(self.scores[key]),
                self.contacts[key],
                float(self.distances[key]),
                self.gripper,
            )
        return replace(
            self,
            poses=self.poses[key],
            widths=self.widths[key],
            scores=self.scores[key],
            contacts=self.contacts[key],
            distances=self.distances[key],
            terms={name: term[key] for name, term in self.terms.items()},
        )

    def top(self, k: int) -> GraspSet:
        """Return the k grasps of highest score, best first; ties keep their order."""
        return self[np.argsort(-self.scores, kind="stable")[:k]]

    def transformed(self, transform: ArrayLike) -> GraspSet:
        """Return the grasps in another frame.

        Args:
            transform: (4, 4) T_new_object, a rotation and a translation in metres.

        Raises:
            InputError: It is no rigid motion.
        """
        matrix: Floats = checked_array("transform", transform, (4, 4))
        if not is_rotation(matrix[:3, :3]):
            raise InputError("transform: expected a rotation and a translation")
        contacts = self.contacts @ matrix[:3, :3].T + matrix[:3, 3]
        return replace(self, poses=matrix @ self.poses, contacts=contacts)
