import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from graft.errors import InputError, InputWarning
from graft.io.mjcf import load_mjcf
from graft.io.urdf import load_urdf

BOX = "<visual><geometry><box size='.2 .4 .6'/></geometry></visual>"

ARM = f"""<?xml version="1.0"?>
<robot name="arm">
  <link name="base"><visual name="slab"><origin xyz="0 0 .3" rpy=".1 .2 .3"/>
    <geometry><box size=".2 .4 .6"/></geometry></visual></link>
  <link name="upper"><visual><geometry><cylinder radius=".1" length="1"/></geometry></visual></link>
  <link name="bare"/>
  <link name="hand"><visual><geometry><sphere radius=".2"/></geometry></visual>
    <collision><geometry><box size="9 9 9"/></geometry></collision></link>
  <link name="slider">{BOX}</link>
  <link name="drone">{BOX}</link>
  <link name="puck">{BOX}</link>
  <link name="wheel">{BOX}</link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="1 2 3" rpy=".3 -.4 .5"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="upper"/><child link="bare"/><origin xyz="0 0 .5"/>
    <axis xyz="0 0 0"/></joint>
  <joint name="wrist" type="continuous"><parent link="bare"/><child link="hand"/>
    <origin xyz=".1 0 0" rpy="0 1 0"/><axis xyz="0 0 2"/></joint>
  <joint name="rail" type="prismatic"><parent link="base"/><child link="slider"/>
    <limit lower="-.1" upper=".2" effort="1" velocity="1"/><mimic joint="wrist"/></joint>
  <joint name="air" type="floating"><parent link="base"/><child link="drone"/></joint>
  <joint name="ice" type="planar"><parent link="base"/><child link="puck"/><axis xyz="0 0 1"/></joint>
  <joint name="spin" type="revolute"><parent link="base"/><child link="wheel"/></joint>
</robot>
"""


def write(folder, text, name="robot.urdf"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def robot(*links, joints=""):
    return f"<robot name='r'>{''.join(links)}{joints}</robot>"


def mesh_link(file, name="a", attributes=""):
    geometry = f"<geometry><mesh filename='{file}' {attributes}/></geometry>"
    return f"<link name='{name}'><visual>{geometry}</visual></link>"


def box_file(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((0.2, 0.4, 0.6)).export(path)
    return path


def frame(xyz=(0, 0, 0), rpy=(0, 0, 0)):
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()  # about fixed axes, as URDF means it
    matrix[:3, 3] = xyz
    return matrix


@pytest.fixture
def arm(tmp_path):
    return load_urdf(write(tmp_path, ARM))


def test_links_stand_where_forward_kinematics_puts_them(arm):
    T_base_upper = frame((1, 2, 3), (0.3, -0.4, 0.5))
    T_base_hand = T_base_upper @ frame((0, 0, 0.5)) @ frame((0.1, 0, 0), (0, 1, 0))
    centers = {p.name: p.vertices.mean(axis=0) for p in arm.parts}
    assert tuple(centers) == ("base", "upper", "hand", "slider", "drone", "puck", "wheel")
    np.testing.assert_allclose(centers["upper"], T_base_upper[:3, 3], atol=1e-12)
    np.testing.assert_allclose(centers["hand"], T_base_hand[:3, 3], atol=1e-12)
    slab = frame((0, 0, 0.3), (0.1, 0.2, 0.3))
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    expected = signs * (0.1, 0.2, 0.3) @ slab[:3, :3].T + slab[:3, 3]
    np.testing.assert_allclose(arm.parts[0].vertices, expected, atol=1e-12)
    top = T_base_upper @ [0, 0, 0.5, 1]
    assert np.linalg.norm(arm.parts[1].vertices - top[:3], axis=1).min() < 1e-12
    assert arm.scale_to_metres == 1.0
    np.testing.assert_array_equal(arm.up, [0, 0, 1])


def test_joints_are_edges(arm):
    joints = {joint.name: joint for joint in arm.joints}
    names = arm.part_names
    assert {n: (names[j.parent], names[j.child], j.kind) for n, j in joints.items()} == {
        "shoulder": ("base", "upper", "hinge"),
        "wrist": ("upper", "hand", "hinge"),  # over the bare link between them
        "rail": ("base", "slider", "slide"),
        "air": ("base", "drone", "free"),
        "ice": ("base", "puck", "planar"),
        "spin": ("base", "wheel", "hinge"),
    }
    T_base_upper = frame((1, 2, 3), (0.3, -0.4, 0.5))
    T_base_hand = T_base_upper @ frame((0, 0, 0.5)) @ frame((0.1, 0, 0), (0, 1, 0))
    np.testing.assert_allclose(joints["shoulder"].axis, T_base_upper[:3, 1], atol=1e-12)
    np.testing.assert_allclose(joints["shoulder"].origin, (1, 2, 3))
    np.testing.assert_allclose(joints["wrist"].axis, T_base_hand[:3, 2], atol=1e-12)
    np.testing.assert_allclose(joints["rail"].axis, (1, 0, 0))
    assert joints["shoulder"].limits == (-1.0, 2.0)
    assert joints["wrist"].limits is None
    assert joints["rail"].limits == (-0.1, 0.2)
    assert joints["air"].axis is None
    assert arm.notes == (
        "joint 'wrist': axis of length 2 normalised",
        "joint 'spin': no <limit>, taken as unlimited",
    )


def test_a_fixed_joint_is_an_edge(tmp_path):
    joint = "<joint name='glue' type='fixed'><parent link='a'/><child link='b'/><origin xyz='0 0 1'/></joint>"
    links = (f"<link name='b'>{BOX}</link>", f"<link name='a'>{BOX}</link>")
    obj = load_urdf(write(tmp_path, robot(*links, joints=joint)))
    assert obj.part_names == ("a", "b")
    assert [(j.name, j.kind, j.parent, j.child) for j in obj.joints] == [("glue", "fixed", 0, 1)]
    np.testing.assert_allclose(obj.joints[0].origin, (0, 0, 1))


def test_one_link_gives_its_visuals(tmp_path):
    cap = "<visual name='cap'><geometry><capsule radius='.1' length='1'/></geometry></visual>"
    path = write(tmp_path, robot(f"<link name='a'>{BOX}{cap}{BOX}</link>"))
    obj = load_urdf(path)
    assert obj.part_names == ("a_box", "cap", "a_box_2")
    assert np.ptp(obj.parts[1].vertices[:, 2]) == pytest.approx(1.2)
    assert load_urdf(path, parts="links").part_names == ("a",)
    assert len(load_urdf(path, parts="links").parts[0].faces) == sum(len(p.faces) for p in obj.parts)


def test_collisions_serve_only_where_there_are_no_visuals(tmp_path):
    obj = load_urdf(write(tmp_path, robot(f"<link name='a'>{BOX.replace('visual', 'collision')}</link>")))
    assert obj.part_names == ("a_box",)
    assert obj.notes == ("no link has a visual: collision geometry was read",)


def test_mesh_scale_and_mirror(tmp_path):
    box_file(tmp_path / "meshes/box.obj")
    (part,) = load_urdf(write(tmp_path, robot(mesh_link("meshes/box.obj", attributes="scale='1 2 -3'")))).parts
    assert part.name == "box"
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), (0.2, 0.8, 1.8))
    mesh = trimesh.Trimesh(part.vertices, part.faces)
    assert mesh.volume == pytest.approx(0.2 * 0.8 * 1.8)  # positive: the faces were flipped back


