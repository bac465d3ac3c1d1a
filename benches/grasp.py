"""Gripper collisions against FCL, and grasps near a contact against trimesh, embreex and FCL doing the same.

    RAYON_NUM_THREADS=1 taskset -c 1 python benches/grasp.py

Needs python-fcl and embreex. The peers' pipeline draws as many places near the contact, follows as many rays through
every wall, keeps as many antipodal pairs and tries as many poses of each: the hand where it ends and on its way there.
It leaves out pads, closing, scores and thinning, which graft's time includes.
"""

import statistics
import time
from collections.abc import Callable
from typing import Any

import fcl
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from graft import _core, zoo
from graft.grasp import PANDA_HAND, AntipodalPlanner, Box, contact_in_metres, in_metres, plan_grasps
from graft.grasp.collision import box_arrays
from graft.grasp.surface import Surface, surface_of
from graft.objects import Contact, Floats, PartObject

CATEGORIES = ("teapot", "mug", "pan", "kettle", "spray", "hammer")
N_POSES = 20_000
N_FCL_POSES = 1_000
PLANNER = AntipodalPlanner()


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the median processor time of `work`, which others on the machine disturb less than wall time."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def random_poses(surface: Surface, count: int) -> tuple[Floats, Floats]:
    """Return poses whose TCP is within some centimetres of the surface, and openings."""
    rng = np.random.default_rng(0)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, rng=rng).as_matrix()
    back = rng.uniform(-0.02, 0.08, (count, 1)) * poses[:, :3, 2]
    poses[:, :3, 3] = surface.vertices[rng.integers(len(surface.vertices), size=count)] - back
    return poses, rng.uniform(0.0, PANDA_HAND.stroke, count)


class FclHand:
    """Boxes against a mesh, by FCL."""

    def __init__(self, surface: Surface, boxes: tuple[Box, ...]) -> None:
        """Build FCL's tree, and its boxes once."""
        model = fcl.BVHModel()
        model.beginModel(len(surface.vertices), len(surface.faces))
        model.addSubModel(surface.vertices, surface.faces)
        model.endModel()
        self.mesh = fcl.CollisionObject(model)
        self.boxes = boxes
        self.shapes = [fcl.CollisionObject(fcl.Box(*(2 * box.half_extents))) for box in boxes]
        self.request = fcl.CollisionRequest()

    def placed(self, pose: Floats, boxes: tuple[Box, ...]) -> list[Any]:
        """Return the boxes' transforms at a pose."""
        rotation, translation = pose[:3, :3], pose[:3, 3]
        return [fcl.Transform(rotation, rotation @ box.center + translation) for box in boxes]

    def collides(self, transforms: list[Any]) -> bool:
        """Say whether any box touches, first come first served."""
        for shape, transform in zip(self.shapes, transforms, strict=True):
            shape.setTransform(transform)
            if fcl.collide(shape, self.mesh, self.request, fcl.CollisionResult()):
                return True
        return False


def ours(surface: Surface, poses: Floats, openings: Floats) -> Any:
    """Check poses with graft."""
    return _core.gripper_collisions(
        vertices=surface.vertices,
        faces=surface.faces,
        points=surface.points,
        radii=surface.radii,
        poses=poses,
        openings=openings,
        margin=0.0,
        plane=None,
        solid=False,
        **box_arrays(PANDA_HAND),
    )


def collisions(category: str) -> None:
    """Print one row of the collision table."""
    surface = surface_of(in_metres(zoo.make(category, 0)))
    poses, openings = random_poses(surface, N_POSES)
    build = seconds(lambda: ours(surface, poses[:1], openings[:1]), 9)
    rate = N_POSES / (seconds(lambda: ours(surface, poses, openings), 5) - build)
    hand = FclHand(surface, PANDA_HAND.boxes(0.04))
    # Placed before the clock starts, so that FCL is timed and not Python's arithmetic.
    placed = [hand.placed(p, PANDA_HAND.boxes(w)) for p, w in zip(poses[:N_FCL_POSES], openings, strict=False)]
    start = time.process_time()
    theirs = [hand.collides(transforms) for transforms in placed]
    python = N_FCL_POSES / (time.process_time() - start)
    answers = ours(surface, poses, openings)
    differ = int((answers[:N_FCL_POSES] != np.array(theirs)).sum())
    print(
        f"  {category:10s} {len(surface.faces):6d} {answers.mean():5.2f} {1e3 * build:9.2f} {rate:13,.0f} "
        f"{python:12,.0f} {rate / python:6.0f} {differ:7d}"
    )


