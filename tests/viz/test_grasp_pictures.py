"""Grasps drawn: the gripper stands where the pose says, in pictures, pages and models."""

import numpy as np
import pytest
import scenes
import trimesh
from PIL import Image

from graft.errors import InputError
from graft.grasp import PANDA_HAND, ROBOTIQ_2F85, GraspSet
from graft.objects import Contact
from graft.viz import save_grasp_glb, save_grasp_scene, save_grasp_sheet
from graft.viz.grippers import BOX_FACES, gripper_shapes, stick_shapes
from graft.viz.layout import place_grasps

HANDLE = np.array([0.075, 0.0, 0.0])
"""The middle of the handle of `scenes.mug`, metres: its unit is a decimetre."""

CONTACT = Contact((0.8, 0.0, 0.0), (1.0, 0.0, 0.0), 1)


def grasps(n=3, gripper=PANDA_HAND):
    """Grasps of the mug's handle from outside, one above the other."""
    pose = np.eye(4)
    pose[:3, :3] = np.stack([(0, 0, 1.0), (0, 1.0, 0), (-1.0, 0, 0)], axis=1)
    poses = np.tile(pose, (n, 1, 1))
    poses[:, :3, 3] = HANDLE + np.linspace(0, 0.02, n)[:, None] * [0, 0, 1]
    return GraspSet(poses, np.full(n, 0.01), np.linspace(1, 0, n), np.zeros((n, 2, 3)), np.zeros(n), gripper)


def test_the_faces_of_a_box_close_it_and_look_outward():
    box = PANDA_HAND.pad
    mesh = trimesh.Trimesh(box.corners, BOX_FACES, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.prod(2 * box.half_extents))


@pytest.mark.parametrize("gripper", [PANDA_HAND, ROBOTIQ_2F85], ids=lambda g: g.name)
def test_the_pads_touch_the_object_where_the_grasp_closes(gripper):
    shapes = {s.name: s for s in gripper_shapes(grasps(1, gripper)[0])}
    assert shapes["right_pad"].vertices[:, 1].min() == pytest.approx(0.005)
    assert shapes["left_pad"].vertices[:, 1].max() == pytest.approx(-0.005)
    # The palm lies away from the object, against the approach -x.
    assert shapes["palm_0"].vertices[:, 0].min() > HANDLE[0]
    assert len(shapes) == len(gripper.palm) + 2 * len(gripper.finger)


def test_sticks_are_greener_where_the_score_is_higher():
    sticks = stick_shapes(grasps(), 0.1)
    green = [s.color[1] - (s.color[0] + s.color[2]) / 2 for s in sticks]
    assert green[0] > green[1] > green[2]
    assert len({s.color for s in stick_shapes(grasps(1), 0.1)}) == 1  # one grasp has no worse one
    ends = sticks[0].vertices
    assert np.abs(ends[:, 1]).max() < 0.01  # within the fingers


def test_a_scene_has_grasps_in_the_unit_of_its_object():
    placed, shapes = place_grasps(scenes.mug(), grasps(), CONTACT)
    # The object has a diagonal of 1; the mug's is 1.73 decimetres.
    scale = placed.shapes[0].vertices[:, 2].max() / 0.05
    pads = [s for s in shapes if s.name == "best/right_pad"]
    assert pads[0].vertices[:, 1].min() == pytest.approx(0.005 * scale)
    assert [s.name for s in shapes if s.name.startswith("grasp_")] == ["grasp_1", "grasp_2"]
    np.testing.assert_allclose(placed.contact.point, scale * np.array([0.08, 0, 0]))


@pytest.mark.parametrize("n", [1, 3, 8])
def test_a_sheet_has_an_overview_and_the_best_grasps(n, tmp_path):
    save_grasp_sheet(tmp_path / "g.png", scenes.mug(), grasps(n), CONTACT)
    with Image.open(tmp_path / "g.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    tiles = 1 + min(n, 5)
    columns = min(3, tiles)
    width = (pixels.shape[1] - 14) // columns
    for place in range(tiles):
        row, column = divmod(place, columns)
        top = 14 + (pixels.shape[0] - 14) // -(-tiles // columns) * row
        tile = pixels[top : top + 400, 14 + column * width : 14 + (column + 1) * width - 20]
        assert (np.abs(tile - (244, 176, 58)).sum(axis=2) < 90).any(), f"no amber handle in tile {place}"
        dark_grey = (np.ptp(tile, axis=2) < 25) & (tile.mean(axis=2) < 110)
        assert (dark_grey.mean() > 0.03) == (place > 0), f"{dark_grey.mean():.3f} of tile {place} is gripper"


def test_the_same_grasps_give_the_same_sheet(tmp_path):
    for name in ("a.png", "b.png"):
        save_grasp_sheet(tmp_path / name, scenes.mug(), grasps())
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_model_has_a_node_for_every_box_and_stick(tmp_path):
    save_grasp_glb(tmp_path / "g.glb", scenes.mug(), grasps(), CONTACT)
    scene = trimesh.load(tmp_path / "g.glb")
    nodes = set(scene.graph.nodes_geometry)
    assert {"object/body", "object/handle", "object/marks/contact", "object/grasps/best/palm_0"} <= nodes
    assert {"object/grasps/grasp_1", "object/grasps/grasp_2"} <= nodes
    # The pad and the handle touch in the model, too.
    pad = trimesh.transform_points(*_placed(scene, "object/grasps/best/right_pad"))
    handle = trimesh.transform_points(*_placed(scene, "object/handle"))
    depth = np.linalg.norm(pad[:, None] - handle[None], axis=2).min()
    assert depth < 0.25


def _placed(scene, node):
    transform, geometry = scene.graph[node]
    return scene.geometry[geometry].vertices, transform


def test_a_page_holds_the_grasps(tmp_path):
    pytest.importorskip("viser")
    save_grasp_scene(tmp_path / "g.html", scenes.mug(), grasps(), CONTACT)
    page = (tmp_path / "g.html").read_text()
    assert "<title>graft: grasps of mug</title>" in page


@pytest.mark.parametrize(
    ("save", "name"), [(save_grasp_sheet, "g.png"), (save_grasp_glb, "g.glb"), (save_grasp_scene, "g.html")]
)
def test_what_cannot_be_drawn_is_refused(save, name, tmp_path):
    with pytest.raises(InputError, match="at least one, got none"):
        save(tmp_path / name, scenes.mug(), GraspSet.empty(PANDA_HAND))
    with pytest.raises(InputError, match=r"ending in \.|expected"):
        save(tmp_path / "g.txt", scenes.mug(), grasps())
    assert not list(tmp_path.iterdir())
