import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from solids import volume

from graft import InputError, Joint, Part, PartObject, as_object, load_object, save_object


@pytest.fixture
def cup(body, handle):
    cloud = np.random.default_rng(1).normal(size=(20, 3)) * 0.1
    normals = cloud / np.linalg.norm(cloud, axis=1, keepdims=True)
    return PartObject(
        "my cup",
        (
            Part("body", body.vertices, body.faces, notes=("dropped 1 of 13 faces without area",)),
            Part("handle", handle.vertices, handle.faces, label="ear"),
            Part("steam", cloud, normals=normals),
        ),
        joints=(
            Joint(0, 1, "hinge", "turn", axis=(0, 1, 0), origin=(0.1, 0, 0), limits=(-1.5, np.inf)),
            Joint(0, 2),
        ),
        category="mug",
        up=(0.6, 0.0, 0.8),
        scale_to_metres=0.5,
        graspable=(1,),
        notes=("read from a scan",),
    )


def same(a, b):
    assert (a.name, a.part_names, a.category, a.graspable, a.notes) == (
        b.name,
        b.part_names,
        b.category,
        b.graspable,
        b.notes,
    )
    assert a.scale_to_metres == b.scale_to_metres
    assert_allclose(a.up, b.up, atol=1e-12)
    for p, q in zip(a.parts, b.parts, strict=True):
        assert (p.name, p.label, p.notes) == (q.name, q.label, q.notes)
        assert_array_equal(p.faces, q.faces)
        assert_array_equal(p.vertices.astype(np.float32), q.vertices.astype(np.float32))
        assert (p.normals is None) == (q.normals is None)
        if p.normals is not None:
            assert_allclose(p.normals, q.normals, atol=1e-6)
    for i, j in zip(a.joints, b.joints, strict=True):
        assert (i.parent, i.child, i.kind, i.name, i.limits) == (j.parent, j.child, j.kind, j.name, j.limits)
        for x, y in ((i.axis, j.axis), (i.origin, j.origin)):
            assert (x is None) == (y is None)
            assert x is None or x.tolist() == y.tolist()


def test_glb_keeps_everything(tmp_path, cup):
    save_object(tmp_path / "new" / "cup.glb", cup)
    back = load_object(tmp_path / "new" / "cup.glb")
    same(cup, back)
    assert back.source == str(tmp_path / "new" / "cup.glb")
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["cup.glb"]
    save_object(tmp_path / "again.glb", back)
    same(load_object(tmp_path / "again.glb"), back)


def test_others_see_it_upright_and_in_metres(tmp_path, cup):
    save_object(tmp_path / "cup.glb", cup)
    scene = trimesh.load_scene(tmp_path / "cup.glb")
    transform, geometry = scene.graph["body"]
    seen = trimesh.transform_points(scene.geometry[geometry].vertices, transform)
    heights = cup.parts[0].vertices @ cup.up * cup.scale_to_metres
    assert_allclose(seen[:, 1], heights, atol=1e-7)
    assert_allclose(np.ptp(seen, axis=0).max(), np.abs(seen.max(axis=0) - seen.min(axis=0)).max())
    assert np.linalg.det(transform[:3, :3]) == pytest.approx(0.125)


@pytest.mark.parametrize("up", [None, (0, 1, 0), (0, -1, 0), (0, 0, 1)])
def test_any_up_axis_comes_back(tmp_path, body, up):
    obj = PartObject("cup", (Part("body", body.vertices, body.faces),), up=up)
    save_object(tmp_path / "cup.glb", obj)
    back = load_object(tmp_path / "cup.glb")
    assert (back.up is None) == (up is None)
    assert up is None or back.up.tolist() == list(up)
    assert volume(back.parts[0]) == pytest.approx(0.08 * 0.08 * 0.1, rel=1e-5)


def test_obj_keeps_parts_and_every_bit(tmp_path, cup, handle):
    solid = PartObject("cup", cup.parts[:2])
    save_object(tmp_path / "cup.obj", solid)
    back = load_object(tmp_path / "cup.obj")
    assert back.part_names == ("body", "handle")
    assert_array_equal(back.parts[1].vertices, handle.vertices)
    with pytest.raises(InputError, match="'steam' is a point cloud"):
        save_object(tmp_path / "cup.obj", cup)
    with pytest.raises(InputError, match=r"expected \.glb or \.obj"):
        save_object(tmp_path / "cup.fbx", cup)


def test_a_newer_schema_is_refused(tmp_path, cup):
    save_object(tmp_path / "cup.glb", cup)
    data = (tmp_path / "cup.glb").read_bytes()
    (tmp_path / "cup.glb").write_bytes(data.replace(b'"schema":1', b'"schema":2'))
    with pytest.raises(InputError, match=r"cup.glb: graft schema 2 is not read, 1 is"):
        load_object(tmp_path / "cup.glb")


def test_as_object_takes_what_people_have(tmp_path, body, handle, cup):
    assert as_object(cup) is cup
    save_object(tmp_path / "cup.glb", cup)
    same(as_object(tmp_path / "cup.glb"), cup)
    same(as_object(str(tmp_path / "cup.glb")), cup)
    assert as_object((body.vertices, body.faces)).part_names == ("object",)
    labelled = as_object((body.vertices, body.faces, [2] * 8 + [5] * 4))
    assert labelled.part_names == ("part_2", "part_5")
    assert [len(p.faces) for p in labelled.parts] == [8, 4]
    named = as_object((body.vertices, body.faces, ["rim"] * 2 + ["wall"] * 10))
    assert named.part_names == ("rim", "wall")
    cloud = as_object((body.vertices, None, [0] * 4 + [1] * 4))
    assert all(p.is_point_cloud and len(p.vertices) == 4 for p in cloud.parts)
    mesh = trimesh.Trimesh(handle.vertices, handle.faces, process=False)
    assert_array_equal(as_object(mesh).parts[0].faces, handle.faces)
    moved = np.eye(4)
    moved[2, 3] = 7
    scene = trimesh.Scene()
    scene.add_geometry(mesh, geom_name="handle")
    scene.add_geometry(trimesh.Trimesh(body.vertices, body.faces, process=False), geom_name="body", transform=moved)
    parts = as_object(scene).parts
    assert [p.name for p in parts] == ["handle", "body"]
    assert_allclose(parts[1].vertices, body.vertices + np.array([0, 0, 7]))


@pytest.mark.parametrize(
    ("value", "match"),
    [
        (3, "expected a path, a PartObject, a trimesh.Trimesh or Scene, or .* got int"),
        (trimesh.Scene(), "at least one mesh"),
        (([[0, 0]], [[0, 0, 0]]), r"vertices: expected shape \(v, 3\), got \(1, 2\)"),
        (([[0, 0, 0]], [[0, 0, 1]]), r"face 0: vertex index out of range"),
        (([[0, 0, 0]], [[0.5, 0, 0]]), r"faces: expected integers"),
        ((["a"], [[0, 0, 0]]), r"expected arrays of numbers"),
        ((np.eye(3), [[0, 1, 2]], [1, 2]), r"labels: 2 labels for 1 faces|2 labels for 1 faces"),
        ((np.eye(3), [[0, 1, 2]], [0.5]), r"labels: expected a number or a name"),
        ((np.eye(3) * np.nan, [[0, 1, 2]]), r"none of the 1 faces"),
    ],
)
def test_as_object_refuses(value, match):
    with pytest.raises(InputError, match=match):
        as_object(value)


def test_importing_is_cheap():
    import subprocess
    import sys

    code = "import sys, graft.io; print([m for m in ('trimesh', 'scipy', 'lxml', 'mujoco') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
