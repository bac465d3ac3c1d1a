"""From a contact to ranked grasps: the protocol, and the antipodal planner that implements it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from graft import _core
from graft.contact import TransferredContact
from graft.errors import InputError
from graft.grasp.collision import box_arrays
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import OPENING_CLEARANCE, PANDA_HAND, Gripper
from graft.grasp.metric import Support, in_metres
from graft.grasp.scoring import ScoreWeights
from graft.grasp.surface import Surface, surface_of, with_surfels
from graft.io import as_object
from graft.objects import Contact, PartObject

OFF_SURFACE = 0.01
"""Distance, in metres, from which a contact no longer lies on the surface: half a Panda's pad. Transferred contacts lie
on it; marked ones may be off by the coarseness of another mesh of the same object."""


class GraspPlanner(Protocol):
    """What finds grasps. Everything it is given is metric, in the object's frame."""

    def plan(
        self,
        obj: PartObject,
        contact: Contact | None,
        gripper: Gripper,
        *,
        part: int | None,
        support: Support | None,
        k: int,
        seed: int,
    ) -> GraspSet:
        """Return at most k grasps, best first.

        Args:
            obj: The object, metres.
            contact: Where it should be taken, metres; None for anywhere.
            gripper: What closes.
            part: The part to take it by; None for any, or the contact's.
            support: What it stands on; None when it floats.
            k: Grasps wanted.
            seed: The same seed gives the same grasps.
        """
        ...


@dataclass(frozen=True)
class AntipodalPlanner:
    """Samples the surface near the contact for antipodal pairs, and tries approaches to each.

    Nguyen 1988, "Constructing force-closure grasps"; ten Pas and others 2017, "Grasp pose detection in point clouds".

    A grasp is kept when the hand, at the pads' opening `width + 2 clearance` (at most the stroke), comes in straight
    over the last `travel` metres and closes without touching anything but its pads' places, `margin` away from the
    object and the support.

    Attributes:
        radius: Around the contact, metres: pads press within it. A hand's breadth: at 15 N the place on a handle
            decides whether it holds; of the YCB scans 19 of 22 trials held, 15 within 3 cm.
        wider: Times the radius within which is looked next where nothing was found: a part lies flat on the table, or a
            loop is too narrow, just where it was asked for, and can be held a hand's breadth further.
        samples: Places on the surface, with a contact.
        spread_samples: Places on the surface, without one.
        rays: From each place, within the friction cone.
        pairs: Antipodal pairs of which approaches are tried.
        approaches: Approach directions around each closing axis.
        depths: Offsets of the pads along the approach, metres: a third of a Panda's pad either way.
        friction: Coefficient; the cone's half angle is its arc tangent. The simulator's default.
        clearance: Room on either side between an open pad and the surface, metres.
        margin: By which everything else keeps away, metres.
        travel: Length of the straight way in, metres.
        spacing: Grasps nearer than this are the same if ...
        turn: ... they are turned by less than this, radians.
        weights: Of the score's terms.
    """

    radius: float = 0.08
    wider: tuple[float, ...] = (2.0,)
    samples: int = 192
    spread_samples: int = 1024
    rays: int = 4
    pairs: int = 48
    approaches: int = 12
    depths: tuple[float, ...] = (-0.006, 0.0, 0.006)
    friction: float = 0.5
    clearance: float = OPENING_CLEARANCE
    margin: float = 0.001
    travel: float = 0.08
    spacing: float = 0.01
    turn: float = 0.35
    weights: ScoreWeights = field(default_factory=ScoreWeights)

    def __post_init__(self) -> None:
        for name in ("radius", "friction", "spacing", "turn"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"planner {name}: expected a positive number, got {value}")
        for name in ("clearance", "margin", "travel"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"planner {name}: expected a number of at least 0, got {value}")
        for name in ("samples", "spread_samples", "rays", "pairs", "approaches"):
            if getattr(self, name) < 1:
                raise InputError(f"planner {name}: expected at least 1, got {getattr(self, name)}")
        if not all(np.isfinite(factor) and factor > 0 for factor in self.wider):
            raise InputError(f"planner wider: expected positive numbers, got {self.wider}")
        if not self.depths or not np.isfinite(self.depths).all():
            raise InputError(f"planner depths: expected finite numbers, got {self.depths}")

    def opening(self, width: float, gripper: Gripper) -> float:
        """Return how far the pads are apart, metres, while the hand comes in to close to `width`."""
        return gripper.opening_for(width, self.clearance)

    def plan(
        self,
        obj: PartObject,
        contact: Contact | None,
        gripper: Gripper,
        *,
        part: int | None = None,
        support: Support | None = None,
        k: int = 20,
        seed: int = 0,
    ) -> GraspSet:
        """Return at most k grasps, best first; see `GraspPlanner.plan`.

        Points of clouds become small squares across their normals.

        Raises:
            InputError: The object's surface has no area, or the contact lies off it.
        """
        surface = with_surfels(surface_of(obj))
        if part is None and contact is not None:
            part = contact.part
        found = self._search(surface, obj, contact, gripper, self.radius, part, support, k, seed)
        for factor in self.wider if contact is not None else ():
            if len(found):
                break
            found = self._search(surface, obj, contact, gripper, factor * self.radius, part, support, k, seed)
        return found

    def _search(
        self,
        surface: Surface,
        obj: PartObject,
        contact: Contact | None,
        gripper: Gripper,
        radius: float,
        part: int | None,
        support: Support | None,
        k: int,
        seed: int,
    ) -> GraspSet:
        """Look once, within `radius` of the contact."""
        try:
            poses, widths, scores, contacts, distances, (names, terms), rejected = _core.antipodal_grasps(
                vertices=surface.vertices,
                faces=surface.faces,
                face_parts=surface.face_parts,
                stroke=gripper.stroke,
                contact=None if contact is None else tuple(contact.point.tolist()),
                approach=None if contact is None or contact.approach is None else tuple(contact.approach.tolist()),
                tolerance=OFF_SURFACE,
                radius=radius,
                part=part,
                plane=None if support is None else (*support.normal.tolist(), support.offset),
                up=None if obj.up is None else tuple(obj.up.tolist()),
                weights=self.weights.values(),
                depths=np.array(self.depths, float),
                samples=self.spread_samples if contact is None else self.samples,
                rays=self.rays,
                pairs=self.pairs,
                approaches=self.approaches,
                cone=float(np.arctan(self.friction)),
                clearance=self.clearance,
                margin=self.margin,
                travel=self.travel,
                spacing=self.spacing,
                turn=self.turn,
                count=k,
                seed=seed,
                **box_arrays(gripper),
            )
        except ValueError as error:
            raise InputError(f"object {obj.name!r}: {error}") from None
        return GraspSet(
            poses=poses,
            widths=widths,
            scores=scores,
            contacts=contacts,
            distances=distances,
            gripper=gripper,
            terms=dict(zip(names, terms.T, strict=True)),
            rejected={reason: count for reason, count in rejected if count},
        )