def test_same_robot_in_urdf_and_mjcf(tmp_path):
    pytest.importorskip("mujoco")
    box_file(tmp_path / "box.stl")
    mesh = "<mesh filename='box.stl' scale='1 -2 1'/>"
    urdf = robot(
        f"""<link name='a'><visual><origin xyz='.1 .2 .3' rpy='.4 .5 .6'/>
        <geometry>{mesh}</geometry></visual></link>""",
        "<link name='b'><visual><geometry><cylinder radius='.1' length='.5'/></geometry></visual></link>",
        joints="""<joint name='j' type='revolute'><parent link='a'/><child link='b'/>
        <origin xyz='1 0 0' rpy='.7 .8 .9'/><axis xyz='0 1 0'/><limit lower='-.5' upper='.5'/></joint>""",
    )
    mjcf = """<mujoco><compiler angle="radian" eulerseq="XYZ"/>
    <asset><mesh name="box" file="box.stl" scale="1 -2 1"/></asset><worldbody><body name="a">
    <geom type="mesh" mesh="box" pos=".1 .2 .3" euler=".4 .5 .6"/>
    <body name="b" pos="1 0 0" euler=".7 .8 .9"><joint name="j" axis="0 1 0" range="-.5 .5"/>
    <geom type="cylinder" size=".1 .25"/></body></body></worldbody></mujoco>"""
    one, two = load_urdf(write(tmp_path, urdf)), load_mjcf(write(tmp_path, mjcf, "robot.xml"))
    assert one.part_names == two.part_names == ("a", "b")
    for a, b in zip(one.parts, two.parts, strict=True):
        corners_a, corners_b = a.vertices[a.faces], b.vertices[b.faces]
        assert len(corners_a) == len(corners_b)
        centers = np.linalg.norm(corners_a.mean(axis=1)[:, None] - corners_b.mean(axis=1), axis=-1)
        nearest = centers.argmin(axis=1)
        np.testing.assert_allclose(centers.min(axis=1), 0, atol=1e-6)
        for mine, other in zip(corners_a, corners_b[nearest], strict=True):
            np.testing.assert_allclose(
                np.cross(mine[1] - mine[0], mine[2] - mine[0]),
                np.cross(other[1] - other[0], other[2] - other[0]),
                atol=1e-6,
            )
    (p,), (q,) = one.joints, two.joints
    np.testing.assert_allclose(p.axis, q.axis, atol=1e-9)
    np.testing.assert_allclose(p.origin, q.origin, atol=1e-9)
    assert (p.kind, p.name, p.limits) == (q.kind, q.name, q.limits)


def test_missing_meshes_are_summed_up(tmp_path):
    links = [mesh_link(f"m{i}.obj", f"l{i}") for i in range(5)]
    joints = "".join(
        f"<joint name='j{i}' type='fixed'><parent link='base'/><child link='l{i}'/></joint>" for i in range(5)
    )
    path = write(tmp_path, robot(f"<link name='base'>{BOX}</link>", *links, joints=joints))
    with pytest.raises(InputError) as caught:
        load_urdf(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: line 1: 5 meshes are missing: m0.obj (tried {tmp_path}/m0.obj); m1.obj")
    assert message.endswith("and 2 more")
    with pytest.warns(InputWarning, match=r"5 meshes are missing and left out: m0.obj, m1.obj, m2.obj and 2 more"):
        obj = load_urdf(path, missing="skip")
    assert obj.part_names == ("base_box",)
    assert obj.notes[0].startswith("5 meshes are missing")
