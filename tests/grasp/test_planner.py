"""Antipodal grasps of objects whose grasps can be told beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from grasp_shapes import UP, ball, below, block, contact, cup, ring

from graft import zoo
from graft.grasp import (
    PANDA_HAND,
    AntipodalPlanner,
    GraspSet,
    ScoreWeights,
    contact_in_metres,
    gripper_collisions,
    in_metres,
    plan_grasps,
)
from graft.objects import Floats, Part, PartObject


def lowest_points(grasps: GraspSet) -> Floats:
    """Return the lowest z of each open hand's boxes."""
    planner = AntipodalPlanner()
    lows = []
    for grasp in grasps:
        boxes = PANDA_HAND.boxes(planner.opening(grasp.width, PANDA_HAND))
        rotation, translation = grasp.pose[:3, :3], grasp.pose[:3, 3]
        lows.append(
            min(
                (rotation @ box.center + translation)[2] - np.abs((rotation @ box.rotation)[2]) @ box.half_extents
                for box in boxes
            )
        )
    return np.array(lows)


def test_a_block_is_taken_across_its_thickness() -> None:
    grasps = plan_grasps(block(), contact((0.02, 0.0, 0.03), (1.0, 0.0, 0.0)))
    assert len(grasps) > 10
    np.testing.assert_allclose(np.abs(grasps.poses[:, 0, 1]), 1.0, atol=0.06)
    np.testing.assert_allclose(grasps.widths, 0.04, atol=2e-3)
    assert grasps[0].width == pytest.approx(0.04, abs=1e-6)
    assert abs(grasps[0].pose[0, 3]) < 1e-6, "the hand is centred"
    assert (np.diff(grasps.scores) <= 0).all()
    assert grasps.distances.max() <= 0.03


