"""Grasps from a file, filtered for what was asked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from graft.grasp.adapters.selection import NEAR, selected
from graft.grasp.files import load_grasps
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import Gripper
from graft.grasp.metric import Support
from graft.objects import Contact, PartObject


@dataclass(frozen=True)
class FilePlanner:
    """A planner that looks grasps up: GraspNet `.npy`, GraspGen `.json` or our `.npz`.

    Attributes:
        path: The file; its poses are in the object's frame, metres.
        radius: Metres from the contact that still count.
        check_collisions: Whether grasps in which our boxes of the gripper hit the object are left out.
    """

    path: str | Path
    radius: float = NEAR
    check_collisions: bool = True

    def plan(
        self,
        obj: PartObject,
        contact: Contact | None,
        gripper: Gripper,
        *,
        part: int | str | None = None,
        support: Support | None = None,
        k: int = 20,
        seed: int = 0,
    ) -> GraspSet:
        """Return the k best grasps of the file near the contact, on the part, clear of support and object.

        Args:
            obj: In metres.
            contact: In metres, or None for anywhere.
            gripper: What closes.
            part: Index, name or label; None for any.
            support: What no gripper goes below.
            k: How many at most.
            seed: Not used: nothing is drawn by lot.

        Raises:
            InputError: The file cannot be used, or is for another gripper.
        """
        grasps = load_grasps(self.path, gripper)
        made = {"planner": "file", "file": str(self.path), **grasps.metadata}
        found = selected(
            grasps,
            obj,
            contact,
            part=part,
            support=support,
            k=k,
            radius=self.radius,
            check_collisions=self.check_collisions,
        )
        return replace(found, metadata=made)
