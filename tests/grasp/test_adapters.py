"""Other people's grasps: AnyGrasp's SDK played by a fake module, and grasps from files."""

import sys
from dataclasses import replace
from types import ModuleType
from typing import ClassVar

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from graft.errors import GraftError, InputError
from graft.grasp import PANDA_HAND, AnyGraspPlanner, FilePlanner, GraspSet, Support, save_grasps
from graft.grasp.adapters.selection import distances_to
from graft.objects import Contact, Part, PartObject

HANDLE = np.array([0.1, 0.0, 0.05])


def mug():
    """A body and a handle, z up, standing on z = 0."""
    body = trimesh.creation.cylinder(radius=0.04, height=0.1)
    body.apply_translation((0, 0, 0.05))
    handle = trimesh.creation.box((0.02, 0.01, 0.06))
    handle.apply_translation(HANDLE)
    parts = tuple(Part(n, m.vertices, m.faces) for n, m in (("body", body), ("handle", handle)))
    return PartObject("mug", parts, up=(0, 0, 1), scale_to_metres=1.0)


def pose(position, approach=(0.0, 0.0, -1.0), closing=(0.0, 1.0, 0.0)):
    z, y = np.array(approach), np.array(closing)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
    matrix[:3, 3] = position
    return matrix


def grasps_at(*positions, widths=0.01):
    poses = np.array([pose(p) for p in positions])
    n = len(poses)
    scores = -np.arange(float(n))
    return GraspSet(poses, np.full(n, widths), scores, np.zeros((n, 2, 3)), np.zeros(n), PANDA_HAND)


def above(height):
    """A place so far above the middle of the handle."""
    return HANDLE + np.array([0.0, 0.0, height])


CONTACT = Contact(HANDLE + np.array([0.0, 0.005, 0.0]), (0, 1, 0), 1)


def test_a_distance_is_to_the_box_between_the_pads():
    grasps = grasps_at((0, 0, 0), widths=0.04)
    for point, expected in (
        ((0.005, 0.01, -0.005), 0.0),
        ((0.029, 0, 0), 0.02),
        ((0, 0.05, 0), 0.03),
        ((0, 0, 0.019), 0.01),
    ):
        assert distances_to(grasps, np.array(point))[0] == pytest.approx(expected, abs=1e-12)


def test_a_file_gives_the_grasps_near_the_contact(tmp_path):
    far, near, again = (0.0, 0.0, 0.05), above(0.01), above(0.011)
    save_grasps(tmp_path / "g.npz", grasps_at(far, near, again))
    found = FilePlanner(tmp_path / "g.npz").plan(mug(), CONTACT, PANDA_HAND)
    np.testing.assert_allclose(found.poses[:, :3, 3], [near])
    assert found.rejected == {"far from the contact": 1, "like a better one": 1}
    assert found.metadata["planner"] == "file"
    anywhere = FilePlanner(tmp_path / "g.npz", check_collisions=False)  # the far one lies inside the body
    assert len(anywhere.plan(mug(), None, PANDA_HAND)) == 2
    assert len(anywhere.plan(mug(), None, PANDA_HAND, k=1)) == 1


def test_a_file_gives_the_grasps_on_a_part_and_above_the_support(tmp_path):
    save_grasps(tmp_path / "g.npy", grasps_at((0.0, 0.03, 0.1), above(0.02), above(-0.045)))
    planner = FilePlanner(tmp_path / "g.npy")
    on_handle = replace(planner, check_collisions=False).plan(mug(), None, PANDA_HAND, part="handle")
    assert len(on_handle) == 2
    assert on_handle.rejected["on another part"] == 1
    clear = planner.plan(mug(), None, PANDA_HAND, part="handle", support=Support((0, 0, 1), 0.0))
    assert len(clear) == 1
    assert clear.rejected["below the support"] == 1


def test_a_grasp_in_which_the_gripper_hits_the_object_is_left_out(tmp_path):
    # From above the palm ends 37 mm above the TCP: at 5 mm below the middle of the 60 mm handle it is 2 mm clear.
    save_grasps(tmp_path / "g.npz", grasps_at(above(-0.005), above(-0.009), above(0.02)))
    found = FilePlanner(tmp_path / "g.npz").plan(mug(), None, PANDA_HAND)
    np.testing.assert_allclose(found.poses[:, 2, 3], [0.045, 0.07])
    assert found.rejected == {"the gripper hits the object": 1}


def test_anygrasps_grasps_are_checked_against_the_object(gsnet):
    found = AnyGraspPlanner(gsnet).plan(mug(), None, PANDA_HAND)
    assert len(found) + found.rejected["the gripper hits the object"] == 4


def test_a_grasp_wider_than_the_stroke_is_left_out(tmp_path):
    save_grasps(tmp_path / "g.npy", grasps_at(HANDLE, widths=0.09))
    found = FilePlanner(tmp_path / "g.npy").plan(mug(), CONTACT, PANDA_HAND)
    assert len(found) == 0
    assert found.rejected == {"wider than the stroke": 1}


class FakeGroup:
    def __init__(self, rows):
        self.grasp_group_array = rows

    def __len__(self):
        return len(self.grasp_group_array)


