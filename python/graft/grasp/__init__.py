"""Grasps: gripper poses that hold the object at a contact."""

from graft.grasp.adapters import AnyGraspPlanner, FilePlanner
from graft.grasp.conventions import CONVENTIONS, Convention, from_convention, to_convention
from graft.grasp.files import load_grasps, save_grasps
from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.gripper import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper
from graft.grasp.gripper_files import find_gripper, load_gripper, save_gripper
from graft.grasp.metric import Support, contact_in_metres, in_metres, metric_scale

__all__ = [
    "CONVENTIONS",
    "PANDA_HAND",
    "ROBOTIQ_2F85",
    "AnyGraspPlanner",
    "Box",
    "Convention",
    "FilePlanner",
    "Grasp",
    "GraspSet",
    "Gripper",
    "Support",
    "contact_in_metres",
    "find_gripper",
    "from_convention",
    "in_metres",
    "load_grasps",
    "load_gripper",
    "metric_scale",
    "save_grasps",
    "save_gripper",
    "to_convention",
]
