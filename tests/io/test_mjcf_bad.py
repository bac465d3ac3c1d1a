import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graft.errors import InputError
from graft.io.mjcf import load_mjcf

pytest.importorskip("mujoco")

GEOM = "<geom size='1'/>"


def world(inner, before=""):
    return f"<mujoco>\n{before}<worldbody>{inner}</worldbody></mujoco>"


def mesh(file, compiler=""):
    return world("<geom type='mesh' mesh='m'/>", f"{compiler}<asset><mesh name='m' file='{file}'/></asset>")


BAD = {
    "truncated": ("<mujoco><worldbody>", "line 1: not well-formed XML"),
    "empty": ("", "is empty"),
    "fragment": (f"<mujocoinclude>{GEOM}</mujocoinclude>", "line 1: is a fragment"),
    "urdf": ("<robot name='r'/>", "line 1: root element: expected <mujoco>, got <robot>"),
    "doctype": ("<!DOCTYPE m [<!ENTITY a 'b'>]>" + world(GEOM), "line 1: a DOCTYPE is refused"),
    "nothing in it": ("<mujoco/>", "expected some geometry, found none"),
    "only a plane": (world("<geom type='plane' size='1 1 1'/>"), "expected some geometry, found none"),
    "unknown element": (world("<gem/>"), "MuJoCo refuses it: .*gem"),
    "zero size": (world("<geom size='0'/>"), "MuJoCo refuses it: .*size 0 must be positive"),
    "nan": (
        world("<geom size='1' pos='nan 0 0'/>"),
        "line 2: <geom> pos: expected finite numbers, got 'nan 0 0'",
    ),
    "infinity": (world("<geom size='1' pos='1e999 0 0'/>"), "MuJoCo refuses it"),
    "reversed range": (
        world(f"<body><joint name='j' range='2 1'/>{GEOM}</body>"),
        "line 2: joint 'j' range: expected lower <= upper, got 2 > 1",
    ),
    "zero quaternion": (world("<geom size='1' quat='0 0 0 0'/>"), "MuJoCo refuses it"),
    "duplicate name": (
        world(f"<body name='a'>{GEOM}</body><body name='a'>{GEOM}</body>"),
        "MuJoCo refuses it: .*a",
    ),
    "missing mesh": (mesh("absent.stl"), "line 2: <mesh> 'absent.stl': no such file"),
    "mesh outside": (mesh("../out.stl"), r"line 2: <mesh> '\.\./out\.stl' .*leaves the asset root"),
    "mesh outside, windows": (mesh("..\\out.stl"), "leaves the asset root"),
    "meshdir outside": (mesh("out.stl", "<compiler meshdir='..'/>"), "leaves the asset root"),
    "assetdir outside": (mesh("out.stl", "<compiler assetdir='../'/>"), "leaves the asset root"),
    "absolute mesh": (mesh("/etc/passwd"), "leaves the asset root"),
    "linked mesh": (mesh("link.stl"), "leaves the asset root"),
    "empty mesh": (mesh("empty.stl"), "is empty"),
    "lying mesh": (mesh("lying.stl"), "MuJoCo refuses it"),
    "include outside": (
        world("<include file='../out.xml'/>"),
        "line 2: <include> '../out.xml' .*leaves the asset root",
    ),
    "include missing": (
        world("<include file='absent.xml'/>"),
        "line 2: <include> 'absent.xml': no such file",
    ),
    "include without file": (world("<include/>"), "line 2: <include>: expected a file"),
    "include itself": (world("<include file='model.xml'/>"), "includes itself: model.xml -> model.xml"),
    "include loop": (
        world("<include file='one.xml'/>"),
        "two.xml: line 1: includes itself: one.xml -> two.xml -> one.xml",
    ),
    "include twice": (
        world("<include file='leaf.xml'/><include file='leaf.xml'/>"),
        "'leaf.xml' is included twice",
    ),
    "attach itself": (
        world(GEOM, "<asset><model name='m' file='model.xml'/></asset>"),
        "attaches itself: 'model.xml'",
    ),
    "attach outside": (
        world(GEOM, "<asset><model name='m' file='../out.xml'/></asset>"),
        "leaves the asset root",
    ),
    "replicate": (
        world(f"<replicate count='1000'><replicate count='1000'>{GEOM}</replicate></replicate>"),
        "line 2: <replicate> makes 1000000 copies, more than the 100000 allowed",
    ),
    "grid": (
        world("<body><flexcomp name='f' type='grid' count='1000 1000 10' spacing='1 1 1'/></body>"),
        "<flexcomp> makes 10000000 copies",
    ),
    "height field": (
        world(GEOM, "<asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>"),
        "<hfield> reserves 10000000000 elements",
    ),
    "user data": (world(GEOM, "<size nuserdata='2000000000'/>"), "<size> reserves 2000000000 elements"),
}


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "out.stl")
    (tmp_path / "out.xml").write_text(world(GEOM))
    (folder / "link.stl").symlink_to(tmp_path / "out.stl")
    (folder / "empty.stl").write_bytes(b"")
    (folder / "lying.stl").write_bytes(bytes(80) + (2**31 - 1).to_bytes(4, "little") + bytes(50))
    (folder / "one.xml").write_text("<mujocoinclude><include file='two.xml'/></mujocoinclude>")
    (folder / "two.xml").write_text("<mujocoinclude><include file='one.xml'/></mujocoinclude>")
    (folder / "leaf.xml").write_text(f"<mujocoinclude>{GEOM}</mujocoinclude>")
    return folder


