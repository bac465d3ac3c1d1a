"""Grasps: gripper poses that hold the object at a contact."""

from graft.grasp.collision import gripper_collisions
from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.gripper import PANDA_HAND, Box, Gripper
from graft.grasp.metric import Support, contact_in_metres, in_metres, metric_scale
from graft.grasp.planner import AntipodalPlanner, GraspPlanner, plan_grasps
from graft.grasp.scoring import ScoreWeights

__all__ = [
    "PANDA_HAND",
    "AntipodalPlanner",
    "Box",
    "Grasp",
    "GraspPlanner",
    "GraspSet",
    "Gripper",
    "ScoreWeights",
    "Support",
    "contact_in_metres",
    "gripper_collisions",
    "in_metres",
    "metric_scale",
    "plan_grasps",
]
