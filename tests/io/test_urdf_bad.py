import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graft.errors import InputError
from graft.io.urdf import load_urdf

SPHERE = "<visual><geometry><sphere radius='1'/></geometry></visual>"


def joint(parent, child, inner="", kind="fixed", name=None):
    name = name or f"{parent}_{child}"
    return f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inner}</joint>"


def links(*names):
    return "\n".join(f"<link name='{name}'>{SPHERE}</link>" for name in names)


def shape(inner):
    return f"<link name='a'><visual><geometry>{inner}</geometry></visual></link>"


AB = links("a", "b")
BAD = {
    "truncated": ("<link name='a'>", "not well-formed XML"),
    "no links": ("", "line 1: expected at least one <link>"),
    "no geometry": ("<link name='a'/>", "expected some geometry, found none"),
    "nameless link": ("<link/>", "line 2: <link>: expected a name"),
    "duplicate link": (links("a", "a"), "line 3: duplicate link name 'a'"),
    "two roots": (AB, "line 3: expected one root link, found 2: a, b"),
    "cycle": (
        links("r", "a", "b", "c") + joint("a", "b") + joint("b", "c") + joint("c", "a"),
        "line 5: joints form a cycle: a -> b -> c -> a",
    ),
    "cycle alone": (AB + joint("a", "b") + joint("b", "a"), "joints form a cycle: a -> b -> a"),
    "own parent": (links("a") + joint("a", "a"), "joints form a cycle: a -> a"),
    "two parents": (
        links("a", "b", "c") + joint("a", "c") + joint("b", "c"),
        "line 4: link 'c' has two parents, joints 'a_c' and 'b_c'",
    ),
    "unknown link": (AB + "\n" + joint("a", "x"), "line 4: joint 'a_x': no link called 'x'"),
    "duplicate joint": (
        links("a", "b", "c") + joint("a", "b", name="j") + joint("a", "c", name="j"),
        "duplicate joint name 'j'",
    ),
    "no parent": (
        AB + "<joint name='j' type='fixed'><child link='b'/></joint>",
        "joint 'j': expected <parent link",
    ),
    "joint type": (AB + joint("a", "b", kind="screw"), "expected one of revolute, .*, got 'screw'"),
    "zero axis": (
        AB + joint("a", "b", "<axis xyz='0 0 0'/>", "continuous"),
        "axis: expected a direction, got the zero",
    ),
    "nan axis": (
        AB + joint("a", "b", "<axis xyz='0 nan 0'/>", "continuous"),
        "axis xyz: expected 3 finite numbers",
    ),
    "short axis": (
        AB + joint("a", "b", "<axis xyz='0 1'/>", "continuous"),
        "expected 3 finite numbers, got '0 1'",
    ),
    "reversed limits": (
        AB + joint("a", "b", "<limit lower='1' upper='-1'/>", "revolute"),
        "limits: expected lower <= upper, got 1 > -1",
    ),
    "infinite limit": (
        AB + joint("a", "b", "<limit upper='inf'/>", "revolute"),
        "limit upper: expected a finite number",
    ),
    "word for a number": (
        AB + joint("a", "b", "<origin xyz='one 0 0'/>"),
        "origin xyz: expected 3 finite numbers",
    ),
    "huge number": (AB + joint("a", "b", "<origin xyz='1e300 0 0'/>"), "origin xyz: beyond 1e\\+09"),
    "zero scale": (
        shape("<mesh filename='m.obj' scale='1 0 1'/>"),
        "line 2: mesh scale: expected three numbers other",
    ),
    "zero box": (shape("<box size='1 0 1'/>"), "box size: expected above zero"),
    "negative radius": (shape("<sphere radius='-1'/>"), "sphere radius: expected above zero, got '-1'"),
    "no length": (shape("<cylinder radius='1'/>"), "cylinder length: expected a finite number, got nothing"),
    "unknown shape": (shape("<cone/>"), "expected box, cylinder, sphere, capsule or mesh, got <cone>"),
    "no shape": (shape(""), "<visual> of link 'a': expected a shape in <geometry>"),
    "no file name": (shape("<mesh/>"), "line 2: mesh file: expected a path"),
    "outside": (shape("<mesh filename='../../m.obj'/>"), "line 2: ../../m.obj: leaves the asset root"),
    "absolute": (shape("<mesh filename='/etc/passwd'/>"), "line 2: /etc/passwd: leaves the asset root"),
    "no package": (
        shape("<mesh filename='package://nope/m.obj'/>"),
        r"1 mesh is missing: .*no folder is known for it",
    ),
    "scheme": (
        shape("<mesh filename='ftp://x/m.obj'/>"),
        "expected a path, file:// or package://, got ftp://",
    ),
    "mesh format": (shape("<mesh filename='r.urdf'/>"), "unknown mesh format '.urdf'"),
    "xacro": (
        "<x:macro xmlns:x='http://www.ros.org/wiki/xacro' name='m'/>" + AB,
        "line 2: holds xacro .*run xacro first",
    ),
    "xacro value": (shape("<box size='${a} 1 1'/>"), "holds xacro .*run xacro first"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_robot_is_one_line_with_file_and_line(tmp_path, monkeypatch, name):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    inner, complaint = BAD[name]
    path = tmp_path / "r.urdf"
    path.write_text(f"<robot name='r'>\n{inner}" + ("" if name == "truncated" else "</robot>"))
    with pytest.raises(InputError, match=complaint) as caught:
        load_urdf(path)
    assert "r.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("", "is empty"),
        ("hello", "not well-formed XML"),
        ("<mujoco/>", "expected <robot>, got <mujoco>"),
        ("<!DOCTYPE r [<!ENTITY a 'aaaa'>]><robot name='r'/>", "DOCTYPE"),
    ],
)
def test_bad_documents(tmp_path, content, complaint):
    path = tmp_path / "r.urdf"
    path.write_text(content)
    with pytest.raises(InputError, match=complaint):
        load_urdf(path)


