"""Blocks that are demonstrated and blocks that are generated for: their physics is quick."""

from __future__ import annotations

from functools import cache

import numpy as np
import trimesh

from graft.datagen.scripted import demonstrate
from graft.library import Library
from graft.marking import mark_contact
from graft.objects import Demonstration, Part, PartObject


def block(name: str, *size: float) -> PartObject:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation((0, 0, size[2] / 2))
    return PartObject(
        name, (Part("body", mesh.vertices, mesh.faces),), category="block", up=(0, 0, 1), scale_to_metres=1.0
    )


def shown(name: str = "source", *size: float) -> Demonstration:
    size = size or (0.04, 0.05, 0.12)
    return mark_contact(block(name, *size), 0, np.array([0.0, size[1] / 2, 0.9 * size[2]]))


@cache
def demonstration() -> Demonstration:
    return demonstrate(shown())


def library() -> Library:
    made = Library()
    made.add(demonstration())
    return made


def targets() -> list[PartObject]:
    return [block("narrow", 0.03, 0.05, 0.1), block("tall", 0.05, 0.05, 0.16), block("wide", 0.2, 0.2, 0.1)]
