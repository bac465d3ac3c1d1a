"""RRT-Connect for a free hand against OMPL's with FCL, on the same problems in one run; then a Panda arm.

    python benches/motion.py [--problems N]

Objects of the zoo (and YCB scans, with the extra demo) stand on a table; the hand starts above and beside them, open. Goals: poses 8 cm before
places on graspable parts (pre-grasps), and the grasps themselves, fingers around the part (narrow). Both planners get
problems whose ends keep 1 mm from everything by FCL. Every path of either planner is checked again by FCL, a pose
every half millimetre of travel.
"""

import argparse
import statistics
import time
from dataclasses import dataclass, replace

import fcl
import numpy as np
from ompl import base, geometric, util
from scipy.spatial.transform import Rotation

from graft import zoo
from graft.checks import Floats
from graft.errors import GraftError
from graft.grasp import PANDA_HAND, Support, in_metres
from graft.motion import MotionConfig, plan_motions
from graft.motion.approach import translation
from graft.objects import PartObject

CATEGORIES = ("mug", "pan", "kettle", "teapot", "water_bucket", "watering_can", "basket", "hammer")
SCANS = ("025_mug", "019_pitcher_base", "048_hammer", "035_power_drill", "033_spatula", "006_mustard_bottle")
CLEARANCE = 0.001
OMPL_SECONDS = 5.0
GRAFT_CONFIG = MotionConfig()
GROUND = 2.0  # half extent of the table's box for FCL, metres


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
        self.calls = 0

    def free(self, rotation: Floats, position: Floats) -> bool:
        """Whether the hand touches nothing."""
        self.calls += 1
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
    for a, b in zip(poses, poses[1:], strict=False):
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


def solve_ompl(problem: Problem, checker: Checker, fraction: float) -> tuple[float, Floats | None, float]:
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
    setup.getSpaceInformation().setStateValidityCheckingResolution(fraction)

    def valid(state: base.State) -> bool:
        q = state.rotation()
        rotation = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        return checker.free(rotation, np.array([state.getX(), state.getY(), state.getZ()]))

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
    begun = time.perf_counter()
    setup.solve(OMPL_SECONDS)
    solved = time.perf_counter() - begun
    if not setup.haveExactSolutionPath():
        return solved, None, solved
    setup.simplifySolution()
    total = time.perf_counter() - begun
    poses = []
    for state in setup.getSolutionPath().getStates():
        q = state.rotation()
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        pose[:3, 3] = state.getX(), state.getY(), state.getZ()
        poses.append(pose)
    return solved, np.stack(poses), total


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--problems", type=int, default=3)
    todo = problems(parser.parse_args().problems)
    util.noOutputHandler()
    print(len(todo), sum(p.narrow for p in todo))
    for narrow in (False, True):
        rows = []
        for p in (p for p in todo if p.narrow == narrow):
            begun = time.perf_counter()
            motion = plan_motions(p.obj, [p.start], [p.goal], PANDA_HAND, support=p.support)[0]
            one = time.perf_counter() - begun
            print(p.obj.name, p.obj.n_faces, motion.found, motion.iterations, motion.nodes, motion.checks, len(motion.poses), f"{1e3*one:.2f} ms", motion.reason)


if __name__ == "__main__":
    main()
