"""Motions of the gripper and the arm from where they are to where they grasp."""
