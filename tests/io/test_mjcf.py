import builtins

import numpy as np
import pytest

from graft.errors import InputError, MissingExtraError
from graft.io import primitives
from graft.io.mjcf import load_mjcf

mujoco = pytest.importorskip("mujoco")

FRAMES = """
<mujoco>
  <compiler angle="degree" eulerseq="zyx"/>
  <default>
    <geom size=".1 .2 .3" type="box"/>
    <default class="thin"><geom type="capsule" size=".02 .2"/></default>
  </default>
  <worldbody>
    <body name="base" pos="1 2 3" euler="10 20 30">
      <geom name="box"/>
      <body name="arm" pos="0 .3 .5" axisangle="1 1 0 40">
        <joint name="elbow" type="hinge" axis="0 1 1" pos="0 0 .1" range="-90 45" ref="20"/>
        <geom name="rod" class="thin" pos="0 0 .2"/>
        <body name="tip" pos="0 0 .4" xyaxes="0 1 0 -1 0 0">
          <joint name="push" type="slide" axis="1 0 0" range="-.1 .2"/>
          <geom name="round" type="ellipsoid" size=".05 .06 .07" quat="1 2 3 4"/>
        </body>
        <body name="eye" zaxis="1 1 1"><joint name="look" type="ball"/>
          <geom name="ball" type="sphere"/></body>
      </body>
    </body>
    <body name="loose" pos="0 0 5"><freejoint name="fly"/>
      <geom name="tube" type="cylinder" fromto="0 0 0 1 1 1"/></body>
    <geom name="post" pos="3 0 0"/>
    <geom name="floor" type="plane" size="5 5 .1"/>
  </worldbody>
</mujoco>
"""


