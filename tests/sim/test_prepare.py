"""How objects come to stand."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import trimesh
from sim_scenes import box, mesh_object

from graft import zoo
from graft.errors import InputError
from graft.objects import Part, PartObject
from graft.sim import SimulationConfig, prepare, random_poses, resting_poses
from graft.sim.poses import rotation_angle, turning


@pytest.mark.parametrize("category", ["mug", "wine_bottle", "kettle", "briefcase", "hammer"])
def test_zoo_objects_stand_as_they_are_drawn(category: str) -> None:
    prepared = prepare(zoo.make(category, 0))
    assert prepared.pose.stable
    assert prepared.pose.upright
    assert prepared.pose.drift_distance < 1e-3
    support = prepared.support
    heights = support.height(np.vstack([part.vertices for part in prepared.object.parts]))
    assert abs(heights.min()) < 5e-4


def test_a_leaning_tower_is_laid_down() -> None:
    tower = trimesh.creation.box((0.02, 0.02, 0.2))
    tower.apply_transform(trimesh.transformations.rotation_matrix(np.radians(30), (0, 1, 0)))
    prepared = prepare(mesh_object("tower", tower))
    assert prepared.pose.stable
    assert not prepared.pose.upright
    assert prepared.pose.height == pytest.approx(0.01, abs=5e-4)


def test_a_box_rests_on_its_six_faces_the_widest_first() -> None:
    poses = [prepared.pose for prepared in resting_poses(box(0.05, 0.08, 0.12), count=8)]
    assert len(poses) == 6
    assert poses[0].upright
    heights = [round(pose.height, 3) for pose in poses[1:]]
    assert heights == [0.025, 0.025, 0.04, 0.04, 0.06]
    barriers = [round(pose.barrier, 6) for pose in poses[1:]]
    assert barriers == sorted(barriers, reverse=True)


def test_up_is_heeded() -> None:
    obj = box(0.05, 0.08, 0.12)
    lying = PartObject(obj.name, obj.parts, up=np.array([1.0, 0, 0]), scale_to_metres=1.0)
    pose = prepare(lying).T_world_object
    assert np.allclose(pose[:3, :3] @ (1, 0, 0), (0, 0, 1), atol=1e-3)


def test_millimetres_and_metres_stand_alike() -> None:
    obj = zoo.make("mug", 1)
    small = PartObject(
        obj.name,
        tuple(Part(p.name, p.vertices * 1000, p.faces, sweeps=p.sweeps) for p in obj.parts),
        up=obj.up,
        scale_to_metres=0.001,
    )
    assert np.allclose(prepare(small).T_world_object, prepare(obj).T_world_object, atol=1e-4)


def test_without_volume_there_is_no_physics() -> None:
    sheet = Part("sheet", [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0.1, 0.1, 0)], [(0, 1, 2), (1, 3, 2)])
    with pytest.raises(InputError, match="object 'sheet': it has no volume"):
        prepare(PartObject("sheet", (sheet,), scale_to_metres=1.0))


def test_random_poses_are_turns_and_shifts() -> None:
    prepared = prepare(box(0.05, 0.05, 0.1))
    poses = random_poses(prepared, 20, 7)
    assert np.array_equal(poses[:5], random_poses(prepared, 5, 7))
    assert not np.array_equal(poses, random_poses(prepared, 20, 8))
    assert np.allclose(poses[:, 2, 3], prepared.T_world_object[2, 3])
    assert np.allclose(poses[:, 2, :3], prepared.T_world_object[2, :3])
    assert np.abs(poses[:, :2, 3]).max() < 0.2


def test_prepared_objects_travel() -> None:
    prepared = prepare(zoo.make("mug", 1))
    again = pickle.loads(pickle.dumps(prepared))
    assert np.array_equal(again.T_world_object, prepared.T_world_object)


def test_turnings() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        a, b = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
        rotation = turning(a, b)
        assert np.allclose(rotation @ a, b)
        assert rotation_angle(rotation) == pytest.approx(np.degrees(np.arccos(a @ b)))
        assert np.allclose(turning(a, -a) @ a, -a)


@pytest.mark.parametrize(
    ("field", "value", "wanted"),
    [
        ("friction", -1.0, "at least 0"),
        ("force", 0.0, "a positive number"),
        ("mass", float("nan"), "finite numbers"),
        ("timestep", 0.1, "at most 0.005 s"),
        ("condim", 5, "3, 4 or 6"),
        ("lift_height", 0.01, "at least secured_height"),
    ],
)
def test_settings_out_of_range(field: str, value: float, wanted: str) -> None:
    with pytest.raises(InputError, match=f"simulation {field}: expected {wanted}"):
        SimulationConfig(**{field: value})
