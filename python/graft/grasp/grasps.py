"""A ranked set of grasps as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graft.checks import ROTATION_TOLERANCE, Floats, Ints, checked_array, is_rotation
from graft.errors import InputError
from graft.grasp.gripper import Gripper

HALF_TURN = np.diag([-1.0, -1.0, 1.0])
"""Turns a gripper about its approach so that the fingers change places: the same grasp."""

NMS_TRANSLATION, NMS_ROTATION = 0.01, np.radians(15.0)
"""Metres and radians below which two grasps are one: a pad's half width, a step of the approaches tried around."""


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
        metadata: What made them (planner, seed, versions), strings and numbers that files keep.
    """

    poses: Floats
    widths: Floats
    scores: Floats
    contacts: Floats
    distances: Floats
    gripper: Gripper
    terms: Mapping[str, Floats] = field(default_factory=dict)
    rejected: Mapping[str, int] = field(default_factory=dict)
    metadata: Mapping[str, str | int | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", checked_array("poses", self.poses, (None, 4, 4)))
        n = len(self.poses)
        wrong = not_rigid(self.poses)
        if len(wrong):
            raise InputError(
                f"pose {wrong[0]}: expected a rotation and a translation, got {self.poses[wrong[0]].tolist()}"
            )
        object.__setattr__(self, "widths", checked_array("widths", self.widths, (n,)))
        object.__setattr__(self, "scores", checked_array("scores", self.scores, (n,)))
        object.__setattr__(self, "contacts", checked_array("contacts", self.contacts, (n, 2, 3)))
        object.__setattr__(self, "distances", checked_array("distances", self.distances, (n,)))
        terms = {name: checked_array(f"term {name}", term, (n,)) for name, term in self.terms.items()}
        object.__setattr__(self, "terms", terms)
        object.__setattr__(self, "rejected", dict(self.rejected))
        object.__setattr__(self, "metadata", dict(self.metadata))

    @classmethod
    def empty(cls, gripper: Gripper, rejected: Mapping[str, int] | None = None) -> GraspSet:
        """Return a set of no grasps, with the reasons why."""
        none = np.empty(0)
        return cls(np.empty((0, 4, 4)), none, none, np.empty((0, 2, 3)), none, gripper, rejected=rejected or {})

    @classmethod
    def concatenate(cls, sets: Sequence[GraspSet]) -> GraspSet:
        """Return the grasps of several sets, one after the other.

        Terms and metadata that not all of them have, or not alike, are left out; rejections are added up.

        Raises:
            InputError: There is no set, or they are for different grippers.
        """
        if not sets:
            raise InputError("sets: expected at least one, got none")
        first = sets[0]
        for other in sets[1:]:
            if not first.gripper.is_like(other.gripper):
                raise InputError(f"sets: expected one gripper, got {first.gripper.name!r} and {other.gripper.name!r}")
        shared = [name for name in first.terms if all(name in s.terms for s in sets)]
        counts: Counter[str] = Counter()
        for each in sets:
            counts.update(each.rejected)
        return cls(
            np.concatenate([s.poses for s in sets]),
            np.concatenate([s.widths for s in sets]),
            np.concatenate([s.scores for s in sets]),
            np.concatenate([s.contacts for s in sets]),
            np.concatenate([s.distances for s in sets]),
            first.gripper,
            {name: np.concatenate([s.terms[name] for s in sets]) for name in shared},
            counts,
            {k: v for k, v in first.metadata.items() if all(s.metadata.get(k) == v for s in sets)},
        )

    @property
    def chief_rejection(self) -> str | None:
        """The reason that most candidates fell for, of equal ones the first; None where none fell."""
        return max(self.rejected, key=lambda reason: self.rejected[reason], default=None)

    def __len__(self) -> int:
        return len(self.poses)

    def __iter__(self) -> Iterator[Grasp]:
        return (self[i] for i in range(len(self)))

    @overload
    def __getitem__(self, key: int) -> Grasp: ...
    @overload
    def __getitem__(self, key: slice | Ints | NDArray[np.bool_]) -> GraspSet: ...
    def __getitem__(self, key: int | slice | Ints | NDArray[np.bool_]) -> Grasp | GraspSet:
        """Return one grasp, or the set of those that a slice, indices or a mask (n,) choose."""
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

    def sorted(self) -> GraspSet:
        """Return the grasps best first; ties keep their order."""
        return self.top(len(self))

    def nms(self, translation: float = NMS_TRANSLATION, rotation: float = NMS_ROTATION) -> GraspSet:
        """Return the grasps, best first, without those that are like a better one (non-maximum suppression).

        Two grasps are alike when their TCPs are at most `translation` apart and their axes at most `rotation`; a
        gripper turned by 180 degrees about its approach grasps alike.

        Args:
            translation: Metres.
            rotation: Radians.

        Raises:
            InputError: A bound is negative or no number.
        """
        for name, bound in (("translation", translation), ("rotation", rotation)):
            if not bound >= 0:
                raise InputError(f"nms {name}: expected a number from 0 on, got {bound}")
        from scipy.spatial import cKDTree

        order = self.sorted()
        if not len(order):
            return order
        places, axes = order.poses[:, :3, 3], order.poses[:, :3, :3]
        tree = cKDTree(places)
        left = np.ones(len(order), bool)
        kept = []
        for i in range(len(order)):
            if left[i]:
                kept.append(i)
                near = np.array(tree.query_ball_point(places[i], translation), np.int64)
                left[near[angles_between(axes[near], axes[i]) <= rotation]] = False
        return order[np.array(kept, np.int64)]

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


def angles_between(rotations: Floats, rotation: Floats) -> Floats:
    """Return (n,) radians between grippers' axes (n, 3, 3) and (3, 3), the fingers interchangeable.

    From the chord 2 sqrt(2) sin(angle / 2), the norm of the matrices' difference: exact where angles are small.
    """
    chords = np.minimum(
        np.linalg.norm(rotations - rotation, axis=(1, 2)),
        np.linalg.norm(rotations - rotation @ HALF_TURN, axis=(1, 2)),
    )
    angles: Floats = 2.0 * np.arcsin(np.minimum(chords / np.sqrt(8.0), 1.0))
    return angles


def not_rigid(poses: Floats) -> Ints:
    """Return the rows of (n, 4, 4) that are no rotation and translation."""
    linear = poses[:, :3, :3]
    error = np.abs(linear.transpose(0, 2, 1) @ linear - np.eye(3)).max(axis=(1, 2), initial=0.0)
    last = (poses[:, 3] != (0.0, 0.0, 0.0, 1.0)).any(axis=1)
    return np.nonzero((error > ROTATION_TOLERANCE) | (np.linalg.det(linear) <= 0) | last)[0]
