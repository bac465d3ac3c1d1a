import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from graft import (
    InputError,
    as_object,
    load_demonstration,
    load_demonstrations,
    load_object,
    mark_contact,
    save_demonstration,
)


@pytest.fixture
def cup(body, handle):
    vertices = np.concatenate([body.vertices, handle.vertices])
    faces = np.concatenate([body.faces, handle.faces + 8])
    return as_object((vertices, faces, ["body"] * 12 + ["handle"] * 12))


@pytest.fixture
def demo(cup):
    return mark_contact(
        cup,
        "handle",
        (0.2, 0.04, 0.05),
        approach=(-1, 0, 0),
        name="my_cup",
        metadata={"task": "pour", "n": 3},
    )


def test_there_and_back(tmp_path, demo):
    save_demonstration(tmp_path / "lib" / "my_cup", demo)
    back = load_demonstration(tmp_path / "lib" / "my_cup")
    assert back.name == "my_cup"
    assert back.metadata == {"task": "pour", "n": 3}
    # The contact stays as it was, to the last bit, although GLB rounds the vertices to float32.
    assert back.contact.point.tolist() == demo.contact.point.tolist()
    assert back.contact.normal.tolist() == [1, 0, 0]
    assert back.contact.part == 1
    assert back.contact.approach.tolist() == [-1, 0, 0]
    assert back.object.part_names == ("body", "handle")
    assert sorted(p.name for p in (tmp_path / "lib").iterdir()) == ["my_cup"]
    assert load_object(tmp_path / "lib" / "my_cup").part_names == ("body", "handle")
    assert [d.name for d in load_demonstrations(tmp_path / "lib" / "my_cup")] == ["my_cup"]


