"""Files that cannot be used: one line that names the file and the culprit, and nothing else is raised."""

import struct
import zipfile

import numpy as np
import pytest
from solids import Box

from graft import InputError, InputWarning, load_object
from graft.io.guards import FREE_ZIP_BYTES, open_zip, parse_xml, read_bytes, read_xml, resolve_inside


def refused(path, match):
    with pytest.raises(InputError, match=match) as caught:
        load_object(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


BOX = Box(size=(0.1, 0.1, 0.1))
PLY = BOX.ply()
STL = BOX.stl()


@pytest.mark.parametrize("suffix", ["glb", "gltf", "obj", "ply", "stl", "off", "txt", "npz", "urdf", "xml"])
def test_empty(tmp_path, suffix):
    (tmp_path / f"cup.{suffix}").touch()
    refused(tmp_path / f"cup.{suffix}", "is empty")


@pytest.mark.parametrize(
    ("name", "content", "match"),
    [
        ("a.stl", STL[:60], r"truncated: 60 bytes"),
        ("a.stl", STL[:-1], r"header says 12 triangles, which need 684 bytes; the file has 683"),
        ("a.stl", BOX.stl(count=4_000_000_000), r"header says 4000000000 triangles"),
        ("a.stl", BOX.stl(count=0), r"header says 0 triangles"),
        ("a.stl", STL[:80] + b"\0" * 4, r"0 triangles"),
        ("a.stl", BOX.solid("cup")[:-20].encode(), r"solid 'cup' is truncated"),
        ("a.stl", b"solid cup\nendsolid cup\n" + b" " * 80, r"0 triangles"),
        (
            "a.stl",
            BOX.solid("cup").replace("vertex 0.0 0.0", "vertex x 0.0", 1).encode(),
            r"not three numbers",
        ),
        ("a.stl", BOX.solid("cup").replace("vertex", "vertx", 1).encode(), r"12 facets but 35 vertices"),
        ("a.ply", PLY[:20], r"no end_header"),
        ("a.ply", PLY[:-1], r"header says 12 of element 'face'; the file has 11"),
        ("a.ply", BOX.ply(count=4_000_000_000), r"header says 4000000000 of element 'face'"),
        ("a.ply", PLY.replace(b"vertex 8", b"vertex 8000000000"), r"8000000000 of element 'vertex'"),
        ("a.ply", BOX.ply("ascii").replace(b"face 12", b"face 13"), r"13 of element 'face'; the file has 12"),
        ("a.ply", BOX.ply("ascii").replace(b"3 0 1 3", b"9 0 1 3"), r"line 19: not a row of element 'face'"),
        ("a.ply", BOX.ply("ascii").replace(b"3 0 1 3", b"3 0 1 8"), r"face 0: vertex index out of range"),
        ("a.ply", BOX.ply("ascii").replace(b"3 0 1 3", b"3 0 1 -1"), r"face 0: vertex index out of range"),
        ("a.ply", BOX.ply("ascii").replace(b"float x", b"quad x"), r"line 5: not a PLY header line"),
        ("a.ply", b"plx", r"begins with ply"),
        ("a.off", BOX.off().encode()[:40], r"header says 8 vertices and 6 faces"),
        ("a.off", BOX.off().replace("8 6 0", "8 99999999999 0").encode(), r"says 8 vertices and 99999999999"),
        ("a.off", BOX.off().replace("4 0 1 3 2", "4 0 1 9 2").encode(), r"face 0: vertex index out of range"),
        ("a.off", BOX.off().replace("4 0 1 3 2", "5 0 1 3 2").encode(), r"line 12: says 5 corners, has 4"),
        ("a.off", b"FOO\n", r"line 1: expected OFF"),
        ("a.obj", BOX.obj().replace("f 1 2", "f 1 99").encode(), r"'a' face 0: vertex index out of range"),
        ("a.obj", BOX.obj().replace("f 1 2", "f 0 2").encode(), r"line 9: vertex number 0"),
        ("a.obj", BOX.obj().replace("f 1 2", "f -9 2").encode(), r"vertex index out of range"),
        ("a.obj", BOX.obj().replace("f 1 2", "f one 2").encode(), r"line 9: expected a face"),
        ("a.obj", BOX.obj().replace("v 0.0", "v zero", 1).encode(), r"line 1: expected a number, got 'zero'"),
        ("a.obj", b"f 1 2\n", r"line 1: expected at least 3 corners"),
        ("a.obj", b"# nothing\n", r"no vertices"),
        ("a.obj", b"mtllib ../../secret.mtl\n" + BOX.obj().encode(), r"'../../secret.mtl' leaves the folder"),
        ("a.obj", b"mtllib /etc/passwd\n" + BOX.obj().encode(), r"'/etc/passwd': expected a relative path"),
        ("a.obj", b"mtllib C:\\a.mtl\n" + BOX.obj().encode(), r"expected a relative path"),
        ("a.urdf", b"<robot><link></robot>", r"line 1: not well-formed XML"),
        ("a.xml", b"<scene/>", r"expected <mujoco> or <robot>, got <scene>"),
        ("a.xml", b'<?xml version="1.0"?>\n<!DOCTYPE r [<!ENTITY a "b">]>\n<robot/>', r"line 2: a DOCTYPE"),
        ("a.xyz", b"\xff\xfe\x00", r"line 1"),
        ("a.step", b"ISO-10303", r"unknown suffix '.step': the known ones are .dae, .glb, .gltf, .obj"),
        ("cup", b"?", r"unknown suffix ''"),
    ],
)
def test_one_line_names_file_and_culprit(tmp_path, name, content, match):
    (tmp_path / name).write_bytes(content)
    refused(tmp_path / name, match)


def test_a_document_type_in_another_encoding():
    text = '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE r><robot/>'
    with pytest.raises(InputError, match=r"DOCTYPE"):
        parse_xml(text.encode("utf-16"), path="a.xml")


def test_xml_keeps_line_numbers(tmp_path):
    (tmp_path / "a.xml").write_text("<robot>\n <link/>\n</robot>")
    assert read_xml(tmp_path / "a.xml")[0].sourceline == 2


def test_missing(tmp_path):
    refused(tmp_path / "cup.glb", "no such file or folder")


def test_a_folder_of_nothing_lists_what_was_looked_for(tmp_path):
    (tmp_path / "README.md").write_text("hello")
    refused(tmp_path, r"nothing to read here; looked for demonstration.json, .*\.urdf|nothing to read here")


def test_duplicate_names_in_a_folder(tmp_path):
    (tmp_path / "handle.ply").write_bytes(PLY)
    (tmp_path / "handle.stl").write_bytes(STL)
    refused(tmp_path, r"duplicate part name 'handle': handle.ply and handle.stl")


def test_names_that_are_not_the_meshes(tmp_path):
    (tmp_path / "handle.ply").write_bytes(PLY)
    (tmp_path / "body.stl").write_bytes(STL)
    (tmp_path / "object.json").write_text('{"part_names": ["body", "lid"]}')
    with pytest.raises(InputError, match=r"object.json: part_names body, lid; the meshes next to it are body, handle"):
        load_object(tmp_path)


def test_links_out_of_the_folder(tmp_path):
    inside = tmp_path / "cup"
    inside.mkdir()
    (tmp_path / "secret.ply").write_bytes(PLY)
    (inside / "body.ply").symlink_to(tmp_path / "secret.ply")
    refused(inside, r"'body.ply' leaves the folder")
    (inside / "body.ply").unlink()
    (inside / "body.ply").write_bytes(PLY)
    (tmp_path / "secret.seg").write_text("0\n" * 12)
    (inside / "body.seg").symlink_to(tmp_path / "secret.seg")
    with pytest.raises(InputError, match=r"'body.seg' leaves the folder"):
        load_object(inside / "body.ply")


def test_nan_and_flat_faces_are_counted_dropped_and_said(tmp_path):
    text = BOX.ply("ascii").replace(b"0.1 0.1 0.1", b"nan 0.1 0.1").replace(b"3 0 1 3", b"3 0 1 1")
    (tmp_path / "cup.ply").write_bytes(text)
    with pytest.warns(InputWarning) as warned:
        obj = load_object(tmp_path / "cup.ply")
    around = int((BOX.faces == 7).any(axis=1).sum())
    assert obj.parts[0].notes == (
        f"dropped {around} of 12 faces with corners that are not finite (1 vertices)",
        "dropped 1 of 12 faces without area",
    )
    assert len(obj.parts[0].faces) == 12 - around - 1
    assert len(warned) == 2
    assert all("cup.ply: part 'cup'" in str(w.message) for w in warned)


def test_nothing_left(tmp_path):
    (tmp_path / "cup.off").write_text("OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n")
    refused(tmp_path / "cup.off", r"none of the 1 faces has an area")


def test_pickles_are_not_loaded(tmp_path):
    (tmp_path / "cup.ply").write_bytes(PLY)
    np.save(tmp_path / "cup.npy", np.array([{}] * 12, object), allow_pickle=True)
    with pytest.raises(InputError, match=r"cup.npy: array 'cup.npy': holds pickled Python objects"):
        load_object(tmp_path / "cup.ply")
    np.savez(tmp_path / "cup.npz", points=np.array([{}], object))
    refused(tmp_path / "cup.npz", r"holds pickled")


def test_arrays_whose_header_lies(tmp_path):
    (tmp_path / "cup.ply").write_bytes(PLY)
    np.save(tmp_path / "cup.npy", np.zeros(12, np.int64))
    data = (tmp_path / "cup.npy").read_bytes()
    (tmp_path / "cup.npy").write_bytes(data.replace(b"(12,)", b"(10**9,)"[:5]))
    with pytest.raises(InputError, match=r"cup.npy"):
        load_object(tmp_path / "cup.ply")
    (tmp_path / "cup.npy").write_bytes(data.replace(b"(12,), }  ", b"(12000000,"[:10]))
    with pytest.raises(InputError, match=r"cup.npy"):
        load_object(tmp_path / "cup.ply")
    (tmp_path / "cup.npy").write_bytes(data.replace(b"(12,), }   ", b"(99999,), }"))
    with pytest.raises(InputError, match=r"shape \(99999,\) of int64 needs 799992 bytes, 96 are there"):
        load_object(tmp_path / "cup.ply")


def test_zip_bombs(tmp_path):
    path = tmp_path / "cup.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", b"\0" * (FREE_ZIP_BYTES + 1))
    assert path.stat().st_size < FREE_ZIP_BYTES // 500
    refused(path, r"unpacks to \d+, more than is safe")
    # An archive whose directory states less than its members hold stops at what it states.
    np.savez_compressed(path, points=np.zeros((1000, 3)))
    data = bytearray(path.read_bytes())
    entry = data.rindex(b"PK\1\2")
    data[entry + 24 : entry + 28] = struct.pack("<I", 100)
    path.write_bytes(bytes(data))
    refused(path, r"'points.npy'")
    path.write_bytes(b"PK\3\4 no archive")
    with pytest.raises(InputError, match=r"not a zip archive"):
        open_zip(path)


