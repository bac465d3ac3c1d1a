"""Paths against another program's collision test, a pose every half millimetre."""

import numpy as np
import pytest
from motion_scenes import beside, mug
from scipy.spatial.transform import Rotation

from graft import zoo
from graft.grasp import PANDA_HAND, Support, in_metres
from graft.motion import Motion, plan_motions
from graft.motion.trajectory import stamp

fcl = pytest.importorskip("fcl")

SPACING = 0.0005
REACH = 0.15
"""No corner of the hand is further from its TCP, metres."""


class Peer:
    """The hand's boxes against an object's triangles and a plane."""

    def __init__(self, obj, support, opening):
        counts = np.cumsum([0] + [len(p.vertices) for p in obj.parts])
        faces = np.concatenate([p.faces + c for p, c in zip(obj.parts, counts[:-1], strict=True)])
        vertices = np.concatenate([p.vertices for p in obj.parts])
        model = fcl.BVHModel()
        model.beginModel(len(vertices), len(faces))
        model.addSubModel(vertices, faces)
        model.endModel()
        self.obstacle = fcl.CollisionObject(model, fcl.Transform())
        self.support = support
        self.boxes = PANDA_HAND.boxes(opening)
        self.shapes = [fcl.CollisionObject(fcl.Box(*(2 * box.half_extents))) for box in self.boxes]

    def touches(self, pose):
        for box, shape in zip(self.boxes, self.shapes, strict=True):
            turn, center = pose[:3, :3] @ box.rotation, pose[:3, :3] @ box.center + pose[:3, 3]
            shape.setTransform(fcl.Transform(turn, center))
            if (
                center @ self.support.normal - self.support.offset
                < np.abs(turn.T @ self.support.normal) @ box.half_extents
            ):
                return True
            if fcl.collide(shape, self.obstacle, fcl.CollisionRequest(), fcl.CollisionResult()):
                return True
        return False


def dense(motion):
    """Poses of a motion, none further from the next than `SPACING` metres of any point's travel."""
    turns = np.swapaxes(motion.poses[:-1, :3, :3], 1, 2) @ motion.poses[1:, :3, :3]
    ways = np.linalg.norm(np.diff(motion.poses[:, :3, 3], axis=0), axis=1)
    travel = (ways + REACH * Rotation.from_matrix(turns).magnitude()) / np.diff(motion.times)
    return motion.sampled(SPACING / travel.max()).poses


def across(obj, up, count, rng):
    """Poses on one side of an object and on the other, anyhow turned: (count, 4, 4) twice."""
    poses = np.tile(np.eye(4), (2, count, 1, 1))
    poses[:, :, :3, :3] = Rotation.random(2 * count, rng=rng).as_matrix().reshape(2, count, 3, 3)
    side = rng.normal(size=(count, 3))
    side = 0.2 * side / np.linalg.norm(side, axis=1, keepdims=True)
    middle = obj.bounds.mean(axis=0) + 0.1 * up
    poses[0, :, :3, 3], poses[1, :, :3, 3] = middle + side, middle - side
    return poses


@pytest.mark.parametrize("name", ["mug", "water_bucket", "kettle"])
def test_no_pose_on_a_path_touches(name):
    obj = in_metres(zoo.make(name, 1))
    up = np.array([0.0, 0.0, 1.0]) if obj.up is None else obj.up
    support = Support(up, min(float((p.vertices @ up).min()) for p in obj.parts))
    peer = Peer(obj, support, 0.06)
    rng = np.random.default_rng(7)
    starts, goals = across(obj, up, 20, rng)
    motions = plan_motions(obj, starts, goals, PANDA_HAND, support=support, opening=0.06)
    found = [motion for motion in motions if motion.found]
    assert sum(motion.iterations > 0 for motion in found) >= 2
    for motion in found:
        assert not any(peer.touches(pose) for pose in dense(motion))
    for motion, start, goal in zip(motions, starts, goals, strict=True):
        if peer.touches(start):
            assert motion.reason.startswith("start in collision")
        elif peer.touches(goal):
            assert motion.reason.startswith("goal in collision")
        elif not motion.found:
            assert "nearer than" in motion.reason


def test_the_peer_sees_a_cut_through_the_object():
    # The straight way, which the planner refuses: the check above can fail.
    obj, support = mug()
    ends = np.stack([beside(obj, -1, 0.06), beside(obj, 1, 0.06)])
    peer = Peer(obj, support, 0.08)
    assert any(peer.touches(pose) for pose in dense(Motion(ends, stamp(ends, 0.5, 1.0))))
