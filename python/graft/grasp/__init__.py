"""Grasps: gripper poses that hold the object at a contact."""

from graft.grasp.grasps import Grasp, GraspSet
from graft.grasp.gripper import PANDA_HAND, ROBOTIQ_2F85, Box, Gripper
from graft.grasp.metric import Support, contact_in_metres, in_metres, metric_scale

__all__ = [
    "PANDA_HAND",
    "ROBOTIQ_2F85",
    "Box",
    "Grasp",
    "GraspSet",
    "Gripper",
    "Support",
    "contact_in_metres",
    "in_metres",
    "metric_scale",
]
