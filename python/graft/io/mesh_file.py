"""One mesh file, whatever its format, as cleaned pieces."""

from __future__ import annotations

from pathlib import Path

from graft.errors import InputError
from graft.io.dae import read_dae
from graft.io.gltf import read_gltf
from graft.io.guards import existing_file, malformed_is_input_error
from graft.io.obj import read_obj
from graft.io.off import read_off
from graft.io.pieces import Piece, RawMesh, cleaned
from graft.io.ply import read_ply
from graft.io.stl import read_stl

MESH_SUFFIXES = (".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl")
"""Of the formats that `read_mesh` knows."""


def read_raw(path: str | Path) -> list[RawMesh]:
    """Read a mesh file as it is, in the file's order of faces; see `read_mesh`."""
    path = existing_file(path, what="mesh file")
    suffix = path.suffix.lower()
    with malformed_is_input_error(path, suffix[1:].upper()):
        if suffix in (".glb", ".gltf"):
            return read_gltf(path).meshes
        if suffix == ".dae":
            return read_dae(path)[0]
        if suffix == ".obj":
            return read_obj(path)
        if suffix == ".off":
            return read_off(path)
        if suffix == ".ply":
            return read_ply(path)
        if suffix == ".stl":
            return read_stl(path)
    raise InputError(f"unknown mesh format {suffix!r}: the known ones are {', '.join(MESH_SUFFIXES)}", path=path)


def read_mesh(path: str | Path) -> list[Piece]:
    """Read a mesh file.

    Args:
        path: A file ending in one of `MESH_SUFFIXES`.

    Returns:
        One piece per node of a glTF or COLLADA scene, object or group of an OBJ file, solid of an STL
        file, else one; at least one. Vertices are in the file's own units (COLLADA: metres) and frame,
        transforms in the file are applied. Names are those of the file, and may repeat.

    Raises:
        InputError: The file is missing, empty, truncated, of unknown format, or not what its header says.
    """
    return cleaned_pieces(read_raw(path), path)


def cleaned_pieces(meshes: list[RawMesh], path: str | Path) -> list[Piece]:
    """Clean meshes of one file.

    Raises:
        InputError: One of them has no usable face or point.
    """
    with malformed_is_input_error(path, "mesh"):
        return [cleaned(mesh) for mesh in meshes]