def test_pads_lie_where_contacts_say() -> None:
    for grasp in plan_grasps(ball(), contact((0.0, 0.0, 0.03), UP)):
        local = (grasp.contacts - grasp.pose[:3, 3]) @ grasp.pose[:3, :3]
        np.testing.assert_allclose(local[:, 1], [grasp.width / 2, -grasp.width / 2], atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(grasp.contacts, axis=1), 0.03, atol=1.5e-3)
        assert np.linalg.det(grasp.pose[:3, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize("obj", [ball(), block(), ring(), cup()], ids=lambda obj: obj.name)
def test_open_hands_touch_neither_object_nor_support(obj: PartObject) -> None:
    planner, support = AntipodalPlanner(), below(obj)
    grasps = plan_grasps(obj, support=support)
    assert len(grasps)
    openings = [planner.opening(width, PANDA_HAND) for width in grasps.widths]
    back = np.eye(4)
    for travelled in np.linspace(0.0, planner.travel, 9):
        back[2, 3] = -travelled
        hits = gripper_collisions(obj, PANDA_HAND, grasps.poses @ back, openings, support=support)
        assert not hits.any()
    assert lowest_points(grasps).min() >= support.offset + planner.margin - 1e-9


def test_every_wall_behind_is_found() -> None:
    grasps = plan_grasps(ring(), contact((0.058, 0.0, 0.0), (1.0, 0.0, 0.0)))
    # The tube alone, though the ray goes on to the ring's far side, 116 mm away.
    np.testing.assert_allclose(grasps.widths, 0.016, atol=1.5e-3)


def test_a_sheet_is_pinched_at_its_rim() -> None:
    obj = cup()
    grasps = plan_grasps(obj, contact((0.06, 0.0, 0.045), (1.0, 0.0, 0.0)), support=below(obj))
    assert len(grasps)
    assert grasps[0].width < 0.002
    assert grasps[0].pose[2, 2] < -0.5, "from above"


def test_winding_does_not_matter() -> None:
    obj = block()
    part = obj.parts[0]
    inward = PartObject("inward", (Part("block", part.vertices, part.faces[:, ::-1]),), up=obj.up, scale_to_metres=1.0)
    here = contact((0.02, 0.0, 0.03), (1.0, 0.0, 0.0))
    ours, theirs = plan_grasps(obj, here), plan_grasps(inward, here)
    # Samples differ, because corners come in another order; what is found may not.
    assert min(len(ours), len(theirs)) > 10
    assert theirs[0].width == pytest.approx(0.04, abs=1e-6)


def test_too_wide_is_said() -> None:
    grasps = plan_grasps(block(0.12, 0.12, 0.12), contact((0.06, 0.0, 0.0), (1.0, 0.0, 0.0)))
    assert len(grasps) == 0
    assert grasps.rejected["too wide"] > 100


def test_a_flat_thing_is_taken_from_above() -> None:
    obj = block(0.03, 0.15, 0.012)
    support = below(obj)
    grasps = plan_grasps(obj, contact((0.0, 0.0, 0.006), UP), support=support)
    assert len(grasps)
    assert (grasps.poses[:10, 2, 2] < -0.7).all()
    assert (grasps.poses[:, 2, 2] < 0).all()
    assert lowest_points(grasps).min() >= support.offset


@pytest.mark.parametrize("approach", [(0.0, 0.0, -1.0), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)])
def test_the_demonstrated_approach_is_followed(approach: tuple[float, float, float]) -> None:
    wanted = replace(contact((0.015, 0.0, 0.0), (1.0, 0.0, 0.0)), approach=np.array(approach))
    planner = AntipodalPlanner(weights=ScoreWeights(approach=10.0))
    best = plan_grasps(block(0.03, 0.05, 0.05), wanted, planner=planner)[0]
    assert best.pose[:3, 2] @ approach > 0.95


def test_a_part_is_kept_to() -> None:
    obj = zoo.make("mug", 0)
    handle = obj.part_index("handle")
    grasps = plan_grasps(obj, part="handle")
    assert len(grasps)
    metric = in_metres(obj).parts[handle].vertices
    gaps = np.linalg.norm(grasps.contacts[:, :, None] - metric, axis=-1).min(axis=(1, 2))
    assert gaps.max() < 0.01


def test_clouds_are_grasped_like_meshes() -> None:
    mesh = ball()
    part = mesh.parts[0]
    cloud = PartObject("cloud", (Part("ball", part.vertices),), up=mesh.up, scale_to_metres=1.0)
    grasps = plan_grasps(cloud, contact((0.0, 0.0, 0.03), UP))
    assert len(grasps)
    np.testing.assert_allclose(grasps.widths, 0.06, atol=3e-3)


def test_units_do_not_matter() -> None:
    demonstration = zoo.demonstration("kettle", 0)
    thousand = np.diag([1000.0, 1000.0, 1000.0, 1.0])
    metric = plan_grasps(
        in_metres(demonstration.object), contact_in_metres(demonstration.contact, demonstration.object)
    )
    millimetres = plan_grasps(demonstration.object.transformed(thousand), demonstration.contact.transformed(thousand))
    # Rounding decides between grasps that are equally good, further down.
    np.testing.assert_allclose(metric.scores[:3], millimetres.scores[:3], atol=1e-6)
    np.testing.assert_allclose(metric[0].pose, millimetres[0].pose, atol=1e-6)


def test_pieces_of_a_closed_scan_have_an_inside() -> None:
    part = ball().parts[0]
    upper = part.vertices[part.faces].mean(axis=1)[:, 2] > 0
    pieces = tuple(Part(name, part.vertices, part.faces[keep]) for name, keep in (("upper", upper), ("lower", ~upper)))
    scan = PartObject("scan", pieces, up=np.array(UP), scale_to_metres=1.0)
    grasps = plan_grasps(scan, contact((0.0, 0.0, 0.03), UP))
    assert len(grasps) > 5
    assert grasps.widths.min() > 0.05, "no pinches of what is no sheet"
