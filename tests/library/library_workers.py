"""What processes of the tests run; a module of its own so that they can import it."""

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from graft.errors import InputError
from graft.graph import build_graph
from graft.library import Library
from graft.marking import mark_contact
from graft.objects import Part, PartObject


def tetrahedra(name="pair", far=1.0):
    """Return a demonstration on an object of two tetrahedra, and its graph without descriptors."""
    corners, faces = np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    parts = (Part("left", corners, faces), Part("right", 0.5 * corners + np.array([far, 0, 0]), faces))
    shown = mark_contact(PartObject(name, parts), "right")
    return shown, build_graph(shown.object, descriptor=None)


def append_for_ever(path, acknowledged, prefix):
    """Add three objects at a time; write a line to a file for every commit that returned."""
    library = Library.open(path)
    shown, graph = tetrahedra()
    with Path(acknowledged).open("a") as file:
        for number in range(10**6):
            names = [f"{prefix}-{number}-{i}" for i in range(3)]
            library.extend_graphs([replace(shown, name=name) for name in names], [graph] * 3)
            file.write(" ".join(names) + "\n")
            file.flush()


def append_some(path, prefix, count):
    """Add objects one by one."""
    library = Library.open(path)
    shown, graph = tetrahedra()
    for number in range(count):
        library.extend_graphs([replace(shown, name=f"{prefix}-{number}")], [graph])


def kill_itself(task):
    """Die of the first task of its kind."""
    if task == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    return task * 2


def die_once(task):
    """Die the first time a task is tried."""
    number, folder = task
    mark = Path(folder) / str(number)
    if number % 5 == 0 and not mark.exists():
        mark.touch()
        time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def refuse(task):
    """Raise an error for a user."""
    raise InputError(f"no: {task}")
