"""Truncated and flipped files either load or raise `InputError`."""

import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from solids import Box

from graft import InputError, InputWarning, load_object, save_object
from graft.objects import Part, PartObject

BOX = Box(size=(0.1, 0.1, 0.1))


def glb(path):
    save_object(path, PartObject("cup", (Part("body", BOX.vertices, BOX.faces),), up=(0, 0, 1)))


def npz(path):
    np.savez_compressed(path, vertices=BOX.vertices, faces=BOX.faces, labels=np.arange(12) // 6)


WRITERS = {
    "binary.ply": lambda path: path.write_bytes(BOX.ply(labels=[0] * 6 + [1] * 6)),
    "ascii.ply": lambda path: path.write_bytes(BOX.ply("ascii")),
    "binary.stl": lambda path: path.write_bytes(BOX.stl()),
    "ascii.stl": lambda path: path.write_text(BOX.solid("cup")),
    "cup.off": lambda path: path.write_text(BOX.off()),
    "cup.obj": lambda path: path.write_text("o body\n" + BOX.obj()),
    "cup.txt": lambda path: path.write_text("\n".join(f"{x} {y} {z} 1" for x, y, z in BOX.vertices)),
    "cup.glb": glb,
    "cup.npz": npz,
}


@pytest.mark.parametrize("name", WRITERS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files(tmp_path, name, data):
    path = tmp_path / name
    WRITERS[name](path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(0, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place] ^= data.draw(st.integers(1, 255))
    path.write_bytes(bytes(content[: data.draw(st.integers(0, len(content)))]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", InputWarning)
        try:
            obj = load_object(path)
        except InputError as error:
            said = str(error)
        else:
            said = name
            assert all(np.isfinite(part.vertices).all() for part in obj.parts)
    assert name in said
    assert "\n" not in said
