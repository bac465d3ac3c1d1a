import os
import pickle
import struct
from collections import OrderedDict

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from graft.errors import InputError
from graft.evaluate.baselines.torch_file import MAGIC, read_tensors


def spelled(tensors, storages):
    """Return the bytes of a checkpoint as PyTorch before 1.6 wrote it, instruction by instruction.

    `tensors` maps names to (storage key, offset, shape, strides), `storages` keys to arrays.
    """

    def text(value):
        return b"X" + struct.pack("<I", len(value)) + value.encode()

    def integer(value):
        return b"J" + struct.pack("<i", value)

    def numbers(values):
        return b"(" + b"".join(integer(v) for v in values) + b"t"

    state = b"\x80\x02ccollections\nOrderedDict\n)R"
    for name, (key, offset, shape, strides) in tensors.items():
        kind = {"f": b"ctorch\nFloatStorage\n", "i": b"ctorch\nLongStorage\n"}[storages[key].dtype.kind]
        storage = b"(" + text("storage") + kind + text(key) + text("cpu") + integer(len(storages[key])) + b"NtQ"
        hooks = b"ccollections\nOrderedDict\n)R"
        body = storage + integer(offset) + numbers(shape) + numbers(strides) + b"\x89" + hooks
        state += text(name) + b"ctorch._utils\n_rebuild_tensor_v2\n(" + body + b"tRs"
    heads = [pickle.dumps(value, 2) for value in (MAGIC, 1001, {"little_endian": True})]
    data = b"".join(struct.pack("<q", len(array)) + array.tobytes() for array in storages.values())
    return b"".join(heads) + state + b"." + pickle.dumps(list(storages), 2) + data


STORAGES = {"a": np.arange(12, dtype="<f4"), "b": np.array([7], dtype="<i8")}


@pytest.fixture
def written(tmp_path):
    def write(content):
        path = tmp_path / "weights.pth"
        path.write_bytes(content)
        return path

    return write


def test_tensors_are_views_of_their_storages(written):
    tensors = {"plain": ("a", 0, (3, 4), (4, 1)), "turned": ("a", 2, (2, 3), (1, 2)), "count": ("b", 0, (), ())}
    found = read_tensors(written(spelled(tensors, STORAGES)))
    assert list(found) == list(tensors)
    assert_array_equal(found["plain"], np.arange(12).reshape(3, 4))
    assert_array_equal(found["turned"], [[2, 4, 6], [3, 5, 7]])
    assert (found["count"].shape, int(found["count"])) == ((), 7)


class Command:
    def __reduce__(self):
        return os.system, ("exit 1",)


@pytest.mark.parametrize("protocol", [0, 2, 4])
def test_nothing_that_a_file_says_is_called(written, monkeypatch, protocol):
    heads = b"".join(pickle.dumps(value, 2) for value in (MAGIC, 1001, {}))
    evil = pickle.dumps(OrderedDict(weight=Command()), protocol)
    monkeypatch.setattr(os, "system", lambda _: pytest.fail("was called"))
    with pytest.raises(InputError, match="no readable checkpoint"):
        read_tensors(written(heads + evil + pickle.dumps([], 2)))


@pytest.mark.parametrize("reach", [("a", 9, (4,), (1,)), ("a", 0, (2,), (-1,)), ("a", -1, (1,), (1,))])
def test_tensors_beyond_their_storage_are_refused(written, reach):
    with pytest.raises(InputError, match="reaches beyond"):
        read_tensors(written(spelled({"w": reach}, {"a": STORAGES["a"]})))


@pytest.mark.parametrize("cut", [0, 1, 30, 200, -1, -20])
def test_a_file_that_ends_early_is_refused(written, cut):
    whole = spelled({"w": ("a", 0, (12,), (1,)), "n": ("b", 0, (1,), (1,))}, STORAGES)
    with pytest.raises(InputError, match="no readable checkpoint"):
        read_tensors(written(whole[:cut]))


def test_another_format_and_a_missing_file_are_refused(written, tmp_path):
    with pytest.raises(InputError, match="no readable checkpoint"):
        read_tensors(written(b"PK\x03\x04" + bytes(100)))
    with pytest.raises(InputError, match="cannot be read"):
        read_tensors(tmp_path / "none.pth")


def test_huge_tensors_are_refused_before_memory_is_asked_for(written):
    with pytest.raises(InputError, match="reaches beyond"):
        read_tensors(written(spelled({"w": ("a", 0, (2**30, 2**30), (0, 0))}, {"a": STORAGES["a"]})))
