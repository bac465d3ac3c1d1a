import json

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graft.errors import InputError, InputWarning
from graft.io.partnet import is_partnet, load_partnet

# A cabinet as PartNet-Mobility writes one: the base's joint stands meshes up, visuals bear instances' names.
VISUAL = (
    "<visual name='{0}'><origin xyz='0 0 0'/><geometry><mesh filename='textured_objs/{1}.obj'/></geometry></visual>"
)
CABINET = f"""<?xml version="1.0" ?>
<robot name="partnet_cabinet">
	<link name="base"/>
	<link name="link_0">{VISUAL.format("door_frame-12", "original-1")}
		{VISUAL.format("handle-4", "original-2")}
		{VISUAL.format("handle-4", "original-3")}
		<collision><geometry><mesh filename="textured_objs/original-1.obj"/></geometry></collision></link>
	<joint name="joint_0" type="revolute"><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/><child link="link_0"/>
		<parent link="link_1"/><limit lower="0" upper="1.57"/></joint>
	<link name="link_1">{VISUAL.format("shelf-7", "original-4")}
		{VISUAL.format("frame-8", "original-5")}</link>
	<joint name="joint_1" type="fixed"><origin rpy="1.570796326794897 0 -1.570796326794897" xyz="0 0 0"/>
		<child link="link_1"/><parent link="base"/></joint>
</robot>
"""
PLACES = {  # y up, as the meshes are
    "original-1": (0.4, 1.0, 0.05, 0.0, 0.0, 0.0),
    "original-2": (0.05, 0.2, 0.05, 0.3, 0.0, 0.1),
    "original-3": (0.05, 0.05, 0.05, 0.3, 0.1, 0.1),
    "original-4": (1.0, 0.05, 0.5, 0.0, 0.0, -0.3),
    "original-5": (1.0, 1.0, 0.05, 0.0, 0.0, -0.6),
}


@pytest.fixture
def cabinet(tmp_path):
    folder = tmp_path / "45001"
    (folder / "textured_objs").mkdir(parents=True)
    (folder / "mobility.urdf").write_text(CABINET)
    (folder / "semantics.txt").write_text("link_0 hinge rotation_door\nlink_1 heavy furniture_body\n")
    (folder / "meta.json").write_text(json.dumps({"model_cat": "StorageFurniture", "anno_id": "45001"}))
    for name, (*extents, x, y, z) in PLACES.items():
        mesh = trimesh.creation.box(extents)
        mesh.apply_translation((x, y, z))
        mesh.export(folder / f"textured_objs/{name}.obj")
    return folder


def test_parts_are_instances_of_semantic_parts_on_a_link(cabinet):
    assert is_partnet(cabinet)
    obj = load_partnet(cabinet)
    assert [(p.name, p.label) for p in obj.parts] == [
        ("shelf-7", "shelf"),
        ("frame-8", "frame"),
        ("door_frame-12", "door_frame"),
        ("handle-4", "handle"),
    ]
    assert len(obj.parts[3].faces) == 24  # of both meshes
    assert (obj.name, obj.category, obj.scale_to_metres) == ("45001", "StorageFurniture", None)


def test_the_base_link_turns_it_upright(cabinet):
    obj = load_partnet(cabinet)
    np.testing.assert_array_equal(obj.up, [0, 0, 1])
    low, high = obj.parts[1].vertices.min(axis=0), obj.parts[1].vertices.max(axis=0)
    np.testing.assert_allclose(high - low, (0.05, 1.0, 1.0), atol=1e-9)  # depth, width, height
    np.testing.assert_allclose((high + low) / 2, (0.6, 0.0, 0.0), atol=1e-9)
    # The door hangs .5 to the side: rotated x is -y, as joint_1's yaw has it.
    np.testing.assert_allclose(obj.parts[2].vertices.mean(axis=0), (0.0, -0.5, 0.0), atol=1e-9)


def test_the_hinge_joins_the_parts_that_touch(cabinet):
    (joint,) = load_partnet(cabinet).joints
    obj = load_partnet(cabinet)
    assert (joint.name, joint.kind, joint.limits) == ("joint_0", "hinge", (0.0, 1.57))
    assert (obj.part_names[joint.parent], obj.part_names[joint.child]) == ("shelf-7", "door_frame-12")
    np.testing.assert_allclose(joint.axis, (0, 0, 1), atol=1e-9)
    np.testing.assert_allclose(joint.origin, (0, -0.5, 0), atol=1e-9)


