"""Grasps: gripper poses that hold the object at a contact."""

from graft.grasp.adapters import AnyGraspPlanner, FilePlanner
from graft.grasp.collision import gripper_collisions
from graft.grasp.conventions import CONVENTIONS, Convention, from_convention, to_convention
from graft.grasp.files import load_grasps, save_grasps
from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.gripper import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper
from graft.grasp.gripper_files import find_gripper, load_gripper, save_gripper
from graft.grasp.metric import Support, contact_in_metres, in_metres, metric_scale
from graft.grasp.planner import AntipodalPlanner, GraspPlanner, plan_grasps
from graft.grasp.scoring import ScoreWeights

__all__ = [
    "CONVENTIONS",
    "PANDA_HAND",
    "ROBOTIQ_2F85",
    "AntipodalPlanner",
    "AnyGraspPlanner",
    "Box",
    "Convention",
    "FilePlanner",
    "Grasp",
    "GraspPlanner",
    "GraspSet",
    "Gripper",
    "ScoreWeights",
    "Support",
    "contact_in_metres",
    "find_gripper",
    "from_convention",
    "gripper_collisions",
    "in_metres",
    "load_grasps",
    "load_gripper",
    "metric_scale",
    "plan_grasps",
    "save_grasps",
    "save_gripper",
    "to_convention",
]
