"""AnyGrasp (Fang et al., T-RO 2023) through its licensed SDK, https://github.com/graspnet/anygrasp_sdk.

The SDK looks at one depth image: points (n, 3) float32 in a camera's frame (x right, y down, z forward), metres, and
colours in [0, 1]. So the object is seen from several cameras around it, and what AnyGrasp finds in each view is
brought back to the object's frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from graft import _core
from graft.checks import Floats
from graft.errors import GraftError, InputError
from graft.grasp.adapters.selection import NEAR, selected
from graft.grasp.conventions import rigid_inverse
from graft.grasp.files.graspnet import from_graspnet_rows
from graft.grasp.grasps import GraspSet
from graft.grasp.gripper import Gripper
from graft.grasp.metric import Support
from graft.io.guards import existing_file
from graft.objects import Contact, PartObject

WIDEST = 0.1
"""Metres: AnyGrasp's networks know no wider gripper (the SDK's demo clips there)."""

VIEWS = ((30.0, 35.0), (120.0, 35.0), (210.0, 35.0), (300.0, 35.0))
"""(azimuth, elevation) in degrees of the cameras: four sides, as steeply as a camera on a wrist looks down."""

CAMERA_DISTANCE = 0.5
"""Metres from the camera to the middle of the object, within the .3 to 1 m of the SDK's training images."""

POINTS = 40_000
"""Points on the whole surface; half of them are seen from a side."""

GREY = 0.5
"""Of every point: colour is an input, and meshes here have none."""

LIFT = 1e-4
"""Metres by which a point is lifted off the surface before it is asked whether it is seen."""


class MissingAnyGraspError(GraftError, ImportError):
    """The AnyGrasp SDK, which its authors license and no index carries, is not installed."""


