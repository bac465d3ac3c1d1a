"""Where the files that a robot description names are: relative paths, file:// and package:// addresses.

A description may name files inside its asset root, the folders given as packages, and the packages that the
ROS environment variables lead to; nothing else, whether by `..`, by an absolute path or by a symbolic link.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from graft.errors import InputError

DESCRIPTION_FOLDERS = ("urdf", "mjcf", "xml", "robots")
"""Folders of descriptions by convention: meshes lie beside it, in its parent."""

SHARE_VARIABLES = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "CMAKE_PREFIX_PATH")
"""Installation prefixes of ROS 2 and catkin: packages lie in PREFIX/share/NAME or PREFIX/NAME/share/NAME."""


def asset_root(path: Path) -> Path:
    """Return the folder that the description at `path` may name files in.

    The nearest enclosing folder with a package.xml (a ROS package); else the description's own folder, or
    that one's parent when it is called as in `DESCRIPTION_FOLDERS`.
    """
    folder = path.absolute().parent
    for candidate in (folder, *folder.parents):
        if (candidate / "package.xml").is_file():
            return candidate
    return folder.parent if folder.name in DESCRIPTION_FOLDERS else folder


def is_inside(path: Path, root: Path) -> bool:
    """Tell whether `path` is in `root` once `..` and symbolic links are followed."""
    try:
        return path.resolve().is_relative_to(root.resolve())
    except (OSError, RuntimeError, ValueError):
        return False


@dataclass(frozen=True)
class Lookup:
    """What became of one address: the file, or None, and every path that was tried."""

    file: Path | None
    tried: tuple[Path, ...]


@dataclass(frozen=True)
class AssetPaths:
    """Resolves the addresses in one description.

    Attributes:
        description: The file that holds the addresses.
        packages: Folders of packages by name; they come before everything else.
    """

    description: Path
    packages: Mapping[str, Path] = field(default_factory=dict)

    def find(self, address: str) -> Lookup:
        """Return where `address` leads.

        Raises:
            InputError: It is empty, of an unknown scheme, or leaves the folders that may be read.
        """
        scheme, separator, rest = address.strip().replace("\\", "/").partition("://")
        if not separator:
            scheme, rest = "", scheme
        if not rest.strip():
            raise InputError(f"mesh file: expected a path, got {address!r}")
        if scheme == "package":
            return self._in_package(address, rest)
        if scheme not in ("", "file"):
            raise InputError(f"{address}: expected a path, file:// or package://, got {scheme}://")
        return self._by_path(address, Path(unquote(rest) if scheme == "file" else rest))

    def _by_path(self, address: str, path: Path) -> Lookup:
        root, folder = asset_root(self.description), self.description.absolute().parent
        allowed = [root, *(Path(package) for package in self.packages.values())]
        candidates = list(dict.fromkeys((folder / path, root / path)))
        if not any(is_inside(candidates[0], one) for one in allowed):
            raise InputError(
                f"{address}: leaves the asset root {root}; "
                "name its folder as a package (--package NAME=FOLDER) to allow it"
            )
        return _first(candidate for candidate in candidates if any(is_inside(candidate, one) for one in allowed))

    def _in_package(self, address: str, rest: str) -> Lookup:
        name, _, inner = rest.partition("/")
        if not name or not inner or name in (".", ".."):
            raise InputError(f"{address}: expected package://NAME/PATH")
        given = [Path(self.packages[name])] if name in self.packages else []
        own = [*given, *self._enclosing(name)]
        if any(not is_inside(folder / inner, folder) for folder in own):
            raise InputError(f"{address}: leaves the package {name}")
        # A workspace built with --symlink-install links from its share folder to the sources: in packages of
        # the environment, which the user has sourced, links are followed and only `..` is refused.
        if not Path(os.path.normpath(Path("/package") / inner)).is_relative_to("/package"):
            raise InputError(f"{address}: leaves the package {name}")
        return _first(folder / inner for folder in dict.fromkeys((*own, *ros_package_folders(name))))

    def _enclosing(self, name: str) -> list[Path]:
        """Return the folder called `name` that the description lies in, if any."""
        return [folder for folder in self.description.absolute().parents if folder.name == name][:1]


def ros_package_folders(name: str) -> list[Path]:
    """Return the folders where the ROS environment variables say that package `name` may be, in order."""
    folders: list[Path] = []
    for entry in _entries("ROS_PACKAGE_PATH"):
        folders += [entry, entry / name] if entry.name == name else [entry / name]
    for variable in SHARE_VARIABLES:
        for prefix in _entries(variable):
            folders += [prefix / "share" / name, prefix / name / "share" / name]
    return list(dict.fromkeys(folders))


def _entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _first(candidates: Iterable[Path]) -> Lookup:
    """Return the first of `candidates` that is a file."""
    tried: list[Path] = []
    for candidate in candidates:
        tried.append(candidate)
        try:
            if candidate.is_file():
                return Lookup(candidate, tuple(tried))
        except (OSError, ValueError):  # a name too long for the file system names no file
            continue
    return Lookup(None, tuple(tried))
