"""RRT-Connect for a free hand against OMPL's with FCL, on the same problems in one run; then a Panda arm.

    python benches/motion.py [--problems N]

Objects of the zoo (and YCB scans, with the extra demo) stand on a table; the open hand starts above or beside them,
anyhow turned. Goals: poses 8 cm before places on graspable parts (pre-grasps), and the grasps themselves, fingers
around the part (narrow). Both planners get the problems whose ends keep 1 mm from everything by FCL, the same bounds
and the same weight of rotations. Every path of either planner is checked again by FCL, a pose every half millimetre of
travel. Times are the process's processor time: other work on the machine does not count.

The arm: inverse kinematics of poses that random configurations have, and plans to them around a mug on a table.
"""

import argparse
import itertools
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import fcl
import mujoco
import numpy as np
from ompl import base, geometric, util
from scipy.spatial.transform import Rotation

from graft import zoo
from graft.checks import Floats
from graft.errors import GraftError
from graft.grasp import PANDA_HAND, Support, in_metres
from graft.motion import MotionConfig, plan_motions
from graft.motion.approach import translation
from graft.motion.joints import clear_joints, plan_joints, world_around
from graft.objects import PartObject
from graft.sim.arm import Arm, IkConfig, panda_arm, plan_arm, solve_ik

CATEGORIES = ("mug", "pan", "kettle", "teapot", "water_bucket", "watering_can", "basket", "hammer")
SCANS = ("025_mug", "019_pitcher_base", "048_hammer", "035_power_drill", "033_spatula", "006_mustard_bottle")
CLEARANCE = 0.001
OMPL_SECONDS = 5.0
GRAFT_CONFIG = MotionConfig()
DIRECT = MotionConfig(max_iterations=0)
ROUGH = MotionConfig(shortcuts=0)
BATCH = 16
ARM_GOALS = 200
SPACING = 0.0005


@dataclass
class Problem:
    """A hand among an object and a table."""

    obj: PartObject
    support: Support
    start: Floats
    goal: Floats
    narrow: bool


class Checker:
    """The boxes of the hand against the object's triangles and the table, by FCL."""

    def __init__(self, obj: PartObject, support: Support, slack: float = 0.0) -> None:
        counts = np.cumsum([0] + [len(p.vertices) for p in obj.parts])
        faces = np.concatenate([p.faces + c for p, c in zip(obj.parts, counts[:-1], strict=True)])
        model = fcl.BVHModel()
        vertices = np.concatenate([p.vertices for p in obj.parts])
        model.beginModel(len(vertices), len(faces))
        model.addSubModel(vertices, faces)
        model.endModel()
        self.obstacles = [fcl.CollisionObject(model, fcl.Transform())]
        self.normal, self.offset = support.normal, support.offset
        self.boxes = PANDA_HAND.boxes(PANDA_HAND.stroke)
        self.hand = [fcl.CollisionObject(fcl.Box(*(2 * (b.half_extents + slack)))) for b in self.boxes]
        self.halves = [b.half_extents + slack for b in self.boxes]
        self.request = fcl.CollisionRequest()
        self.calls, self.seconds = 0, 0.0

    def free(self, rotation: Floats, position: Floats) -> bool:
        """Whether the hand touches nothing."""
        self.calls += 1
        begun = time.process_time()
        answer = self._free(rotation, position)
        self.seconds += time.process_time() - begun
        return answer

    def _free(self, rotation: Floats, position: Floats) -> bool:
        for box, half, moved in zip(self.boxes, self.halves, self.hand, strict=True):
            turn, center = rotation @ box.rotation, rotation @ box.center + position
            if center @ self.normal - self.offset < np.abs(turn.T @ self.normal) @ half:
                return False
            moved.setTransform(fcl.Transform(turn, center))
            if fcl.collide(moved, self.obstacles[0], self.request, fcl.CollisionResult()):
                return False
        return True


def standing(obj: PartObject) -> tuple[PartObject, Support]:
    """Return the object in metres and the plane below it."""
    metric = in_metres(obj)
    up = np.array([0.0, 0.0, 1.0]) if metric.up is None else metric.up
    low = min(float((p.vertices @ up).min()) for p in metric.parts)
    return metric, Support(up, low)


