import json

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from solids import volume

from graft import InputWarning, load_object
from graft.io.mesh_file import MESH_SUFFIXES, read_mesh


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply(tmp_path, body, kind):
    (tmp_path / "cup.ply").write_bytes(body.ply(kind))
    obj = load_object(tmp_path / "cup.ply")
    assert obj.name == "cup"
    assert obj.part_names == ("cup",)
    assert_allclose(obj.parts[0].vertices, body.vertices, atol=1e-7)
    assert_array_equal(obj.parts[0].faces, body.faces)
    assert obj.up is None
    assert obj.scale_to_metres is None


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_labels_of_faces_are_parts(tmp_path, body, kind):
    (tmp_path / "cup.ply").write_bytes(body.ply(kind, labels=[0] * 8 + [3] * 4))
    obj = load_object(tmp_path / "cup.ply")
    assert obj.part_names == ("part_0", "part_3")
    assert [len(p.faces) for p in obj.parts] == [8, 4]
    for part, faces in zip(obj.parts, (body.faces[:8], body.faces[8:]), strict=True):
        assert_allclose(part.vertices[part.faces], body.vertices[faces], atol=1e-7)


def test_ply_with_polygons_of_different_sizes(tmp_path):
    text = (
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
        "element face 2\nproperty list uchar int vertex_index\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0.5 0\n4 0 1 2 3\n3 1 4 2\n"
    )
    (tmp_path / "plate.ply").write_text(text)
    [piece] = read_mesh(tmp_path / "plate.ply")
    assert piece.faces.tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 2]]
    head, _, rows = text.partition("end_header\n")
    points = np.array([row.split() for row in rows.splitlines()[:5]], "<f8")
    binary = head.replace("ascii", "binary_little_endian") + "end_header\n"
    data = points.tobytes() + b"\4" + np.arange(4, dtype="<i4").tobytes()
    data += b"\3" + np.array([1, 4, 2], "<i4").tobytes()
    (tmp_path / "binary.ply").write_bytes(binary.encode() + data)
    [same] = read_mesh(tmp_path / "binary.ply")
    assert_array_equal(same.faces, piece.faces)


def test_stl_binary_is_welded(tmp_path, body):
    (tmp_path / "cup.stl").write_bytes(body.stl())
    [part] = load_object(tmp_path / "cup.stl").parts
    assert part.vertices.shape == (8, 3)
    assert part.faces.shape == (12, 3)
    assert volume(part) == pytest.approx(0.08 * 0.08 * 0.1, rel=1e-5)


def test_stl_solids_are_parts(tmp_path, body, handle):
    (tmp_path / "cup.stl").write_text(body.solid("body") + handle.solid("the handle"))
    obj = load_object(tmp_path / "cup.stl")
    assert obj.part_names == ("body", "the handle")
    assert [len(p.vertices) for p in obj.parts] == [8, 8]
    assert volume(obj.parts[1]) == pytest.approx(0.03 * 0.02 * 0.06)


def test_off(tmp_path, body):
    (tmp_path / "cup.off").write_text(body.off())
    [part] = load_object(tmp_path / "cup.off").parts
    assert volume(part) == pytest.approx(0.08 * 0.08 * 0.1)


@pytest.mark.parametrize("keyword", ["o", "g"])
def test_obj_objects_and_groups_are_parts(tmp_path, body, handle, keyword):
    text = "usemtl red\n" + f"{keyword} body\n" + body.obj() + f"{keyword} handle\n" + handle.obj(8)
    (tmp_path / "cup.obj").write_text("mtllib cup.mtl\n" + text)
    obj = load_object(tmp_path / "cup.obj")
    assert obj.part_names == ("body", "handle")
    assert volume(obj.parts[1]) == pytest.approx(0.03 * 0.02 * 0.06)


def test_obj_groups_interleaved_materials_and_indices(tmp_path, body, handle):
    # All vertices first, a group that comes twice, texture and normal numbers, numbers that count backwards.
    rows = [f"v {x} {y} {z}" for x, y, z in np.concatenate([body.vertices, handle.vertices])]
    rows += ["o cup", "g body", "usemtl a"]
    rows += ["f " + " ".join(f"{i + 1}/1/1" for i in q) for q in body.quads[:3]]
    rows += ["g handle", *("f " + " ".join(f"{i - 8}//2" for i in q) for q in handle.quads)]
    rows += ["g body", "usemtl b", *("f " + " ".join(str(i + 1) for i in q) for q in body.quads[3:])]
    (tmp_path / "cup.obj").write_text("\n".join(rows))
    obj = load_object(tmp_path / "cup.obj")
    assert obj.part_names == ("body", "handle")
    assert volume(obj.parts[0]) == pytest.approx(0.08 * 0.08 * 0.1)
    assert volume(obj.parts[1]) == pytest.approx(0.03 * 0.02 * 0.06)