def swept(box: Box) -> Box:
    """Return the box that a box passes on the way in."""
    back = np.array([0.0, 0.0, -PLANNER.travel / 2])
    return Box(box.center + back, box.half_extents - back)


def peers(mesh: trimesh.Trimesh, hand: FclHand, contact: Contact) -> int:
    """Find grasps near a contact with trimesh, embreex and FCL; return how many poses are free."""
    rng = np.random.default_rng(0)
    near = np.linalg.norm(mesh.triangles_center - contact.point, axis=1)
    weight = mesh.area_faces * np.exp(-((near / (0.5 * PLANNER.radius)) ** 2) / 2) * (near < PLANNER.radius)
    points, faces = trimesh.sample.sample_surface(mesh, PLANNER.samples, face_weight=weight, seed=0)
    inward = -mesh.face_normals[faces]
    cone = np.arctan(PLANNER.friction)
    directions = np.repeat(inward, PLANNER.rays, axis=0)
    jitter = rng.normal(size=directions.shape)
    jitter -= (jitter * directions).sum(1, keepdims=True) * directions
    jitter /= np.linalg.norm(jitter, axis=1, keepdims=True)
    angle = np.arccos(rng.uniform(np.cos(cone), 1.0, (len(directions), 1)))
    angle[:: PLANNER.rays] = 0.0
    directions = np.cos(angle) * directions + np.sin(angle) * jitter
    origins = np.repeat(points, PLANNER.rays, axis=0) + 1e-6 * directions
    hits, rays, there = mesh.ray.intersects_location(origins, directions, multiple_hits=True)
    widths = np.linalg.norm(hits - origins[rays], axis=1)
    aligned = (mesh.face_normals[there] * directions[rays]).sum(1)
    good = (aligned > np.cos(cone)) & (widths < PANDA_HAND.stroke) & (widths > 1e-5)
    best = np.flatnonzero(good)[np.argsort(-aligned[good], kind="stable")][: PLANNER.pairs]
    free = 0
    for pair in best:
        axis = -directions[rays[pair]]
        middle = (hits[pair] + origins[rays[pair]]) / 2
        boxes = tuple(swept(box) for box in PANDA_HAND.boxes(PLANNER.opening(widths[pair], PANDA_HAND)))
        first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        for turn in 2 * np.pi * np.arange(PLANNER.approaches) / PLANNER.approaches:
            come = np.cos(turn) * first + np.sin(turn) * second
            for depth in PLANNER.depths:
                pose = np.eye(4)
                pose[:3] = np.stack([np.cross(axis, come), axis, come, middle + depth * come], axis=1)
                free += not hand.collides(hand.placed(pose, boxes))
    return free


def planning(category: str) -> None:
    """Print one row of the planning table."""
    demonstration = zoo.demonstration(category, 0)
    obj: PartObject = in_metres(demonstration.object)
    contact = contact_in_metres(demonstration.contact, demonstration.object)
    surface = surface_of(obj)
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    widest = PLANNER.opening(PANDA_HAND.stroke, PANDA_HAND)
    hand = FclHand(surface, tuple(swept(box) for box in PANDA_HAND.boxes(widest)))
    peers(mesh, hand, contact)  # builds embree's tree, normals and areas
    build = seconds(lambda: ours(surface, np.eye(4)[None], np.zeros(1)), 9)
    whole = seconds(lambda: plan_grasps(obj, contact), 15)
    theirs = seconds(lambda: peers(mesh, hand, contact), 3)
    found = len(plan_grasps(obj, contact))
    print(
        f"  {category:10s} {len(surface.faces):6d} {found:4d} {1e3 * whole:9.2f} {1e3 * (whole - build):14.2f} "
        f"{1e3 * theirs:9.1f} {theirs / whole:6.0f}"
    )


def main() -> None:
    """Print both tables."""
    print(f"collisions of Panda's hand (5 boxes), {N_POSES} poses near the surface, one thread, processor time")
    print("  object      faces   hit build, ms  graft, poses/s   FCL, poses/s  ratio  differ")
    for category in CATEGORIES:
        collisions(category)
    poses = PLANNER.pairs * PLANNER.approaches * len(PLANNER.depths)
    print(f"top 20 near a contact: {PLANNER.samples} places, {PLANNER.rays} rays each, {poses} poses; likewise")
    print("  object      faces   n  graft, ms  less build, ms  peers, ms  ratio")
    for category in CATEGORIES:
        planning(category)


if __name__ == "__main__":
    main()