def objects() -> list[PartObject]:
    """Return the zoo's and the scans that are installed."""
    made = [zoo.make(name, seed) for name in CATEGORIES for seed in (0, 1)]
    try:
        return made + [zoo.ycb_object(name) for name in SCANS]
    except GraftError as error:
        print(f"no scans: {error}")
        return made


def grasp_candidates(obj: PartObject, rng: np.random.Generator, count: int) -> list[Floats]:
    """Return poses whose closing axis pierces a graspable part, midway through it."""
    poses = []
    parts = [obj.parts[i] for i in (obj.graspable or range(len(obj.parts)))]
    triangles = np.concatenate([p.vertices[p.faces] for p in parts])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    for face in rng.choice(len(areas), count, p=areas / areas.sum()):
        y = normals[face] / areas[face]
        side = rng.normal(size=3)
        z = side - side @ y * y
        z /= np.linalg.norm(z)
        pose = np.eye(4)
        pose[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
        pose[:3, 3] = triangles[face].mean(axis=0) - y * rng.uniform(0.003, 0.02)
        poses.append(pose)
    return poses


def problems(count: int) -> list[Problem]:
    """Return `count` problems an object of each kind, ends clear by FCL."""
    rng = np.random.default_rng(0)
    found = []
    for obj in objects():
        metric, support = standing(obj)
        wide = Checker(metric, support, CLEARANCE)
        low, high = metric.bounds
        for narrow in (False, True):
            kept = 0
            for grasp in grasp_candidates(metric, rng, 400):
                if not wide.free(grasp[:3, :3], grasp[:3, 3]):
                    continue
                goal = grasp if narrow else grasp @ translation(np.array([0.0, 0.0, -0.08]))
                start = np.eye(4)
                start[:3, :3] = Rotation.random(rng=rng).as_matrix()
                start[:3, 3] = rng.uniform(low - 0.2, high + 0.2) + support.normal * rng.uniform(0.0, 0.2)
                if wide.free(start[:3, :3], start[:3, 3]) and wide.free(goal[:3, :3], goal[:3, 3]):
                    found.append(Problem(metric, support, start, goal, narrow))
                    kept += 1
                if kept == count:
                    break
    return found


def dense(poses: Floats, spacing: float, radius: float) -> list[Floats]:
    """Return poses along a path, no further apart than `spacing` metres of travel."""
    result = [poses[0]]
    for a, b in itertools.pairwise(poses):
        turn = Rotation.from_matrix(a[:3, :3].T @ b[:3, :3])
        travel = np.linalg.norm(b[:3, 3] - a[:3, 3]) + radius * turn.magnitude()
        for t in np.linspace(0, 1, int(np.ceil(travel / spacing)) + 1)[1:]:
            pose = np.eye(4)
            pose[:3, :3] = a[:3, :3] @ Rotation.from_rotvec(t * turn.as_rotvec()).as_matrix()
            pose[:3, 3] = a[:3, 3] + t * (b[:3, 3] - a[:3, 3])
            result.append(pose)
    return result


def reach() -> float:
    """Return the distance from the TCP to the hand's farthest corner."""
    signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), -1).reshape(-1, 3)
    boxes = PANDA_HAND.boxes(PANDA_HAND.stroke)
    return max(float(np.linalg.norm(b.center + s * b.half_extents @ b.rotation.T)) for b in boxes for s in signs)


