"""Grippers against objects, compared with FCL."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from graft import zoo
from graft.errors import InputError
from graft.grasp import PANDA_HAND, Support
from graft.grasp.collision import gripper_collisions
from graft.grasp.surface import surface_of
from graft.objects import Floats, Part, PartObject

N_OBJECTS, N_POSES = 20, 500
TOUCHING = 1e-7
"""Answers may differ where moving every face by this many metres changes ours."""


def ball(radius: float = 0.03) -> PartObject:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    return PartObject("ball", (Part("ball", mesh.vertices, mesh.faces),), scale_to_metres=1.0)


def at(*translation: float) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = translation
    return pose[None]


def poses_near(obj: PartObject, count: int, rng: np.random.Generator) -> Floats:
    """Return turned poses whose TCP is within some centimetres of the surface."""
    vertices = np.concatenate([part.vertices for part in obj.parts])
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, rng=rng).as_matrix()
    back = rng.uniform(-0.02, 0.08, (count, 1)) * poses[:, :3, 2]
    poses[:, :3, 3] = vertices[rng.integers(len(vertices), size=count)] - back + rng.normal(0.0, 0.02, (count, 3))
    return poses


def fcl_answers(fcl: Any, obj: PartObject, poses: Floats, openings: Floats) -> Floats:
    surface = surface_of(obj)
    model = fcl.BVHModel()
    model.beginModel(len(surface.vertices), len(surface.faces))
    model.addSubModel(surface.vertices, surface.faces)
    model.endModel()
    mesh = fcl.CollisionObject(model)
    shapes = [fcl.CollisionObject(fcl.Box(*(2 * box.half_extents))) for box in PANDA_HAND.boxes(0.0)]

    def answer(pose: Floats, opening: float) -> bool:
        for shape, box in zip(shapes, PANDA_HAND.boxes(opening), strict=True):
            rotation = pose[:3, :3] @ box.rotation
            shape.setTransform(fcl.Transform(rotation, pose[:3, :3] @ box.center + pose[:3, 3]))
            if fcl.collide(shape, mesh, fcl.CollisionRequest(), fcl.CollisionResult()):
                return True
        return False

    return np.array([answer(pose, opening) for pose, opening in zip(poses, openings, strict=True)])


def test_agrees_with_fcl_on_ten_thousand_poses() -> None:
    fcl = pytest.importorskip("fcl")
    rng = np.random.default_rng(0)
    hits = 0
    for category in zoo.categories()[:N_OBJECTS]:
        obj = zoo.make(category, 0)
        poses, openings = poses_near(obj, N_POSES, rng), rng.uniform(0.0, PANDA_HAND.stroke, N_POSES)
        ours = gripper_collisions(obj, PANDA_HAND, poses, openings)
        theirs = fcl_answers(fcl, obj, poses, openings)
        differ = ours != theirs
        grown = gripper_collisions(obj, PANDA_HAND, poses[differ], openings[differ], margin=TOUCHING)
        assert (grown != ours[differ]).all(), f"{category}: {differ.sum()} answers differ where nothing touches"
        hits += int(ours.sum())
    assert 0.3 < hits / (N_OBJECTS * N_POSES) < 0.8, "the poses must both hit and miss"


def test_opening_decides_and_margin_adds() -> None:
    open_enough, exactly = 0.0601, 0.06
    assert not gripper_collisions(ball(), PANDA_HAND, at(0, 0, 0), open_enough)[0]
    assert gripper_collisions(ball(), PANDA_HAND, at(0, 0, 0), exactly - 1e-4)[0]
    assert gripper_collisions(ball(), PANDA_HAND, at(0, 0, 0), open_enough, margin=1e-4)[0]


def test_openings_differ_by_pose() -> None:
    poses = np.repeat(at(0, 0, 0), 3, axis=0)
    assert gripper_collisions(ball(), PANDA_HAND, poses, [0.08, 0.05, 0.07]).tolist() == [False, True, False]


def test_support_stops_the_hand() -> None:
    table = Support(np.array([0.0, 0.0, 1.0]), -0.03)
    far = at(1.0, 0.0, 0.0)  # the pads reach .009 below and the palm far above once it is turned upside down
    far[0, :3, :3] = np.diag([1.0, -1.0, -1.0])
    free = gripper_collisions(ball(), PANDA_HAND, far, 0.08, support=table)
    assert not free[0]
    far[0, 2, 3] = -0.0215
    assert gripper_collisions(ball(), PANDA_HAND, far, 0.08, support=table)[0]
    far[0, 2, 3] = -0.0205
    assert not gripper_collisions(ball(), PANDA_HAND, far, 0.08, support=table)[0]
    assert gripper_collisions(ball(), PANDA_HAND, far, 0.08, support=table, margin=0.001)[0]


def test_inside_counts_only_where_asked() -> None:
    room = ball(0.5)
    assert not gripper_collisions(room, PANDA_HAND, at(0, 0, 0), 0.08)[0]
    assert gripper_collisions(room, PANDA_HAND, at(0, 0, 0), 0.08, solid=True)[0]
    assert not gripper_collisions(room, PANDA_HAND, at(2, 0, 0), 0.08, solid=True)[0]


def test_clouds_are_skins_of_balls() -> None:
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.03)
    cloud = PartObject("cloud", (Part("cloud", mesh.vertices),), scale_to_metres=1.0)
    assert gripper_collisions(cloud, PANDA_HAND, at(0, 0, 0), [0.05])[0]
    assert not gripper_collisions(cloud, PANDA_HAND, at(0, 0, 0), [0.08])[0]


def test_units_are_converted() -> None:
    millimetres = ball().transformed(np.diag([1000.0, 1000.0, 1000.0, 1.0]))
    assert millimetres.scale_to_metres == pytest.approx(0.001)
    answers = gripper_collisions(millimetres, PANDA_HAND, np.repeat(at(0, 0, 0), 2, axis=0), [0.0601, 0.0599])
    assert answers.tolist() == [False, True]


@pytest.mark.parametrize(
    ("poses", "openings", "margin", "message"),
    [
        (np.zeros((1, 3, 3)), 0.0, 0.0, "poses: expected shape"),
        (np.full((1, 4, 4), np.nan), 0.0, 0.0, "poses: expected finite"),
        (np.eye(4)[None], -0.01, 0.0, "openings: expected numbers of at least 0"),
        (np.eye(4)[None], 0.01, -1.0, "margin"),
    ],
)
def test_bad_input_is_named(poses: Floats, openings: float, margin: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        gripper_collisions(ball(), PANDA_HAND, poses, openings, margin=margin)
