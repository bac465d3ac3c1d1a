"""Physics: what happens when the gripper closes. The only importer of mujoco beside the reader of MJCF files."""

from graft.sim.config import SimulationConfig
from graft.sim.decompose import DecompositionConfig
from graft.sim.outcome import Measurements, Outcome, Trial
from graft.sim.pieces import collision_pieces
from graft.sim.poses import RestingPose
from graft.sim.prepare import PreparedObject, prepare, random_poses, resting_poses
from graft.sim.runner import Job, simulate_grasps
from graft.sim.simulator import MujocoSimulator, Simulator
from graft.sim.trial import simulate_grasp

__all__ = [
    "DecompositionConfig",
    "Job",
    "Measurements",
    "MujocoSimulator",
    "Outcome",
    "PreparedObject",
    "RestingPose",
    "SimulationConfig",
    "Simulator",
    "Trial",
    "collision_pieces",
    "prepare",
    "random_poses",
    "resting_poses",
    "simulate_grasp",
    "simulate_grasps",
]
