import json

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from graft import InputError, InputWarning, load_object

# The box is 15 cm across in metres: at 0.5 metres a unit it is still a thing that a hand holds.
WORDS = {
    "id": "cup_7",
    "category": "mug",
    "part_names": ["body", "handle"],
    "graspable_parts": [1],
    "up_axis": [0, 1, 0],
    "scale_to_metres": 0.5,
    "human_agreement": 0.9,
}
LABELS = [0] * 8 + [1] * 4


@pytest.fixture
def folder(tmp_path, body):
    (tmp_path / "mesh.ply").write_bytes(body.ply())
    (tmp_path / "parts.seg").write_text("".join(f"{n}\n" for n in LABELS))
    (tmp_path / "object.json").write_text(json.dumps(WORDS))
    return tmp_path


@pytest.mark.parametrize("whole", [True, False])
def test_a_mesh_with_labels_and_words(folder, body, whole):
    obj = load_object(folder if whole else folder / "mesh.ply", scale_to_metres=1.0)
    assert obj.name == "cup_7"
    assert obj.category == "mug"
    assert obj.graspable == (1,)
    assert obj.part_names == ("body", "handle")
    assert obj.up.tolist() == [0, 1, 0]
    for part, faces in zip(obj.parts, (body.faces[:8], body.faces[8:]), strict=True):
        # Vertices on the border belong to both parts.
        assert_allclose(part.vertices[part.faces], body.vertices[faces], atol=1e-7)


def test_the_scale_is_kept(folder):
    assert load_object(folder, up=(1, 0, 0)).up.tolist() == [1, 0, 0]
    (folder / "object.json").write_text(json.dumps({**WORDS, "scale_to_metres": 0.5}))
    assert load_object(folder).scale_to_metres == 0.5


@pytest.mark.parametrize("suffix", [".seg", ".npy", ".npz"])
def test_label_files(tmp_path, body, suffix):
    (tmp_path / "cup.ply").write_bytes(body.ply())
    (tmp_path / "other.ply").write_bytes(body.ply())
    labels = np.array(LABELS)
    if suffix == ".seg":
        (tmp_path / "cup.seg").write_text("\n".join(map(str, LABELS)))
    elif suffix == ".npy":
        np.save(tmp_path / "cup.npy", labels)
    else:
        np.savez_compressed(tmp_path / "cup.npz", labels=labels.astype(np.uint8), other=labels)
    assert load_object(tmp_path / "cup.ply").part_names == ("part_0", "part_1")
    assert load_object(tmp_path / "other.ply").part_names == ("other",)


def test_labels_of_polygons_and_of_vertices(tmp_path, body):
    (tmp_path / "cup.off").write_text(body.off())
    (tmp_path / "cup.seg").write_text("0\n" * 5 + "1\n")
    assert [len(p.faces) for p in load_object(tmp_path / "cup.off").parts] == [10, 2]
    # A triangle takes the label of two of its corners: the faces round corners 4..7 (x = 1) are part 1.
    (tmp_path / "cup.seg").write_text("0\n" * 4 + "1\n" * 4)
    parts = load_object(tmp_path / "cup.off").parts
    assert sum(len(p.faces) for p in parts) == 12
    assert len(parts[1].faces) == 6


def test_repeated_names_are_numbered_and_keep_their_label(folder):
    (folder / "parts.seg").write_text("0\n" * 4 + "1\n" * 4 + "2\n" * 4)
    (folder / "object.json").write_text(json.dumps({"part_names": ["body", "handle", "handle"]}))
    obj = load_object(folder)
    assert obj.part_names == ("body", "handle", "handle_2")
    assert [p.label for p in obj.parts] == ["body", "handle", "handle"]


def test_a_name_that_no_face_has_is_left_out_and_said(folder):
    words = {
        **WORDS,
        "part_names": ["lid", "body", "handle"],
        "graspable_parts": [0, 2],
        "scale_to_metres": 1,
    }
    (folder / "object.json").write_text(json.dumps(words))
    (folder / "parts.seg").write_text("1\n" * 8 + "2\n" * 4)
    with pytest.warns(InputWarning, match="'lid'"):
        obj = load_object(folder)
    assert obj.part_names == ("body", "handle")
    assert obj.graspable == (1,)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ("0\n" * 11, r"parts.seg: 11 labels for 12 faces"),
        ("0\n" * 11 + "x\n", r"parts.seg: label 12: expected a whole number, got 'x'"),
        ("0\n" * 11 + "1.5\n", r"label 12: expected a whole number, got '1.5'"),
        ("0\n" * 11 + "7\n", r"label 7 has no name: part_names has 2"),
        ("0\n" * 11 + "-1\n", r"label -1 has no name"),
        ("", r"parts.seg: the label file is empty"),
    ],
)
def test_labels_that_do_not_fit(folder, labels, message):
    (folder / "parts.seg").write_text(labels)
    with pytest.raises(InputError, match=message):
        load_object(folder)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("[1, 2]", r"object.json: expected a JSON object, got list"),
        ("{", r"object.json: line 1: not JSON"),
        ('{"scale_to_metres": NaN}', r"NaN is not a JSON number"),
        ({"part_names": "body"}, r"part_names: expected a list of names, got 'body'"),
        ({"part_names": [1, 2]}, r"part_names: expected a list of names"),
        ({"graspable_parts": ["handle"]}, r"graspable_parts: expected a list of part numbers"),
        ({"part_names": ["a", "b"], "graspable_parts": [2]}, r"graspable_parts: part 2 of 2"),
        ({"graspable_parts": [5]}, r"graspable_parts \[5\]: no such part"),
        ({"up_axis": "z"}, r"up_axis: expected three numbers"),
        ({"up_axis": [1e-300, 0, 0]}, r"up_axis: expected three numbers that make a direction"),
        ({"up_axis": [0, 0, 0]}, r"up_axis: expected three numbers"),
        ({"scale_to_metres": "1"}, r"scale_to_metres: expected a positive number"),
        ({"scale_to_metres": -1}, r"scale_to_metres: expected a positive number"),
        ({"category": 3}, r"category: expected a string"),
        ({"id": []}, r"id: expected a string"),
    ],
)
def test_words_of_the_wrong_kind(folder, words, message):
    (folder / "object.json").write_text(words if isinstance(words, str) else json.dumps(words))
    with pytest.raises(InputError, match=message) as caught:
        load_object(folder)
    assert "\n" not in str(caught.value)