def test_a_name_on_two_links_gets_the_links(cabinet):
    (cabinet / "mobility.urdf").write_text(CABINET.replace("frame-8", "handle-4"))
    assert load_partnet(cabinet).part_names == (
        "shelf-7",
        "link_1/handle-4",
        "door_frame-12",
        "link_0/handle-4",
    )


def test_unnamed_visuals_are_named_by_result_json_or_by_their_link(cabinet):
    text = (cabinet / "mobility.urdf").read_text()
    for name in ("door_frame-12", "handle-4", "shelf-7", "frame-8"):
        text = text.replace(f" name='{name}'", "")
    (cabinet / "mobility.urdf").write_text(text)
    assert [(p.name, p.label) for p in load_partnet(cabinet).parts] == [
        ("furniture_body", "furniture_body"),
        ("rotation_door", "rotation_door"),
    ]
    door = {
        "id": 3,
        "name": "door",
        "objs": ["original-1"],
        "children": [{"id": 4, "name": "knob", "objs": ["original-2"]}],
    }
    (cabinet / "result.json").write_text(json.dumps([door]))
    names = {(p.name, p.label) for p in load_partnet(cabinet).parts}
    assert names == {
        ("furniture_body", "furniture_body"),
        ("knob-4", "knob"),
        ("rotation_door", "rotation_door"),
    }


def test_missing_meshes(cabinet):
    (cabinet / "textured_objs/original-2.obj").unlink()
    (cabinet / "textured_objs/original-4.obj").unlink()
    with pytest.raises(
        InputError, match=r"2 meshes are missing: textured_objs/original-\d.obj \(tried .*textured_objs"
    ):
        load_partnet(cabinet)
    with pytest.warns(InputWarning, match="2 meshes are missing and left out") as caught:
        obj = load_partnet(cabinet, missing="skip")
    assert len(caught) == 1
    assert obj.part_names == ("frame-8", "door_frame-12", "handle-4")


def test_links_unknown_to_the_urdf_are_noted(cabinet):
    (cabinet / "semantics.txt").write_text("link_9 hinge lid\n\n")
    assert load_partnet(cabinet).notes == ("semantics.txt names links that do not exist: link_9",)


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        (
            "semantics.txt",
            "link_0 hinge door\nlink_1 body\n",
            "semantics.txt: line 2: expected link, joint kind and name",
        ),
        ("result.json", "[{", "result.json: line 1: not JSON"),
        ("result.json", "3", "result.json: expected a list of parts, got int"),
        ("result.json", '[{"children": 3}]', "result.json: expected a hierarchy"),
        ("result.json", "[" * 100_000, "result.json"),
        ("meta.json", "[]", "meta.json: expected a JSON object"),
        ("mobility.urdf", "<robot", "mobility.urdf: line 1: not well-formed XML"),
        ("textured_objs/original-3.obj", "v 1 2\n", "original-3.obj"),
    ],
)
def test_bad_files_are_named(cabinet, file, text, complaint):
    (cabinet / file).write_text(text)
    with pytest.raises(InputError, match=complaint):
        load_partnet(cabinet)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    file=st.sampled_from(["mobility.urdf", "semantics.txt", "meta.json", "textured_objs/original-1.obj"]),
    flips=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=4),
    keep=st.one_of(st.just(1.0), st.floats(0, 1)),
)
def test_damaged_folders_load_or_are_refused(cabinet, file, flips, keep):
    whole = (cabinet / file).read_bytes()
    data = bytearray(whole)
    for place, value in flips:
        data[int(place * len(data))] = value
    (cabinet / file).write_bytes(data[: int(keep * len(data))])
    try:
        message = "" if load_partnet(cabinet).parts else "no parts"
    except InputError as error:
        message = str(error)
    finally:
        (cabinet / file).write_bytes(whole)
    assert message == "" or (str(cabinet) in message and "\n" not in message)


def test_another_folder_is_none(tmp_path):
    assert not is_partnet(tmp_path)
    with pytest.raises(InputError, match="no such PartNet-Mobility description"):
        load_partnet(tmp_path)
    with pytest.raises(InputError, match="missing: expected one of error, skip, got 'ignore'"):
        load_partnet(tmp_path, missing="ignore")
