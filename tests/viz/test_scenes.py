"""Pages and models: what is in them, and what they do not ask for."""

import re
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scenes import BALL_CONTACT, KETTLE_CONTACT, cloud, kettle, mug, transfer

from graft.errors import InputError, MissingExtraError
from graft.viz import save_glb, save_object_scene, save_scene
from graft.viz.colors import DEMONSTRATED
from graft.viz.layout import CELL, lay_out, thinned
from graft.viz.meshes import linear
from graft.viz.shapes import Shape, diagonal


def external(html):
    """What a page would fetch: sources, links and imports that are not in the page itself."""
    found = re.findall(r"""(?:src|href|action)\s*=\s*["']?((?:https?:)?//[^"'\s>]+)""", html)
    found += re.findall(r"""@import\s+(?:url\()?["']?((?:https?:)?//[^"')\s]+)""", html)
    return found + re.findall(r"""url\(\s*["']?((?:https?:)?//[^"')\s]+)""", html)


def test_the_check_for_external_resources_finds_them():
    assert external('<script src="https://a.b/c.js">') == ["https://a.b/c.js"]
    assert external("<style>@import '//a.b/c.css'; p { background: url(http://a.b/d.png) }</style>")


def test_a_page_is_one_file_that_asks_for_nothing_and_leaves_no_server(tmp_path, capfd):
    before = threading.active_count()
    save_scene(tmp_path / "scene.html", [transfer(), transfer(cloud(), BALL_CONTACT, np.eye(2))])
    html = (tmp_path / "scene.html").read_text()
    assert external(html) == []
    assert "__VISER_EMBED_DATA__=" in html
    assert len(html) < 3e6
    assert re.findall("<title>.*?</title>", html) == ["<title>graft: kettle, ball</title>"]
    assert [p.name for p in tmp_path.iterdir()] == ["scene.html"]
    assert capfd.readouterr() == ("", "")
    assert threading.active_count() <= before


def test_a_page_of_one_object(tmp_path):
    save_object_scene(tmp_path / "mug.html", mug())
    save_object_scene(tmp_path / "ball.html", cloud())
    for name in ("mug.html", "ball.html"):
        assert external((tmp_path / name).read_text()) == []


def test_a_model_has_named_parts_marks_and_lines(tmp_path):
    save_glb(tmp_path / "scene.glb", [transfer(), transfer(kettle("other"))])
    scene = trimesh.load(tmp_path / "scene.glb")
    nodes = set(scene.graph.nodes_geometry)
    for name in ("00_kettle", "01_other"):
        assert {f"{name}/source/body", f"{name}/source/handle", f"{name}/target/spout"} <= nodes
        assert {f"{name}/{side}/marks/contact" for side in ("source", "target")} <= nodes
        assert f"{name}/link_0" in nodes
    handle = scene.geometry[scene.graph["00_kettle/target/handle"][1]]
    color = np.array(handle.visual.material.baseColorFactor[:3]) / 255
    np.testing.assert_allclose(color, linear(DEMONSTRATED), atol=0.01)
    assert linear((255, 255, 0)) == (1.0, 1.0, 0.0)


def test_a_models_contact_lies_on_the_part_that_it_belongs_to(tmp_path):
    save_glb(tmp_path / "scene.glb", transfer())
    scene = trimesh.load(tmp_path / "scene.glb")

    def mesh(name):
        pose, geometry = scene.graph[f"00_kettle/target/{name}"]
        return scene.geometry[geometry].copy().apply_transform(pose)

    ball = mesh("marks/contact").bounds.mean(axis=0)
    # The contact is the middle of the bar's upper side, and glTF has y up.
    low, high = mesh("handle").bounds
    np.testing.assert_allclose(ball, [(low[0] + high[0]) / 2, high[1], (low[2] + high[2]) / 2], atol=1e-5)


def test_a_layout_stands_on_the_ground_apart_and_right_handed():
    cells = lay_out([transfer() for _ in range(5)])
    boxes = []
    for cell in cells:
        for placed in (cell.source, cell.target):
            points = np.concatenate([s.vertices for s in placed.shapes])
            world = points @ placed.pose[:3, :3].T + placed.pose[:3, 3]
            assert world[:, 2].min() == pytest.approx(0.0, abs=1e-9)
            assert np.linalg.norm(np.ptp(world, axis=0)) < 1.5
            assert np.linalg.det(placed.pose[:3, :3]) > 0
            boxes.append((world.min(axis=0), world.max(axis=0)))
        assert cell.source.centers[:, 0].mean() < cell.target.centers[:, 0].mean()
    for i, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:i]:
            assert (low >= other_high).any() or (high <= other_low).any()
    assert len({cell.name for cell in cells}) == 5
    assert min(CELL) > 1.5


def test_contact_frames_have_z_along_the_normal():
    placed = lay_out([transfer()])[0].target
    assert placed.contact is not None
    np.testing.assert_allclose(placed.contact.point * diagonal(kettle()), KETTLE_CONTACT.point)
    pose = placed.contact_pose(placed.contact)
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 2], [0, 0, 1], atol=1e-12)
    assert pose[2, 3] == pytest.approx(placed.height)


def test_lines_join_what_the_plan_joins():
    plan = np.array([[0.5, 0.0, 0.1], [0.01, 0.3, 0.0]])
    links = lay_out([transfer(plan=plan)])[0].links
    assert [round(link.strength, 3) for link in links] == [0.98, 1.0, 1.0]
    assert lay_out([transfer(plan=np.zeros((2, 3)))])[0].links == []


def test_large_meshes_are_thinned_and_keep_their_form():
    mesh = trimesh.creation.icosphere(subdivisions=5)
    shape = Shape("ball", mesh.vertices, mesh.faces, (0, 0, 0))
    small = thinned([shape], 2000)[0]
    assert 1500 < len(small.faces) <= 2100
    np.testing.assert_allclose(np.linalg.norm(small.vertices, axis=1), 1.0, atol=0.02)
    assert thinned([shape], 10**6)[0] is shape
    points = Shape("points", mesh.vertices, np.empty((0, 3), np.int64), (0, 0, 0), 0.1)
    assert len(thinned([points], 1000)[0].vertices) <= 1000


def test_diagonal_is_that_of_the_bounding_box():
    assert diagonal(mug()) == pytest.approx(np.sqrt(1.3**2 + 1.0**2 + 1.0**2), rel=1e-2)


@pytest.mark.parametrize(("save", "suffix"), [(save_scene, "html"), (save_glb, "glb")])
def test_nothing_to_show_is_an_error(tmp_path, save, suffix):
    with pytest.raises(InputError, match="at least one"):
        save(tmp_path / f"scene.{suffix}", [])
    with pytest.raises(InputError, match="no folder"):
        save(tmp_path / "absent" / f"scene.{suffix}", transfer())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("package", ["viser", "fast_simplification"])
def test_without_a_package_the_extra_is_named(tmp_path, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    ball = trimesh.creation.icosphere(subdivisions=6)
    big = lambda: thinned([Shape("ball", ball.vertices, ball.faces, (0, 0, 0))], 1000)  # noqa: E731
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[viz\]"):
        big() if package == "fast_simplification" else save_scene(tmp_path / "scene.html", transfer())


def test_a_page_is_called_by_its_object_whatever_that_is_called(tmp_path):
    obj = replace(mug(), name="</title><script>alert(1)</script>")
    save_object_scene(tmp_path / "mug.html", obj)
    html = (tmp_path / "mug.html").read_text()
    assert "<title>graft: &lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt;</title>" in html
    assert "<script>alert(1)" not in html
