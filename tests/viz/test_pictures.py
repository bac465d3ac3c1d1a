"""PNG files: sizes, colours, and contacts that can be seen."""

import os

import numpy as np
import pytest
from PIL import Image
from scenes import KETTLE_CONTACT, cloud, kettle, mug, transfer

from graft.errors import InputError, MissingExtraError
from graft.objects import Contact, Part, PartObject
from graft.viz import save_glb, save_object_scene, save_sheet, save_views
from graft.viz.camera import contact_view, fit, look_from
from graft.viz.colors import (
    BAD,
    CONTACT,
    DEMONSTRATED,
    GOOD,
    PALETTE,
    UNKNOWN,
    UNMATCHED,
    matched_colors,
    part_colors,
)
from graft.viz.picture import HIDDEN_BELOW, draw_contact, project
from graft.viz.shapes import contact_shapes, diagonal, object_shapes
from graft.viz.sheet import EDGE


def read(path):
    with Image.open(path) as image:
        image.load()
        return np.asarray(image.convert("RGB")).astype(int)


def hue_share(pixels, color):
    """Share of pixels whose colour is `color`, lit more or less."""
    lit = pixels / np.maximum(np.linalg.norm(pixels, axis=-1, keepdims=True), 1)
    return (lit @ (np.array(color) / np.linalg.norm(color)) > 0.995).mean()


def reddish(pixels):
    return (pixels[..., 0] > 110) & (pixels[..., 1] < 90) & (pixels[..., 2] < 90)


def test_views_show_every_part_in_its_colour(tmp_path):
    save_views(tmp_path / "kettle.png", kettle())
    pixels = read(tmp_path / "kettle.png")
    for color in part_colors(3):
        assert hue_share(pixels, color) > 0.001
    assert (pixels == 255).all(axis=2).mean() > 0.3


def test_views_of_a_cloud(tmp_path):
    save_views(tmp_path / "ball.png", cloud())
    pixels = read(tmp_path / "ball.png")
    assert all(hue_share(pixels, color) > 0.02 for color in part_colors(2))


@pytest.mark.parametrize(
    ("target", "frame"),
    [(kettle(), GOOD), (kettle(graspable=(2,)), BAD), (kettle(graspable=()), UNKNOWN)],
)
def test_a_sheets_frame_tells_whether_the_contact_is_in_the_mask(tmp_path, target, frame):
    save_sheet(tmp_path / "sheet.png", transfer(target))
    assert read(tmp_path / "sheet.png")[EDGE + 1, EDGE + 20].tolist() == list(frame)


def test_a_sheet_grows_with_its_transfers_and_is_the_same_each_time(tmp_path):
    sizes = {}
    for n in (1, 2, 5):
        save_sheet(tmp_path / f"{n}.png", [transfer()] * n)
        sizes[n] = read(tmp_path / f"{n}.png").shape
    assert sizes[2][1] > sizes[1][1]
    assert sizes[5][0] > 2 * 300
    save_sheet(tmp_path / "again.png", [transfer()] * 2)
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "2.png").read_bytes()


@pytest.mark.parametrize(
    ("obj", "contact"),
    [
        (mug(), Contact((0.8, 0, 0), (1, 0, 0), 1)),
        (mug(), Contact((0.7, 0, 0), (-1, 0, 0), 1)),  # between body and handle
        (mug(), Contact((0, -0.5, 0.2), (0, -1, 0), 0)),
        (kettle(), KETTLE_CONTACT),
        (kettle(), Contact((0, 0, -0.4), (0, 0, -1), 0)),  # underneath
        (cloud(), Contact((0, 0, 1), (0, 0, 1), 0)),
    ],
)
def test_a_contact_is_seen(obj, contact):
    pixels, seen = draw_contact(obj, part_colors(len(obj.parts)), contact, 300)
    assert seen
    azimuth, elevation, visible = contact_view(obj, contact)
    assert visible >= HIDDEN_BELOW
    shapes = object_shapes(obj, part_colors(len(obj.parts))) + contact_shapes(contact, diagonal(obj))
    camera = fit(look_from(azimuth, elevation, obj.up), np.concatenate([s.vertices for s in shapes]), 300, 300)
    column, row = project(camera, contact.point)
    window = pixels[int(row) - 9 : int(row) + 10, int(column) - 9 : int(column) + 10].astype(int)
    assert reddish(window).mean() > 0.1
    assert not (pixels[[0, -1]] != 255).any(), "the whole object is in the frame"
    assert not (pixels[:, [0, -1]] != 255).any()