def matrix(x: float, y: float, z: float, w: float) -> Floats:
    """Return the rotation of a unit quaternion, without scipy's overhead."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def solve_ompl(problem: Problem, checker: Checker, resolution: float) -> tuple[float, Floats | None, float]:
    """Return seconds, path and seconds with simplification of OMPL's RRTConnect."""
    space = base.SE3StateSpace()
    corners = np.concatenate([problem.obj.bounds, problem.start[None, :3, 3], problem.goal[None, :3, 3]])
    bounds = base.RealVectorBounds(3)
    for axis in range(3):
        bounds.setLow(axis, float(corners[:, axis].min() - GRAFT_CONFIG.margin))
        bounds.setHigh(axis, float(corners[:, axis].max() + GRAFT_CONFIG.margin))
    space.setBounds(bounds)
    space.setSubspaceWeight(1, reach())
    setup = geometric.SimpleSetup(space)
    extent = space.getMaximumExtent()
    setup.getSpaceInformation().setStateValidityCheckingResolution(resolution / extent if resolution else 0.01)

    def valid(state: base.State) -> bool:
        q = state.rotation()
        return checker.free(matrix(q.x, q.y, q.z, q.w), np.array([state.getX(), state.getY(), state.getZ()]))

    setup.setStateValidityChecker(valid)

    def state_of(pose: Floats) -> base.State:
        state = space.allocState()
        state.setXYZ(*(float(v) for v in pose[:3, 3]))
        q = state.rotation()
        q.x, q.y, q.z, q.w = (float(v) for v in Rotation.from_matrix(pose[:3, :3]).as_quat())
        return state

    setup.setStartAndGoalStates(state_of(problem.start), state_of(problem.goal))
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    setup.setup()
    begun = time.process_time()
    setup.solve(OMPL_SECONDS)
    solved = time.process_time() - begun
    if not setup.haveExactSolutionPath():
        return solved, None, solved
    setup.simplifySolution()
    total = time.process_time() - begun
    poses = []
    for state in setup.getSolutionPath().getStates():
        q = state.rotation()
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        pose[:3, 3] = state.getX(), state.getY(), state.getZ()
        poses.append(pose)
    return solved, np.stack(poses), total


def valid_path(checker: Checker, poses: Floats) -> bool:
    """Whether FCL finds no pose of a path that touches, a pose every half millimetre."""
    return all(checker.free(pose[:3, :3], pose[:3, 3]) for pose in dense(poses, SPACING, reach()))


def length(poses: Floats) -> float:
    """Return metres, and radians times the reach."""
    turns = np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]
    ways = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    return float(ways.sum() + reach() * Rotation.from_matrix(turns).magnitude().sum())


@dataclass
class Run:
    """One problem: seconds until a path was found and until it was smooth, the path, its validity, collision tests."""

    search: float
    whole: float
    path: Floats | None
    valid: bool
    tests: int


def row(name: str, runs: list[Run]) -> None:
    """Print one planner's line."""
    found = [run for run in runs if run.path is not None]
    lengths = [length(run.path) for run in found if run.path is not None]
    whole = [1e3 * run.whole for run in runs]
    print(
        f"  {name:34} {len(found):4d}/{len(runs):<4d} {sum(run.valid for run in found):5d} "
        f"{1e3 * statistics.median(run.search for run in runs):9.2f} {statistics.median(whole):9.2f} "
        f"{float(np.quantile(whole, 0.9)):9.2f} {statistics.median(run.tests for run in runs):8.0f} "
        f"{statistics.median(lengths):7.2f}"
    )


def run_graft(todo: list[Problem], count: int) -> list[Run]:
    """Plan in calls of `count` times the same problem; a call of one builds the object's tree for itself."""
    runs = []
    for p in todo:
        seconds = []
        for config in (ROUGH, GRAFT_CONFIG):
            begun = time.process_time()
            motion = plan_motions(
                p.obj, [p.start] * count, [p.goal] * count, PANDA_HAND, support=p.support, config=config
            )[0]
            seconds.append((time.process_time() - begun) / count)
        path = motion.poses if motion.found else None
        valid = path is not None and valid_path(Checker(p.obj, p.support), path)
        runs.append(Run(seconds[0], seconds[1], path, valid, motion.checks))
    return runs


def run_ompl(todo: list[Problem], resolution: float) -> list[Run]:
    """Plan with OMPL; the object's tree is built before the clock starts."""
    runs = []
    for p in todo:
        checker = Checker(p.obj, p.support)
        search, path, whole = solve_ompl(p, checker, resolution)
        calls = checker.calls
        runs.append(Run(search, whole, path, path is not None and valid_path(checker, path), calls))
    return runs


def is_direct(p: Problem) -> bool:
    """Whether the straight motion is free."""
    return plan_motions(p.obj, [p.start], [p.goal], PANDA_HAND, support=p.support, config=DIRECT)[0].found