@pytest.mark.parametrize("name", BAD)
def test_bad_model_is_one_line_with_its_file(folder, name):
    text, complaint = BAD[name]
    path = folder / "model.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=complaint) as caught:
        load_mjcf(path)
    assert str(caught.value).startswith(str(folder))
    assert "\n" not in str(caught.value)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_mjcf(tmp_path / "absent.xml")


WHOLE = world(
    """<geom name="floor" type="plane" size="1 1 1"/>
    <body name="a" pos="0 0 1" euler="1 2 3">
    <joint name="h" type="hinge" axis="0 1 0" range="-1 1"/>
    <geom type="capsule" fromto="0 0 0 1 0 0" size=".1"/>
    <body name="b"><joint type="slide"/><geom type="box" size="1 2 3"/>
    <geom type="mesh" mesh="m"/></body></body>""",
    "<compiler angle='radian'/><asset><mesh name='m' file='m.stl'/></asset>",
).encode()
BOX = trimesh.exchange.stl.export_stl(trimesh.creation.box((1, 1, 1)))
DAMAGE = {
    "flips": st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=4),
    "keep": st.one_of(st.just(1.0), st.floats(0, 1)),
}


def damaged(data, flips, keep):
    damaged = bytearray(data)
    for place, value in flips:
        damaged[int(place * len(data))] = value
    return bytes(damaged[: int(keep * len(data))])


def loads_or_is_refused(path):
    try:
        obj = load_mjcf(path)
    except InputError as error:
        return "\n" not in str(error)
    return len(obj.parts) > 0


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(**DAMAGE)
def test_damaged_models_load_or_are_refused(tmp_path, flips, keep):
    (tmp_path / "m.stl").write_bytes(BOX)
    (tmp_path / "model.xml").write_bytes(damaged(WHOLE, flips, keep))
    assert loads_or_is_refused(tmp_path / "model.xml")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(**DAMAGE)
def test_damaged_meshes_load_or_are_refused(tmp_path, flips, keep):
    (tmp_path / "m.stl").write_bytes(damaged(BOX, flips, keep))
    (tmp_path / "model.xml").write_bytes(WHOLE)
    assert loads_or_is_refused(tmp_path / "model.xml")