def test_obj_groups_that_share_a_name_are_told_apart_by_their_objects(tmp_path, body, handle):
    text = "o cup\ng shell\n" + body.obj() + "o lid\ng shell\n" + handle.obj(8)
    (tmp_path / "cup.obj").write_text(text)
    assert load_object(tmp_path / "cup.obj").part_names == ("cup_shell", "lid_shell")


def scene_of(body, handle):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.Trimesh(body.vertices, body.faces, process=False), geom_name="body")
    ear = trimesh.Trimesh(handle.vertices, handle.faces, process=False)
    turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    turn[:3, 3] = 0.08, 0.08, 0.0
    scene.add_geometry(ear, geom_name="handle", node_name="right")
    scene.add_geometry(ear, geom_name="handle", node_name="left", transform=turn)
    return scene


def written(scene, folder, suffix):
    if suffix == ".glb":
        scene.export(folder / "cup.glb")
        return folder / "cup.glb"
    for name, data in trimesh.exchange.gltf.export_gltf(scene).items():
        (folder / name).write_bytes(data)
    return folder / "model.gltf"


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_nodes_are_parts_with_their_transforms(tmp_path, body, handle, suffix):
    obj = load_object(written(scene_of(body, handle), tmp_path, suffix))
    assert len(obj.parts) == 3
    assert "body" in obj.part_names
    ears = [p for p in obj.parts if p.name != "body"]
    assert sorted(round(float(p.vertices[:, 0].max()), 6) for p in ears) == [0.0, 0.11]
    assert all(volume(p) == pytest.approx(0.03 * 0.02 * 0.06, rel=1e-4) for p in ears)
    # By its specification: metres, +Y up.
    assert obj.up.tolist() == [0, 1, 0]
    assert obj.scale_to_metres == 1.0


def test_gltf_as_trimesh_reads_it(tmp_path, body, handle):
    path = written(scene_of(body, handle), tmp_path, ".glb")
    mine = np.concatenate([p.vertices for p in load_object(path).parts])
    theirs = trimesh.load_scene(path).to_mesh()
    assert_allclose(mine.min(axis=0), theirs.bounds[0], atol=1e-7)
    assert_allclose(mine.max(axis=0), theirs.bounds[1], atol=1e-7)


def test_a_mirrored_node_keeps_its_outside_outside(tmp_path, body):
    scene = trimesh.Scene()
    mesh = trimesh.Trimesh(body.vertices, body.faces, process=False)
    scene.add_geometry(mesh, geom_name="body", transform=np.diag([-1.0, 1.0, 1.0, 1.0]))
    [part] = load_object(written(scene, tmp_path, ".glb")).parts
    assert volume(part) == pytest.approx(0.08 * 0.08 * 0.1, rel=1e-4)


def test_arguments_override_the_file(tmp_path, body, handle):
    path = written(scene_of(body, handle), tmp_path, ".glb")
    obj = load_object(path, up=(0, 0, 2), scale_to_metres=0.5)
    assert obj.up.tolist() == [0, 0, 1]
    assert obj.scale_to_metres == 0.5


def test_a_folder_with_one_mesh_per_part(tmp_path, body, handle):
    folder = tmp_path / "cup"
    folder.mkdir()
    (folder / "body.ply").write_bytes(body.ply())
    (folder / "handle.stl").write_bytes(handle.stl())
    obj = load_object(folder)
    assert obj.name == "cup"
    assert obj.part_names == ("body", "handle")
    words = {
        "part_names": ["handle", "body"],
        "graspable_parts": [0],
        "up_axis": [0, 0, 1],
        "category": "mug",
    }
    (folder / "object.json").write_text(json.dumps(words))
    obj = load_object(folder)
    assert obj.part_names == ("handle", "body")
    assert obj.graspable == (0,)
    assert obj.category == "mug"


def test_millimetres_are_noticed_and_nothing_is_rescaled(tmp_path, body):
    body.vertices *= 1000
    (tmp_path / "cup.stl").write_bytes(body.stl())
    with pytest.warns(InputWarning, match=r"cup.stl: 151 units across .*millimetres"):
        obj = load_object(tmp_path / "cup.stl")
    assert len(obj.notes) == 1
    assert obj.scale_to_metres is None
    with pytest.warns(InputWarning, match=r"151 m across .*scale_to_metres=0.001"):
        obj = load_object(tmp_path / "cup.stl", scale_to_metres=1.0)
    assert obj.bounds[1, 2] == pytest.approx(100)
    assert load_object(tmp_path / "cup.stl", scale_to_metres=0.001).notes == ()


def test_read_mesh_knows_its_suffixes(tmp_path, body):
    assert set(MESH_SUFFIXES) == {".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl"}
    (tmp_path / "CUP.STL").write_bytes(body.stl())
    [piece] = read_mesh(tmp_path / "CUP.STL")
    assert piece.name == "CUP"
    assert piece.notes == ()
    assert piece.normals is None
