"""Zoo demonstrations with their part graphs, built once, and libraries on disk made of them."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from graft import zoo
from graft.graph import build_graph
from graft.library import Library
from graft.marking import mark_contact
from graft.objects import Part, PartObject

TAGS = (["left", "kitchen"], ["kitchen"], [], None)


@pytest.fixture(scope="session")
def pairs():
    """(demonstration, graph) of two objects of every category, with metadata that filters look at."""
    found = []
    for category in zoo.categories():
        for seed in range(2):
            shown = zoo.demonstration(category, seed)
            number = len(found)
            metadata = {"licence": "CC0" if number % 3 else "MIT", "gripper_width": 0.01 * (number % 9)}
            if TAGS[number % 4] is not None:
                metadata["tags"] = TAGS[number % 4]
            shown = replace(shown, name=f"{category}_{seed}", metadata=metadata)
            found.append((shown, build_graph(shown.object)))
    return found


@pytest.fixture(scope="session")
def targets():
    return [build_graph(zoo.make(name, 7)) for name in ("kettle", "handbag", "mug")]


@pytest.fixture(scope="session")
def memory(pairs):
    library = Library()
    library.extend_graphs(*zip(*pairs, strict=True))
    return library


@pytest.fixture(scope="session")
def made(pairs, tmp_path_factory):
    """A library of four segments."""
    path = tmp_path_factory.mktemp("made") / "library"
    library = Library.create(path)
    step = -(-len(pairs) // 4)
    for first in range(0, len(pairs), step):
        library.extend_graphs(*zip(*pairs[first : first + step], strict=True))
    return path


@pytest.fixture
def store(made, tmp_path):
    """A copy of that library."""
    return shutil.copytree(made, tmp_path / "library")


@pytest.fixture
def small(pairs, tmp_path):
    """A library of two objects without samples, in two versions after the empty one: some 60 kB."""
    library = Library.create(tmp_path / "small", samples=False)
    for shown, graph in pairs[:2]:
        library.extend_graphs([shown], [graph])
    return library.path


@pytest.fixture
def tiny(tmp_path):
    """A library of two objects of two tetrahedra each, in two versions after the empty one: 20 kB."""
    library = Library.create(tmp_path / "tiny", samples=False, descriptor=None)
    corners, faces = np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    for name, far in (("near", 1.0), ("far", 2.0)):
        parts = (Part("left", corners, faces), Part("right", 0.5 * corners + np.array([far, 0, 0]), faces))
        library.add(mark_contact(PartObject(name, parts), "right"))
    return library.path
