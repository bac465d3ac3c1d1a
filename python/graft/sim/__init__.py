"""Physics: what happens when the gripper closes. The only importer of mujoco beside the reader of MJCF files."""
