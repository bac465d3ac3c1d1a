import numpy as np
import pytest
import trimesh

from graft.io.mjcf import load_mjcf

pytest.importorskip("mujoco")


def write(folder, text, name="model.xml"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def body(geoms, extra=""):
    return f"<mujoco>{extra}<worldbody><body name='thing'>{geoms}</body></worldbody></mujoco>"


def box_file(path, extents=(0.2, 0.4, 0.6), move=(0.0, 0.0, 0.0)):
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh = trimesh.creation.box(extents)
    mesh.apply_translation(move)
    mesh.export(path)


def volume(part):
    return trimesh.Trimesh(part.vertices, part.faces, process=True).volume


def test_a_package_allows_its_folder(tmp_path):
    box_file(tmp_path / "shared/box.stl")
    asset = "<compiler meshdir='../shared'/><asset><mesh name='b' file='box.stl'/></asset>"
    path = write(tmp_path, body("<geom type='mesh' mesh='b'/>", asset), "own/model.xml")
    assert load_mjcf(path, packages={"shared": tmp_path / "shared"}).part_names == ("b",)


def test_meshes_with_meshdir_scale_refpos_and_their_own_frame(tmp_path):
    box_file(tmp_path / "assets/box.stl", move=(1, 2, 3))
    path = write(
        tmp_path,
        body(
            "<geom type='mesh' mesh='box' pos='0 0 1'/>",
            "<compiler meshdir='assets'/><asset><mesh file='box.stl' scale='2 1 -1' refpos='1 0 0'/></asset>",
        ),
    )
    (part,) = load_mjcf(path).parts
    assert part.name == "box"
    corners = np.array([[0.9, 1.8, 2.7], [1.1, 2.2, 3.3]])  # of the file's box
    moved = (corners - [1, 0, 0]) * [2, 1, -1] + [0, 0, 1]  # refpos comes before the scale
    bounds = np.stack([part.vertices.min(axis=0), part.vertices.max(axis=0)])
    np.testing.assert_allclose(bounds, np.sort(moved, axis=0), atol=1e-6)
    assert volume(part) == pytest.approx(0.2 * 0.4 * 0.6 * 2, rel=1e-5)  # mirrored, and still faces outward


def test_strippath_and_assetdir(tmp_path):
    box_file(tmp_path / "assets/box.obj")
    asset = "<compiler assetdir='assets' strippath='true'/><asset><mesh name='b' file='/a/b/box.obj'/></asset>"
    assert load_mjcf(write(tmp_path, body("<geom type='mesh' mesh='b'/>", asset))).part_names == ("b",)


def test_description_folder_may_name_its_neighbours(tmp_path):
    box_file(tmp_path / "meshes/box.stl")
    asset = "<compiler meshdir='../meshes'/><asset><mesh name='b' file='box.stl'/></asset>"
    path = write(tmp_path, body("<geom type='mesh' mesh='b'/>", asset), "mjcf/model.xml")
    assert load_mjcf(path).part_names == ("b",)


def test_includes_are_taken_from_the_main_files_folder(tmp_path):
    write(tmp_path, "<mujocoinclude><include file='sub/inner.xml'/></mujocoinclude>", "sub/outer.xml")
    write(tmp_path, "<mujocoinclude><geom name='inner' size='1'/></mujocoinclude>", "sub/inner.xml")
    path = write(tmp_path, body("<include file='sub/outer.xml'/>"))
    assert load_mjcf(path).part_names == ("inner",)


def test_attached_models_are_read(tmp_path):
    write(tmp_path, body("<geom name='g' size='1'/>"), "other.xml")
    path = write(
        tmp_path,
        """<mujoco><asset><model name="other" file="other.xml"/></asset><worldbody>
        <attach model="other" body="thing" prefix="x_"/></worldbody></mujoco>""",
    )
    assert load_mjcf(path).part_names == ("x_g",)


def test_height_fields_are_left_out_with_a_note(tmp_path):
    field = "<asset><hfield name='h' nrow='3' ncol='3' size='1 1 1 1'/></asset>"
    obj = load_mjcf(write(tmp_path, body("<geom type='hfield' hfield='h'/><geom name='g' size='1'/>", field)))
    assert obj.part_names == ("g",)
    assert obj.notes == ("1 height fields left out: they are terrain",)


def test_signed_distance_shapes_give_the_mesh_that_mujoco_makes_of_them(tmp_path):
    torus = """<extension><plugin plugin="mujoco.sdf.torus"><instance name="t">
    <config key="radius1" value=".35"/><config key="radius2" value=".15"/></instance></plugin></extension>
    <asset><mesh name="t"><plugin instance="t"/></mesh></asset>"""
    obj = load_mjcf(write(tmp_path, body("<geom type='sdf' mesh='t'><plugin instance='t'/></geom>", torus)))
    assert obj.part_names == ("t",)
    np.testing.assert_allclose(obj.bounds, [[-0.5, -0.5, -0.15], [0.5, 0.5, 0.15]], atol=1e-3)


def test_textures_are_not_needed(tmp_path):
    asset = """<asset><texture name="t" type="2d" file="absent.png"/>
    <material name="m" texture="t"/></asset>"""
    assert load_mjcf(write(tmp_path, body("<geom name='g' size='1' material='m'/>", asset))).part_names == ("g",)
