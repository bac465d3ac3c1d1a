"""Grasps of other people behind the protocol of planners: AnyGrasp's licensed SDK, and grasps from files."""

from graft.grasp.adapters.anygrasp import AnyGraspPlanner
from graft.grasp.adapters.from_file import FilePlanner

__all__ = ["AnyGraspPlanner", "FilePlanner"]