def test_saving_again_replaces_but_never_other_files(tmp_path, demo, cup):
    save_demonstration(tmp_path / "cup", demo)
    save_demonstration(tmp_path / "cup", mark_contact(cup, "body", name="other"))
    assert load_demonstration(tmp_path / "cup").name == "other"
    (tmp_path / "cup" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds other files, nothing is written: notes.txt"):
        save_demonstration(tmp_path / "cup", demo)
    assert load_demonstration(tmp_path / "cup").name == "other"
    assert [p.name for p in tmp_path.iterdir()] == ["cup"]


def test_nothing_is_left_behind_when_saving_fails(tmp_path, demo, monkeypatch):
    save_demonstration(tmp_path / "cup", demo)
    before = (tmp_path / "cup" / "object.glb").read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("graft.io.demonstrations.write_whole", full)
    with pytest.raises(OSError, match="No space"):
        save_demonstration(tmp_path / "cup", demo)
    with pytest.raises(OSError, match="No space"):
        save_demonstration(tmp_path / "new", demo)
    assert [p.name for p in tmp_path.iterdir()] == ["cup"]
    assert (tmp_path / "cup" / "object.glb").read_bytes() == before


def test_metadata_that_do_not_fit_json(tmp_path, cup):
    for value in (float("nan"), object()):
        with pytest.raises(InputError, match="metadata of 'object'"):
            save_demonstration(tmp_path / "cup", mark_contact(cup, "body", metadata={"x": value}))
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def by_hand(tmp_path, body):
    folder = tmp_path / "bucket"
    folder.mkdir()
    (folder / "bucket.ply").write_bytes(body.ply(labels=[0] * 6 + [1] * 6))

    def write(**changes):
        words = {"schema": 1, "object": "bucket.ply", "contact": {"point": [0.04, 0.04, 0.1005]}} | changes
        (folder / "demonstration.json").write_text(json.dumps(words))
        return folder

    return write


def test_by_hand_the_nearest_face_and_part_are_taken(by_hand):
    demo = load_demonstration(by_hand(category="bucket", up=[0, 0, 1], graspable=["part_1"], scale_to_metres=1))
    assert demo.name == "bucket"
    assert_allclose(demo.contact.point, [0.04, 0.04, 0.1], atol=1e-7)
    assert demo.contact.normal.tolist() == [0, 0, 1]
    assert demo.contact.approach is None
    assert demo.object.part_names[demo.contact.part] == "part_1"
    assert demo.object.category == "bucket"
    assert demo.object.graspable == (1,)
    assert demo.object.up.tolist() == [0, 0, 1]
    assert demo.object.scale_to_metres == 1.0


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        (
            {"contact": {"point": [0.04, 0.04, 0.2]}},
            r"not on the object: it is 0.1 away, the object is 0.151 across",
        ),
        (
            {"contact": {"point": [0.04, 0.04, 0.1], "part": "part_0"}},
            r"not on part 'part_0': it is 0.0\d+ away",
        ),
        (
            {"contact": {"point": [0.04, 0.04, 0.1], "part": "lid"}},
            r"no part called 'lid'; the parts are part_0",
        ),
        ({"contact": {"point": [0.04, 0.04, 0.1], "part": []}}, r"contact part: expected a name or number"),
        (
            {"contact": {"point": [0.04, 0.04, 0.1], "normal": [0, 0, 0]}},
            r"contact normal: expected a direction",
        ),
        (
            {"contact": {"point": [0.04, 0.04, 0.1], "normal": "up"}},
            r"contact normal: expected three numbers",
        ),
        ({"contact": {"point": [0.04, 0.04]}}, r"contact point: expected three numbers"),
        ({"contact": {"point": [True, 0, 0]}}, r"contact point: expected three numbers"),
        ({"contact": {"point": [1e308, 1e308, 0]}}, r"contact point: expected three numbers"),
        ({"contact": {"point": [10**400, 0, 0]}}, r"contact point: expected three numbers"),
        ({"contact": {}}, r"contact: expected an object with a point"),
        ({"contact": [1, 2, 3]}, r"contact: expected an object"),
        ({"schema": 2}, r"schema: expected 1, got 2, a newer graft wrote it"),
        ({"schema": True}, r"schema: expected 1, got True"),
        ({"schema": None}, r"schema: expected 1, got None"),
        ({"object": None}, r"object: expected the name"),
        ({"object": 3}, r"object: expected a string"),
        ({"object": "../cup.ply"}, r"'../cup.ply' leaves the folder"),
        ({"object": "/etc/passwd"}, r"expected a relative path"),
        ({"object": "."}, r"inside, got the folder itself"),
        ({"object": "missing.ply"}, r"missing.ply: no such file"),
        ({"up": [1]}, r"up: expected three numbers"),
        ({"scale_to_metres": "1"}, r"scale_to_metres: expected a positive number"),
        ({"scale_to_metres": 10**400}, r"scale_to_metres: expected a positive number"),
        ({"scale_to_metres": 0}, r"scale_to_metres: expected a positive number"),
        ({"graspable": "handle"}, r"graspable: expected a list"),
        ({"graspable": [{}]}, r"graspable: expected names of parts"),
        ({"graspable": [True]}, r"graspable: expected names of parts"),
        ({"graspable": ["lid"]}, r"no part called 'lid'"),
        ({"metadata": []}, r"metadata: expected an object"),
        ({"name": 7}, r"name: expected a string"),
    ],
)
def test_bad_demonstrations(by_hand, changes, match):
    folder = by_hand(**changes)
    with pytest.raises(InputError, match=match) as caught:
        load_demonstration(folder)
    assert "bucket" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_library_names_every_bad_one(tmp_path, demo, by_hand):
    save_demonstration(tmp_path / "a", demo)
    folder = by_hand(schema=9)
    (tmp_path / "notes").mkdir()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / ".hidden" / "demonstration.json").write_text("{")
    with pytest.raises(InputError, match=r"bucket/demonstration.json: schema: expected 1, got 9"):
        load_demonstrations(tmp_path)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "demonstration.json").write_text("{")
    with pytest.raises(InputError, match=r"2 of 3 demonstrations cannot be read: .*broken.*; .*bucket"):
        load_demonstrations(tmp_path)
    (tmp_path / "broken" / "demonstration.json").unlink()
    by_hand()
    assert [d.name for d in load_demonstrations(tmp_path)] == ["my_cup", folder.name]
    with pytest.raises(InputError, match="no such folder"):
        load_demonstrations(tmp_path / "nowhere")
    with pytest.raises(InputError, match="no such demonstration folder"):
        load_demonstration(tmp_path / "nowhere")