CLOUD = np.random.default_rng(0).normal(size=(30, 3)) * 0.1
NORMALS = CLOUD / np.linalg.norm(CLOUD, axis=1, keepdims=True)
POINT_LABELS = np.repeat([4, 9], [10, 20])


@pytest.mark.parametrize("kind", ["x y z label", "x y z normal label", "commas", "ply", "npz", "separate"])
def test_labelled_clouds(tmp_path, kind):
    path = tmp_path / "cup.txt"
    if kind == "x y z label":
        np.savetxt(path, np.c_[CLOUD, POINT_LABELS], header="made for a test")
    elif kind == "x y z normal label":
        np.savetxt(path, np.c_[CLOUD, NORMALS, POINT_LABELS])
    elif kind == "commas":
        np.savetxt(path, np.c_[CLOUD, POINT_LABELS], delimiter=",")
    elif kind == "separate":
        path = tmp_path / "cup.pts"
        np.savetxt(path, CLOUD)
        (tmp_path / "cup.seg").write_text("\n".join(map(str, POINT_LABELS)))
    elif kind == "npz":
        path = tmp_path / "cup.npz"
        np.savez(path, points=CLOUD, normals=NORMALS, labels=POINT_LABELS)
    else:
        path = tmp_path / "cup.ply"
        properties = [
            *(f"property double {n}" for n in ("x", "y", "z", "nx", "ny", "nz")),
            "property int label",
        ]
        head = ["ply", "format ascii 1.0", "element vertex 30", *properties, "end_header\n"]
        rows = "".join(" ".join(map(repr, row)) + "\n" for row in np.c_[CLOUD, NORMALS, POINT_LABELS].tolist())
        path.write_text("\n".join(head) + rows)
    obj = load_object(path)
    assert obj.part_names == ("part_4", "part_9")
    assert all(p.is_point_cloud for p in obj.parts)
    assert_allclose(np.concatenate([p.vertices for p in obj.parts]), CLOUD)
    if kind in ("x y z normal label", "npz", "ply"):
        assert_allclose(np.concatenate([p.normals for p in obj.parts]), NORMALS)
    else:
        assert all(p.normals is None for p in obj.parts)


def test_a_labelled_mesh_as_an_archive(tmp_path, body):
    np.savez(tmp_path / "cup.npz", vertices=body.vertices, faces=body.faces, labels=np.array(LABELS))
    obj = load_object(tmp_path / "cup.npz")
    assert [len(p.faces) for p in obj.parts] == [8, 4]
    assert_array_equal(obj.parts[0].vertices[obj.parts[0].faces], body.vertices[body.faces[:8]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0 0 1\n0 0 1\n", r"cup.txt: line 2: expected 4 numbers, got 3"),
        ("0 0 0 1\n\n0 0 one 1\n", r"line 3: expected a number, got 'one'"),
        ("0 0 0 1.5\n", r"labels: expected whole numbers"),
        ("0 0 0 nan\n", r"labels: expected whole numbers"),
        ("0 0\n", r"line 1: expected at least 3 numbers, got 2"),
        ("0 0 0 0 0\n", r"5 columns: expected 3 \(x y z\)"),
        ("# nothing\n", r"no points"),
        ("nan 0 0\n", r"none of the 1 points is finite"),
    ],
)
def test_tables_that_are_none(tmp_path, text, message):
    (tmp_path / "cup.txt").write_text(text)
    with pytest.raises(InputError, match=message):
        load_object(tmp_path / "cup.txt")


def test_points_that_are_not_finite_are_counted_and_dropped(tmp_path):
    (tmp_path / "cup.txt").write_text("0 0 0 1\nnan 0 0 1\n0 0 1 1\n0 inf 0 1\n")
    with pytest.warns(InputWarning, match="dropped 2 of 4 points that are not finite"):
        obj = load_object(tmp_path / "cup.txt")
    assert len(obj.parts[0].vertices) == 2
    assert obj.parts[0].notes
    assert obj.notes
