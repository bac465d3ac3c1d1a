"""glTF that cannot be used: one line that names the file and the culprit, and nothing else is raised."""

import base64
import json
import struct

import numpy as np
import pytest
from solids import Box

from graft import InputError, load_object

BOX = Box(size=(0.1, 0.1, 0.1))


def refused(path, match):
    with pytest.raises(InputError, match=match) as caught:
        load_object(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def gltf(**changes):
    positions = BOX.vertices.astype("<f4").tobytes()
    indices = BOX.faces.astype("<u2").tobytes()
    data = positions + indices
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "cup"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
        ],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
    }
    for path, value in changes.items():
        *way, last = [int(step) if step.isdecimal() else step for step in path.split("__")]
        holder = document
        for step in way:
            holder = holder[step]
        holder[last] = value
    return json.dumps(document)


def test_the_gltf_of_these_tests_is_good(tmp_path):
    (tmp_path / "cup.gltf").write_text(gltf())
    assert len(load_object(tmp_path / "cup.gltf").parts[0].faces) == 12


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"accessors__0__count": 10**12}, r"accessor 0: 1000000000000 elements need"),
        ({"accessors__0__bufferView": 7}, r"bufferViews 7: out of range, there are 2"),
        ({"accessors__0": {"componentType": 5126, "count": 10**12, "type": "VEC3"}}, r"and no data"),
        ({"accessors__0__type": "MAT4"}, r"is not geometry"),
        ({"accessors__1__componentType": 5126}, r"elements need"),
        ({"bufferViews__0__byteLength": 10**9}, r"bufferView 0: bytes 0 to 1000000000"),
        ({"buffers__0__byteLength": 10**9}, r"buffer 0: 1000000000 bytes stated, 168 there"),
        ({"buffers__0__uri": "../cup.bin"}, r"'../cup.bin' leaves the folder"),
        ({"buffers__0__uri": "%2e%2e/cup.bin"}, r"leaves the folder"),
        ({"buffers__0__uri": "file:///etc/passwd"}, r"expected a relative path"),
        ({"buffers__0__uri": "cup.bin"}, r"cup.bin: no such buffer"),
        ({"buffers__0__uri": "data:,x"}, r"buffer 0: "),
        ({"images": [{"uri": "/etc/passwd"}]}, r"'/etc/passwd': expected a relative path"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, r"compressed with KHR_draco"),
        ({"nodes__0__children": [0]}, r"node 0: the scene graph is not a tree"),
        ({"nodes__0__rotation": [0, 0, 0, 0]}, r"node 0 rotation: expected a quaternion, got length 0"),
        ({"nodes__0__scale": [0, 0, 0]}, r"none of the 12 faces has an area"),
        ({"nodes__0": {"name": "camera"}}, r"no node of the scene holds a mesh"),
        ({"nodes__0__mesh": "cup"}, r"meshes 'cup': out of range"),
        ({"meshes__0__primitives": 3}, r"malformed GLTF|malformed glTF"),
        ({"meshes__0__primitives__0__mode": 1}, r"no node of the scene holds a mesh"),
        ({"nodes": {}}, r"malformed|out of range"),
    ],
)
def test_gltf_that_lies(tmp_path, changes, match):
    (tmp_path / "cup.gltf").write_text(gltf(**changes))
    with pytest.raises(InputError, match=match) as caught:
        load_object(tmp_path / "cup.gltf")
    assert "cup" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_index_out_of_range_in_gltf(tmp_path):
    data = BOX.vertices.astype("<f4").tobytes() + np.where(BOX.faces == 7, 8, BOX.faces).astype("<u2").tobytes()
    uri = "data:;base64," + base64.b64encode(data).decode()
    (tmp_path / "cup.gltf").write_text(gltf(buffers__0__uri=uri))
    refused(tmp_path / "cup.gltf", r"'cup' face \d+: vertex index out of range")


def test_a_glb_whose_lengths_lie(tmp_path):
    text = gltf().encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text))
    good = head + struct.pack("<II", len(text), 0x4E4F534A) + text
    path = tmp_path / "cup.glb"
    path.write_bytes(good)
    assert load_object(path).part_names == ("cup",)
    path.write_bytes(good[:-1])
    refused(path, r"header says \d+ bytes, the file has \d+")
    path.write_bytes(head + struct.pack("<II", 1 << 30, 0x4E4F534A) + text)
    refused(path, r"a chunk says 1073741824 bytes")
    path.write_bytes(struct.pack("<4sII", b"glTF", 1, 12))
    refused(path, r"version 1 is not read")
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12))
    refused(path, r"no JSON chunk")
    path.write_bytes(b"PK\3\4" * 5)
    refused(path, r"expected a GLB file")
