import os

import pytest

from graft.errors import InputError
from graft.io.packages import SHARE_VARIABLES, AssetPaths, asset_root


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for variable in ("ROS_PACKAGE_PATH", *SHARE_VARIABLES):
        monkeypatch.delenv(variable, raising=False)


def put(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("x")
    return path


def test_asset_root_is_the_package_or_the_folder_or_what_holds_an_urdf_folder(tmp_path):
    assert asset_root(tmp_path / "some/robot.urdf") == tmp_path / "some"
    assert asset_root(tmp_path / "some/urdf/robot.urdf") == tmp_path / "some"
    put(tmp_path / "package.xml")
    assert asset_root(tmp_path / "some/urdf/deep/robot.urdf") == tmp_path


@pytest.mark.parametrize("address", ["m/a.stl", "m\\a.stl", "./m/a.stl", "file://{here}/m/a.stl", "{here}/m/a.stl"])
def test_relative_and_absolute_paths_inside_the_root(tmp_path, address):
    mesh = put(tmp_path / "m/a.stl")
    found = AssetPaths(tmp_path / "r.urdf").find(address.format(here=tmp_path))
    assert found.file is not None
    assert found.file.resolve() == mesh.resolve()


def test_file_addresses_are_percent_decoded(tmp_path):
    put(tmp_path / "my mesh.stl")
    assert AssetPaths(tmp_path / "r.urdf").find(f"file://{tmp_path}/my%20mesh.stl").file is not None


def test_given_package_comes_before_the_enclosing_one_and_before_ros(tmp_path, monkeypatch):
    paths = AssetPaths(tmp_path / "own/pkg/urdf/r.urdf", {"pkg": tmp_path / "given"})
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    tried = paths.find("package://pkg/a.stl").tried
    assert tried == tuple(tmp_path / f for f in ("given/a.stl", "own/pkg/a.stl", "ros/pkg/a.stl"))
    for file in reversed(tried):
        put(file)
        assert paths.find("package://pkg/a.stl").file == file


@pytest.mark.parametrize("variable", SHARE_VARIABLES)
def test_share_folders_of_the_environment(tmp_path, monkeypatch, variable):
    monkeypatch.setenv(variable, os.pathsep.join([str(tmp_path / "empty"), str(tmp_path / "install")]))
    paths = AssetPaths(tmp_path / "r.urdf")
    found = paths.find("package://pkg/a.stl")
    assert found.file is None
    assert [str(path.relative_to(tmp_path)) for path in found.tried] == [
        "empty/share/pkg/a.stl",
        "empty/pkg/share/pkg/a.stl",
        "install/share/pkg/a.stl",
        "install/pkg/share/pkg/a.stl",
    ]
    for file in found.tried[:1:-1]:
        put(file)
        assert paths.find("package://pkg/a.stl").file == file


def test_ros_package_path_may_name_the_package_itself(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src/pkg"))
    mesh = put(tmp_path / "src/pkg/a.stl")
    assert AssetPaths(tmp_path / "r.urdf").find("package://pkg/a.stl").file == mesh


def test_links_of_an_installed_workspace_are_followed(tmp_path, monkeypatch):
    source = put(tmp_path / "src/pkg/a.stl")
    link = tmp_path / "install/share/pkg/a.stl"
    link.parent.mkdir(parents=True)
    link.symlink_to(source)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert AssetPaths(tmp_path / "r.urdf").find("package://pkg/a.stl").file == link


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("../a.stl", "leaves the asset root"),
        ("m/../../a.stl", "leaves the asset root"),
        ("..\\a.stl", "leaves the asset root"),
        ("/etc/passwd", "leaves the asset root"),
        ("file:///etc/passwd", "leaves the asset root"),
        ("link.stl", "leaves the asset root"),
        ("loop.stl", "leaves the asset root"),
        ("package://pkg/../a.stl", "leaves the package pkg"),
        ("package://pkg//etc/passwd", "leaves the package pkg"),
        ("package://pkg/link.stl", "leaves the package pkg"),
        ("package://ros/../../a.stl", "leaves the package ros"),
        ("package://ros//etc/passwd", "leaves the package ros"),
        ("package://../a.stl", "expected package://NAME/PATH"),
        ("package://pkg", "expected package://NAME/PATH"),
        ("http://example.org/a.stl", "got http://"),
        ("", "expected a path"),
        ("file://", "expected a path"),
    ],
)
def test_what_is_refused(tmp_path, monkeypatch, address, complaint):
    outside = put(tmp_path / "a.stl")
    root = tmp_path / "robot"
    root.mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    (root / "link.stl").symlink_to(outside)
    (root / "loop.stl").symlink_to(root / "loop.stl")
    with pytest.raises(InputError, match=complaint):
        AssetPaths(root / "r.urdf", {"pkg": root}).find(address)


def test_a_package_folder_allows_what_a_path_names_in_it(tmp_path):
    mesh = put(tmp_path / "shared/a.stl")
    put(tmp_path / "robot/r.urdf")
    paths = AssetPaths(tmp_path / "robot/r.urdf", {"shared": tmp_path / "shared"})
    found = paths.find("../shared/a.stl").file
    assert found is not None
    assert found.resolve() == mesh


def test_a_name_too_long_for_the_system_is_just_missing(tmp_path):
    assert AssetPaths(tmp_path / "r.urdf").find("a" * 5000).file is None