@dataclass(frozen=True)
class AnyGraspPlanner:
    """A planner that asks AnyGrasp.

    Attributes:
        checkpoint_path: Weights of the detection network, from the SDK's authors.
        gripper_height: Metres; the SDK's collision check takes the gripper to be so thick.
        top_down_grasp: Whether only grasps from above are wanted.
        apply_object_mask: The SDK's filter of background points.
        dense_grasp: Very many predictions, for crowded scenes; slower and worse.
        collision_detection: The SDK's own check against the points.
        radius: Metres from the contact that still count.
        check_collisions: Whether grasps in which our boxes of the gripper hit the object are left out.
    """

    checkpoint_path: str | Path
    gripper_height: float = 0.03
    top_down_grasp: bool = False
    apply_object_mask: bool = True
    dense_grasp: bool = False
    collision_detection: bool = True
    radius: float = NEAR
    check_collisions: bool = True
    _nets: dict[float, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

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
        """Return the k best grasps that AnyGrasp finds near the contact, on the part, clear of support and object.

        Args:
            obj: In metres.
            contact: In metres, or None for anywhere.
            gripper: What closes; AnyGrasp is told its stroke.
            part: Index, name or label; None for any.
            support: What no gripper goes below.
            k: How many at most.
            seed: Of the points on the surface.

        Raises:
            MissingAnyGraspError: The SDK is not installed.
            InputError: There are no weights, or the SDK gives something else than it documents.
        """
        detector = self._detector(gripper)
        found = [GraspSet.empty(gripper)]
        for T_camera_object, points in _views(obj, seed):
            rows = self._detect(detector, points)
            seen = from_graspnet_rows(rows, gripper, path=Path("AnyGrasp"))
            found.append(seen.transformed(rigid_inverse(T_camera_object)))
        grasps = replace(GraspSet.concatenate(found), metadata={"planner": "anygrasp", "seed": seed})
        return selected(
            grasps,
            obj,
            contact,
            part=part,
            support=support,
            k=k,
            radius=self.radius,
            check_collisions=self.check_collisions,
        )

    def _detector(self, gripper: Gripper) -> Any:
        """Return the loaded network for grippers as wide as this."""
        width = min(WIDEST, gripper.stroke)
        if width not in self._nets:
            try:
                from gsnet import AnyGrasp
            except ImportError as error:
                raise MissingAnyGraspError(
                    "AnyGraspPlanner needs the AnyGrasp SDK: get a license, put gsnet.so and lib_cxx.so on the Python "
                    f"path and install its requirements (https://github.com/graspnet/anygrasp_sdk); {error}"
                ) from None
            config = SimpleNamespace(
                checkpoint_path=str(existing_file(self.checkpoint_path, what="checkpoint")),
                max_gripper_width=width,
                gripper_height=self.gripper_height,
                top_down_grasp=self.top_down_grasp,
                debug=False,
            )
            detector = AnyGrasp(config)
            detector.load_net()
            self._nets[width] = detector
        return self._nets[width]

    def _detect(self, detector: Any, points: Floats) -> Floats:
        """Return GraspNet rows (n, 17), camera frame, of what AnyGrasp finds in one view."""
        lows, highs = points.min(axis=0), points.max(axis=0)
        result = detector.get_grasp(
            points.astype(np.float32),
            np.full(points.shape, GREY, np.float32),
            lims=[float(bound) for pair in zip(lows, highs, strict=True) for bound in pair],
            apply_object_mask=self.apply_object_mask,
            dense_grasp=self.dense_grasp,
            collision_detection=self.collision_detection,
        )
        group = result[0] if isinstance(result, tuple) else result
        if group is None or len(group) == 0:  # older versions give None where they find nothing
            return np.empty((0, 17))
        rows = np.asarray(getattr(group, "grasp_group_array", None), np.float64)
        if rows.ndim != 2:
            raise InputError(f"AnyGrasp: expected a GraspGroup, got {type(group).__name__}")
        return rows


def _views(obj: PartObject, seed: int) -> Iterator[tuple[Floats, Floats]]:
    """Yield T_camera_object (4, 4) and the points (n, 3) that this camera sees, in its frame, for each of `VIEWS`."""
    points, normals, vertices, faces = _surface(obj, seed)
    low, high = obj.bounds
    for azimuth, elevation in np.radians(VIEWS):
        camera = _camera(azimuth, elevation, obj.up, (low + high) / 2.0)
        seen = np.ones(len(points), bool)
        if len(faces):
            eye = rigid_inverse(camera)[:3, 3]
            toward = eye - points
            toward /= np.linalg.norm(toward, axis=1, keepdims=True)
            seen = np.einsum("ij,ij->i", toward, normals) > 0.0
            lifted = np.ascontiguousarray(points[seen] + LIFT * normals[seen])
            free = np.isinf(_core.cast_rays(vertices, faces, lifted, np.ascontiguousarray(toward[seen])))
            seen[np.flatnonzero(seen)[~free]] = False
        if seen.any():
            yield camera, points[seen] @ camera[:3, :3].T + camera[:3, 3]


def _surface(obj: PartObject, seed: int) -> tuple[Floats, Floats, Floats, Any]:
    """Return points (n, 3) spread by area with normals (n, 3), and the mesh; a cloud's own points without faces."""
    vertices = np.concatenate([part.vertices for part in obj.parts])
    offsets = np.cumsum([0, *(len(part.vertices) for part in obj.parts)])
    faces = np.concatenate([part.faces + o for part, o in zip(obj.parts, offsets[:-1], strict=True)])
    if not len(faces):
        return vertices, np.zeros_like(vertices), vertices, faces
    corners = vertices[faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(crossed, axis=1)
    random = np.random.default_rng(seed)
    chosen = random.choice(len(faces), POINTS, p=doubled / doubled.sum())
    u, v = random.random((2, POINTS, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    first, second, third = corners[chosen].transpose(1, 0, 2)
    points: Floats = first + u * (second - first) + v * (third - first)
    return points, crossed[chosen] / doubled[chosen, None], vertices, np.ascontiguousarray(faces)


def _camera(azimuth: float, elevation: float, up: Floats | None, middle: Floats) -> Floats:
    """Return T_camera_object (4, 4) of a camera that looks at `middle` (3,) from `CAMERA_DISTANCE`."""
    above = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up)
    ahead = np.eye(3)[int(np.argmin(np.abs(above)))]
    ahead = ahead - above * (above @ ahead)
    ahead /= np.linalg.norm(ahead)
    level = np.cos(azimuth) * ahead + np.sin(azimuth) * np.cross(above, ahead)
    toward = np.cos(elevation) * level + np.sin(elevation) * above
    right = np.cross(above, level)
    camera = np.eye(4)
    camera[:3, :3] = np.stack([right, np.cross(right, toward), -toward])
    camera[:3, 3] = [0.0, 0.0, CAMERA_DISTANCE] - camera[:3, :3] @ middle
    return camera