def plan_grasps(
    obj: Any,
    contact: Contact | TransferredContact | None = None,
    gripper: Gripper = PANDA_HAND,
    *,
    part: int | str | None = None,
    support: Support | None = None,
    planner: GraspPlanner | None = None,
    k: int = 20,
    seed: int = 0,
) -> GraspSet:
    """Find grasps that hold an object at a contact, on a part, or anywhere.

    Args:
        obj: A `PartObject`, a path, a trimesh object, or arrays: see `graft.io.as_object`.
        contact: Where to take it, object frame and units: a `Contact`, or what `transfer_contact` returns.
        gripper: What closes.
        part: Index, name or label of the part to take it by; by default the contact's.
        support: The plane it stands on, object frame, metres.
        planner: How; by default `AntipodalPlanner()`.
        k: At most so many grasps.
        seed: The same seed gives the same grasps, with any number of threads.

    Returns:
        Grasps in metres, object frame, best first. An empty set's `rejected` says why it is empty.

    Raises:
        InputError: The object cannot be read, has no area or no plausible size in metres; the contact lies off its
            surface or on no part of it; k is below 1.
    """
    if k < 1:
        raise InputError(f"k: expected at least 1, got {k}")
    given = as_object(obj)
    chosen = None if part is None else given.part_index(part)
    asked = contact.contact if isinstance(contact, TransferredContact) else contact
    metric = in_metres(given)
    if asked is not None:
        given.part_index(asked.part)
        scale = given.scale_to_metres or 1.0
        asked = asked if scale == 1.0 else asked.transformed(np.diag([scale, scale, scale, 1.0]))
    how = AntipodalPlanner() if planner is None else planner
    return how.plan(metric, asked, gripper, part=chosen, support=support, k=k, seed=seed)