def test_size_limit_and_folders(tmp_path):
    (tmp_path / "a").write_bytes(b"12345")
    with pytest.raises(InputError, match=r"has 5 bytes, more than the 4"):
        read_bytes(tmp_path / "a", limit=4)
    with pytest.raises(InputError, match=r"got a folder"):
        read_bytes(tmp_path)


def test_references(tmp_path):
    (tmp_path / "urdf").mkdir()
    found = resolve_inside("..\\meshes\\a.stl", root=tmp_path, base=tmp_path / "urdf", path="a.urdf")
    assert found == (tmp_path / "meshes" / "a.stl").resolve()
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for reference in ("../../a", "", "a\0b", "http://x/a", "//server/a"):
        with pytest.raises(InputError, match=r"a.urdf"):
            resolve_inside(reference, root=tmp_path, base=tmp_path / "urdf", path="a.urdf")


def test_a_choice_of_parts_that_the_format_has_not(tmp_path):
    (tmp_path / "cup.ply").write_bytes(PLY)
    for path, match in ((tmp_path / "cup.ply", r"not for meshes"), (tmp_path, r"neither is here")):
        with pytest.raises(InputError, match=match):
            load_object(path, parts="links")
    (tmp_path / "a.xml").write_text("<mujoco/>")
    with pytest.raises(InputError, match=r"a.xml: parts: MJCF has bodies or geoms, got 'links'"):
        load_object(tmp_path, parts="links")
    (tmp_path / "b.urdf").write_text("<robot/>")
    with pytest.raises(InputError, match=r"b.urdf: parts: URDF has links or visuals, got 'geoms'"):
        load_object(tmp_path / "b.urdf", parts="geoms")
    refused(tmp_path, r"several robot files, name one: a.xml, b.urdf")


def test_several_clouds_in_a_folder(tmp_path):
    for name in ("a.txt", "b.xyz"):
        (tmp_path / name).write_text("0 0 0\n")
    refused(tmp_path, r"several point clouds, name one: a.txt, b.xyz")