def test_a_contact_that_no_view_shows_gets_a_ring():
    inside = Contact((0, 0, 0), (0, 0, 1), 0)  # in the middle of the closed body
    pixels, seen = draw_contact(mug(), part_colors(2), inside, 300)
    assert not seen
    assert (pixels == np.array(CONTACT)).all(axis=2).sum() > 50


def test_target_parts_take_the_colour_of_what_sends_them_most():
    plan = np.array([[0.4, 0.1, 0.0], [0.1, 0.3, 0.0]])
    source = part_colors(2, demonstrated=1)
    assert source.tolist() == [list(PALETTE[0]), list(DEMONSTRATED)]
    assert matched_colors(plan, source).tolist() == [list(PALETTE[0]), list(DEMONSTRATED), list(UNMATCHED)]
    many = part_colors(51, demonstrated=4).astype(int)
    apart = np.abs(many[:, None] - many[None]).sum(axis=2) + 999 * np.eye(51, dtype=int)
    assert apart.min() > 15
    assert part_colors(200).max(axis=1).min() > 50
    assert np.abs(255 - part_colors(200).astype(int)).sum(axis=1).min() > 50


@pytest.mark.parametrize(
    "part",
    [
        Part("point", [[1.0, 2.0, 3.0]]),
        Part("flat", [[0, 0, 0], [1, 0, 0], [2, 0, 0.0]], [[0, 1, 2]]),
        Part("nowhere", [[5, 5, 5]] * 3, [[0, 1, 2]]),
        Part("far", np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]) * 1e-3 + 1e6, [[0, 1, 2]]),
        Part("huge", np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]) * 1e30, [[0, 1, 2]]),
    ],
    ids=lambda part: part.name,
)
def test_degenerate_objects_are_drawn_without_complaint(tmp_path, part):
    obj = PartObject(part.name, (part,))
    contact = Contact(part.vertices[0], (0, 0, 1), 0)
    save_views(tmp_path / "views.png", obj)
    save_sheet(tmp_path / "sheet.png", transfer(obj, contact, np.ones((2, 1))))
    save_glb(tmp_path / "scene.glb", transfer(obj, contact, np.ones((2, 1))))
    save_object_scene(tmp_path / "object.html", obj)
    assert len(list(tmp_path.iterdir())) == 4


def test_nothing_to_draw_is_an_error(tmp_path):
    with pytest.raises(InputError, match="at least one"):
        save_sheet(tmp_path / "sheet.png", [])
    assert not list(tmp_path.iterdir())


def test_a_path_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "folder.png").mkdir()
    for path, why in [
        (tmp_path / "absent" / "views.png", "no folder"),
        (tmp_path / "views.jpg", r"\.png"),
        (tmp_path / "folder.png", "is a folder"),
    ]:
        with pytest.raises(InputError, match=why) as caught:
            save_views(path, mug())
        assert str(path) in str(caught.value)


def test_a_write_that_fails_leaves_the_old_file_and_no_draft(tmp_path, monkeypatch):
    path = tmp_path / "views.png"
    path.write_bytes(b"old")

    def full_disk(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(InputError, match="No space left"):
        save_views(path, mug())
    assert [p.name for p in tmp_path.iterdir()] == ["views.png"]
    assert path.read_bytes() == b"old"


def test_without_pillow_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "PIL", None)
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[viz\]"):
        save_views(tmp_path / "views.png", mug())