def write(folder, text, name="model.xml"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def body(geoms, extra=""):
    return f"<mujoco>{extra}<worldbody><body name='thing'>{geoms}</body></worldbody></mujoco>"


@pytest.fixture
def frames(tmp_path):
    return write(tmp_path, FRAMES)


def test_geoms_stand_where_mujoco_puts_them(frames):
    obj = load_mjcf(frames, parts="geoms")
    model = mujoco.MjModel.from_xml_path(str(frames))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    shapes = {
        "box": primitives.box((0.1, 0.2, 0.3)),
        "post": primitives.box((0.1, 0.2, 0.3)),
        "rod": primitives.capsule(0.02, 0.2),
        "round": primitives.ellipsoid((0.05, 0.06, 0.07)),
        "ball": primitives.sphere(0.1),
        "tube": primitives.cylinder(0.1, np.sqrt(3) / 2),
    }
    assert set(obj.part_names) == set(shapes)
    for part in obj.parts:
        geom = data.geom(part.name)
        vertices, faces = shapes[part.name]
        np.testing.assert_allclose(part.vertices, vertices @ geom.xmat.reshape(3, 3).T + geom.xpos, atol=1e-9)
        np.testing.assert_array_equal(part.faces, faces)
    assert obj.scale_to_metres == 1.0
    assert obj.name == "model"
    assert obj.notes == ("1 planes left out: they have no bounded surface",)


def test_bodies_are_parts_when_several_carry_geometry(frames):
    obj = load_mjcf(frames)
    assert obj.part_names == ("world", "base", "arm", "tip", "eye", "loose")


def test_joints_are_edges_with_axis_origin_and_limits_as_mujoco_has_them(frames):
    obj = load_mjcf(frames)
    model = mujoco.MjModel.from_xml_path(str(frames))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    joints = {joint.name: joint for joint in obj.joints}
    ends = {name: (obj.part_names[j.parent], obj.part_names[j.child], j.kind) for name, j in joints.items()}
    assert ends == {
        "": ("world", "base", "fixed"),
        "elbow": ("base", "arm", "hinge"),
        "push": ("arm", "tip", "slide"),
        "look": ("arm", "eye", "ball"),
        "fly": ("world", "loose", "free"),
    }
    for name in ("elbow", "push"):
        np.testing.assert_allclose(joints[name].axis, data.joint(name).xaxis, atol=1e-12)
        np.testing.assert_allclose(joints[name].origin, data.joint(name).xanchor, atol=1e-12)
    np.testing.assert_allclose(joints["elbow"].limits, np.deg2rad([-90, 45]))
    np.testing.assert_allclose(joints["push"].limits, [-0.1, 0.2])
    assert joints["look"].axis is None
    assert joints["fly"].limits is None


def test_angles_in_radians_are_honoured(tmp_path):
    path = write(
        tmp_path,
        """<mujoco><compiler angle="radian"/><worldbody><body name="a"><geom size="1"/>
        <body name="b"><joint range="-1 2"/><geom size="1"/></body></body></worldbody></mujoco>""",
    )
    assert load_mjcf(path).joints[0].limits == (-1.0, 2.0)


def test_several_joints_and_bodies_without_geometry_pass_on(tmp_path):
    path = write(
        tmp_path,
        """<mujoco><worldbody><body name="a"><geom size="1"/>
        <body name="between"><joint name="x" type="slide"/>
        <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><body name="c"><joint name="y" type="slide"/>
        <joint name="z" type="hinge"/><geom size="1"/></body></body></body></worldbody></mujoco>""",
    )
    obj = load_mjcf(path)
    assert obj.part_names == ("a", "c")
    assert [(j.parent, j.child, j.name) for j in obj.joints] == [(0, 1, "x"), (0, 1, "y"), (0, 1, "z")]


def test_a_body_without_geometry_is_stood_for_by_what_is_fixed_to_it(tmp_path):
    path = write(
        tmp_path,
        """<mujoco><worldbody><body name="a"><geom size="1"/><body name="wrist"><joint name="turn"/>
        <body name="finger" pos="1 0 0"><joint name="bend"/><geom size="1"/></body>
        <body name="palm"><geom size="1"/></body><body name="pad"><geom size="1"/></body>
        </body></body></worldbody></mujoco>""",
    )
    obj = load_mjcf(path)
    names = obj.part_names
    assert [(names[j.parent], names[j.child], j.name, j.kind) for j in obj.joints] == [
        ("palm", "finger", "bend", "hinge"),
        ("a", "palm", "turn", "hinge"),
        ("palm", "pad", "", "fixed"),
    ]


def test_warnings_of_mujoco_are_notes(tmp_path):
    path = write(tmp_path, body("<geom size='1'/>", "<compiler settotalmass='1'/>"))
    assert any(note.startswith("MuJoCo warns: ") and "settotalmass" in note for note in load_mjcf(path).notes)


def test_one_body_gives_its_geoms_and_names_repeat_safely(tmp_path):
    obj = load_mjcf(write(tmp_path, body("<geom size='1'/><geom size='2'/><geom name='lid' size='3'/>")))
    assert obj.part_names == ("thing_sphere", "thing_sphere_2", "lid")
    assert obj.joints == ()
    assert load_mjcf(tmp_path / "model.xml", parts="bodies").part_names == ("thing",)


def test_geom_parts_are_joined_where_they_come_closest(tmp_path):
    path = write(
        tmp_path,
        """<mujoco><worldbody><body name="a"><geom name="far" size=".1" pos="-5 0 0"/>
        <geom name="near" size=".1"/>
        <body name="b" pos=".3 0 0"><joint name="h"/><geom name="off" size=".1" pos="5 0 0"/>
        <geom name="by" size=".1"/></body></body></worldbody></mujoco>""",
    )
    obj = load_mjcf(path, parts="geoms")
    (joint,) = obj.joints
    assert (obj.part_names[joint.parent], obj.part_names[joint.child]) == ("near", "by")


def test_up_is_against_gravity(tmp_path):
    path = write(tmp_path, body("<geom size='1'/>", "<option gravity='0 -9.81 0'/>"))
    np.testing.assert_array_equal(load_mjcf(path).up, [0, 1, 0])
    path = write(tmp_path, body("<geom size='1'/>", "<option gravity='0 0 0'/>"))
    np.testing.assert_array_equal(load_mjcf(path).up, [0, 0, 1])


@pytest.mark.parametrize(
    ("geoms", "kept"),
    [
        # menagerie: visuals in group 2 without contact, collisions in group 3
        (
            "<geom name='v' size='1' group='2' contype='0' conaffinity='0'/><geom name='c' size='1' group='3'/>",
            "v",
        ),
        # robosuite: collisions in group 0, visuals in group 1
        ("<geom name='c' size='1'/><geom name='v' size='1' group='1' contype='0' conaffinity='0'/>", "v"),
        # collision geometry alone is all there is
        ("<geom name='c' size='1' group='3'/>", "c"),
        # a mark in the same group is no replacement for the body
        ("<geom name='b' size='1'/><geom name='m' size='1' contype='0' conaffinity='0'/>", "bm"),
    ],
)
def test_visual_geoms_are_preferred(tmp_path, geoms, kept):
    obj = load_mjcf(write(tmp_path, body(geoms)))
    assert obj.part_names == tuple(kept)
    left_out = geoms.count("<geom") - len(kept)
    assert len(obj.notes) == (left_out > 0)
    assert all(note.startswith(f"{left_out} collision geoms") for note in obj.notes)


def test_without_mujoco_the_extra_is_named(frames, monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name == "mujoco":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[sim\]"):
        load_mjcf(frames)


def test_unknown_choice_of_parts(frames):
    with pytest.raises(InputError, match="expected one of auto, bodies, geoms, got 'links'"):
        load_mjcf(frames, parts="links")