class FakeAnyGrasp:
    """Finds the point nearest to the camera and grasps it straight ahead, as the documented interface has it."""

    made: ClassVar = []
    answer = staticmethod(lambda rows: (FakeGroup(rows), object()))

    def __init__(self, config):
        self.config, self.loaded, self.calls = config, False, []
        FakeAnyGrasp.made.append(self)

    def load_net(self):
        self.loaded = True

    def get_grasp(self, points, colors, lims, apply_object_mask=True, dense_grasp=False, collision_detection=True):
        assert self.loaded
        assert points.dtype == colors.dtype == np.float32
        assert points.shape == colors.shape
        assert len(lims) == 6
        assert ((points >= np.float32(lims[::2])) & (points <= np.float32(lims[1::2]))).all()
        self.calls.append(points)
        nearest = points[np.argmin(points[:, 2])]
        # x of GraspNet's frame, the approach, is the camera's z; y, the closing, the camera's x.
        rotation = np.stack([(0, 0, 1.0), (1.0, 0, 0), (0, 1.0, 0)], axis=1)
        rows = np.concatenate([[0.5, 0.03, 0.02, 0.02], rotation.ravel(), nearest, [-1]])[None]
        return self.answer(rows)


@pytest.fixture
def gsnet(monkeypatch, tmp_path):
    module = ModuleType("gsnet")
    module.AnyGrasp = FakeAnyGrasp
    monkeypatch.setitem(sys.modules, "gsnet", module)
    monkeypatch.setattr(FakeAnyGrasp, "made", [])
    (tmp_path / "checkpoint.tar").write_bytes(b"weights")
    return tmp_path / "checkpoint.tar"


def test_anygrasp_is_asked_as_it_documents_and_brought_back_to_the_object(gsnet):
    planner = AnyGraspPlanner(gsnet, gripper_height=0.02, check_collisions=False)
    found = planner.plan(mug(), None, PANDA_HAND, k=50)
    detector = FakeAnyGrasp.made[0]
    assert vars(detector.config) == {
        "checkpoint_path": str(gsnet),
        "max_gripper_width": 0.08,
        "gripper_height": 0.02,
        "top_down_grasp": False,
        "debug": False,
    }
    assert len(detector.calls) == 4
    # The cameras stand half a metre away, and see less than half of the 40,000 points.
    for points in detector.calls:
        assert 0.4 < points[:, 2].min() < 0.5
        assert 1000 < len(points) < 25_000
    # Every grasp reaches 20 mm past a point of the surface, and comes from 35 degrees above.
    assert len(found) == 4
    surface = trimesh.util.concatenate([trimesh.Trimesh(p.vertices, p.faces) for p in mug().parts])
    samples = trimesh.sample.sample_surface(surface, 100_000, seed=0)[0]
    nearest = found.poses[:, :3, 3] + (PANDA_HAND.tip - 0.02) * found.poses[:, :3, 2]
    assert cKDTree(samples).query(nearest)[0].max() < 1.5e-3
    np.testing.assert_allclose(found.poses[:, 2, 2], -np.sin(np.radians(35.0)))
    assert found.metadata == {"planner": "anygrasp", "seed": 0}
    planner.plan(mug(), None, PANDA_HAND)
    assert len(FakeAnyGrasp.made) == 1  # the network is loaded once


def test_anygrasp_is_the_same_for_the_same_seed_and_filtered_for_the_contact(gsnet):
    first = AnyGraspPlanner(gsnet, radius=0.06, check_collisions=False).plan(mug(), CONTACT, PANDA_HAND, seed=3)
    again = AnyGraspPlanner(gsnet, radius=0.06, check_collisions=False).plan(mug(), CONTACT, PANDA_HAND, seed=3)
    np.testing.assert_array_equal(first.poses, again.poses)
    assert 0 < len(first) < 4
    assert (first.distances <= 0.06).all()
    assert len(first) + sum(first.rejected.values()) == 4


@pytest.mark.parametrize(
    "answer", [lambda rows: None, lambda rows: (FakeGroup(rows[:0]), None), lambda rows: (None, None)]
)
def test_anygrasp_may_find_nothing(gsnet, monkeypatch, answer):
    monkeypatch.setattr(FakeAnyGrasp, "answer", staticmethod(answer))
    assert len(AnyGraspPlanner(gsnet).plan(mug(), None, PANDA_HAND)) == 0


def test_what_anygrasp_does_not_document_is_refused(gsnet, monkeypatch):
    monkeypatch.setattr(FakeAnyGrasp, "answer", staticmethod(lambda rows: ([1, 2, 3], None)))
    with pytest.raises(InputError, match="AnyGrasp: expected a GraspGroup, got list"):
        AnyGraspPlanner(gsnet).plan(mug(), None, PANDA_HAND)
    monkeypatch.setattr(FakeAnyGrasp, "answer", staticmethod(lambda rows: (FakeGroup(rows * np.nan), None)))
    with pytest.raises(InputError, match=r"AnyGrasp: row 0: .*finite"):
        AnyGraspPlanner(gsnet).plan(mug(), None, PANDA_HAND)


def test_a_point_cloud_is_shown_to_anygrasp_as_it_is(gsnet):
    cloud = PartObject(
        "cloud", (Part("cloud", np.random.default_rng(0).normal(0, 0.02, (500, 3))),), scale_to_metres=1.0
    )
    AnyGraspPlanner(gsnet).plan(cloud, None, PANDA_HAND)
    assert [len(points) for points in FakeAnyGrasp.made[0].calls] == [500] * 4


def test_without_the_sdk_or_the_weights_one_line_says_what_to_do(monkeypatch, gsnet, tmp_path):
    with pytest.raises(InputError, match="no such checkpoint"):
        AnyGraspPlanner(tmp_path / "none.tar").plan(mug(), None, PANDA_HAND)
    monkeypatch.setitem(sys.modules, "gsnet", None)
    with pytest.raises(GraftError, match=r"needs the AnyGrasp SDK: get a license.*github.com/graspnet") as caught:
        AnyGraspPlanner(gsnet).plan(mug(), None, PANDA_HAND)
    assert isinstance(caught.value, ImportError)
    assert "\n" not in str(caught.value)