def test_an_unused_xacro_namespace_is_no_xacro(tmp_path):
    path = tmp_path / "r.urdf"
    path.write_text(f"<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{links('a')}</robot>")
    assert load_urdf(path).part_names == ("a_sphere",)


def test_undeclared_prefixes_are_let_pass_but_nothing_else_is(tmp_path):
    path = tmp_path / "r.urdf"
    text = f"<robot name='r'><drake:joint drake:a='1'/>{links('a')}</robot>"
    path.write_text(text)
    assert load_urdf(path).part_names == ("a_sphere",)
    path.write_text(text[:-5])
    with pytest.raises(InputError, match="not well-formed XML"):
        load_urdf(path)
    path.write_text("<!DOCTYPE robot>" + text)
    with pytest.raises(InputError, match="DOCTYPE"):
        load_urdf(path)
    path.write_text("<robot name='r'><xacro:macro name='m'/></robot>")
    with pytest.raises(InputError, match="run xacro first"):
        load_urdf(path)


def test_a_bad_mesh_is_named(tmp_path):
    path = tmp_path / "r.urdf"
    mesh = shape("<mesh filename='m.obj'/>")
    path.write_text(f"<robot name='r'>{mesh}</robot>")
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    with pytest.raises(InputError, match=r"m\.obj"):
        load_urdf(path)
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    with pytest.raises(InputError, match=r"m\.obj.*expected faces|m\.obj.*points"):
        load_urdf(path)


def test_mesh_coordinates_that_overflow(tmp_path):
    path = tmp_path / "r.urdf"
    mesh = shape("<mesh filename='m.obj' scale='1e9 1 1'/>")
    path.write_text(f"<robot name='r'>{mesh}</robot>")
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1e305 0 0\nv 0 1e305 0\nf 1 2 3\n")
    with pytest.raises(InputError, match="none of the 1 faces has an area and finite corners"):
        load_urdf(path)


WHOLE = (
    "<robot name='r'>\n"
    + links("a", "b", "c")
    + joint(
        "a",
        "b",
        "<origin xyz='1 2 3' rpy='.1 .2 .3'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/>",
        "revolute",
    )
    + joint("b", "c", "<axis xyz='1 0 0'/>", "continuous")
    + "</robot>"
).encode()


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    cut=st.integers(0, len(WHOLE)),
    flips=st.lists(st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(0, 255)), max_size=4),
    truncate=st.booleans(),
)
def test_damaged_files_load_or_are_refused(tmp_path, cut, flips, truncate):
    data = bytearray(WHOLE)
    for place, value in flips:
        data[place] = value
    path = tmp_path / "r.urdf"
    path.write_bytes(bytes(data[:cut]) if truncate else bytes(data))
    try:
        obj = load_urdf(path)
    except InputError as error:
        message = str(error)
    else:
        message = ""
        assert len(obj.parts) >= 1
    assert "\n" not in message
