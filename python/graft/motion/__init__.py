"""Motions of the gripper and the arm from where they are to where they grasp."""

from graft.motion.approach import Approach, plan_approach
from graft.motion.config import MotionConfig
from graft.motion.hand import plan_motion, plan_motions
from graft.motion.trajectory import Motion

__all__ = ["Approach", "Motion", "MotionConfig", "plan_approach", "plan_motion", "plan_motions"]