PLANNERS: dict[str, Callable[[list[Problem]], list[Run]]] = {
    "graft, a call each": lambda todo: run_graft(todo, 1),
    f"graft, {BATCH} in a call, per plan": lambda todo: run_graft(todo, BATCH),
    "OMPL + FCL, steps of 1 % of extent": lambda todo: run_ompl(todo, 0.0),
    "OMPL + FCL, steps of 2 mm": lambda todo: run_ompl(todo, 0.002),
}


def hand_tables(todo: list[Problem]) -> None:
    """Print all planners on the same problems: by the kind of goal, and those without a direct way again."""
    results = {name: planner(todo) for name, planner in PLANNERS.items()}
    direct = [is_direct(p) for p in todo]
    kinds = {
        "pre-grasps": [not p.narrow for p in todo],
        "grasps, the fingers around the part": [p.narrow for p in todo],
        "of both, no direct way": [not d for d in direct],
    }
    for kind, chosen in kinds.items():
        straight = sum(c and d for c, d in zip(chosen, direct, strict=True))
        print(f"{kind}: {sum(chosen)} problems, {straight} with a direct way; ms")
        print(f"  {'':34} {'found':>9} {'valid':>5} {'search':>9} {'whole':>9} {'90 %':>9} {'tests':>8} {'length':>7}")
        for name, runs in results.items():
            row(name, [run for run, c in zip(runs, chosen, strict=True) if c])


def arm_table() -> None:
    """Print how often and how fast the Panda reaches poses that some configuration has."""
    arm = panda_arm().holding(PANDA_HAND.stroke)
    mug, ground = standing(zoo.make("mug", 0))
    T_world_object = translation(np.array([0.5, 0.0, 0.0]))
    table = Support(ground.normal, ground.offset)
    world = world_around(mug, T_world_object, table)
    joints = np.random.default_rng(0).uniform(*arm.chain.limits.T, (1200, arm.chain.n_joints))
    goals = joints[clear_joints(arm.chain, world, joints, CLEARANCE)][:ARM_GOALS]
    starts = np.roll(goals, 1, axis=0)
    poses = [tcp_pose(arm, q) for q in goals]

    def timed(name: str, work: Callable[[int], bool]) -> None:
        seconds, good = [], 0
        for i in range(len(goals)):
            begun = time.process_time()
            good += work(i)
            seconds.append(1e3 * (time.process_time() - begun))
        median, slow = statistics.median(seconds), float(np.quantile(seconds, 0.9))
        print(f"  {name:50} {good:4d}/{len(goals):<4d} {median:9.2f} {slow:9.2f}")

    print(f"Panda, {len(goals)} poses of random free configurations, a mug on a table; ms")
    print(f"  {'':50} {'found':>9} {'median':>9} {'90 %':>9}")
    one = IkConfig(attempts=1, solutions=1)
    timed("inverse kinematics, one attempt from home", lambda i: len(solve_ik(arm, poses[i], config=one)) > 0)
    first = IkConfig(solutions=1)
    timed("inverse kinematics, up to 24 attempts", lambda i: len(solve_ik(arm, poses[i], config=first)) > 0)
    timed(
        "RRT-Connect between configurations",
        lambda i: plan_joints(arm.chain, world, starts[i : i + 1], goals[i : i + 1])[0].found,
    )
    timed(
        "both, from home to a pose",
        lambda i: plan_arm(arm, mug, T_world_object, poses[i], support=table).found,
    )


def tcp_pose(arm: Arm, joints: Floats) -> Floats:
    """Return T_world_gripper at joint values (j,), by MuJoCo."""
    data = mujoco.MjData(arm.model)
    data.qpos[:] = joints
    mujoco.mj_kinematics(arm.model, data)
    pose = translation(data.site(arm.site).xpos)
    pose[:3, :3] = data.site(arm.site).xmat.reshape(3, 3)
    return pose


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--problems", type=int, default=3)
    todo = problems(parser.parse_args().problems)
    util.noOutputHandler()
    util.RNG.setSeed(1)
    hand_tables(todo)
    arm_table()


if __name__ == "__main__":
    main()
