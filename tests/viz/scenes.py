"""Small transfers to draw: a mug with a handle demonstrates, a kettle with handle and spout receives."""

from types import SimpleNamespace

import numpy as np
import trimesh

from graft.objects import Contact, Demonstration, Part, PartObject


def part(name, mesh):
    return Part(name, mesh.vertices, mesh.faces)


def box(extents, center):
    mesh = trimesh.creation.box(extents=extents)
    mesh.apply_translation(center)
    return mesh


def cylinder(radius, height, center=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.cylinder(radius=radius, height=height)
    mesh.apply_translation(center)
    return mesh


def mug(name="mug"):
    parts = [part("body", cylinder(0.5, 1.0)), part("handle", box((0.1, 0.1, 0.6), (0.75, 0.0, 0.0)))]
    return PartObject(name, tuple(parts), category="mug", up=(0, 0, 1), scale_to_metres=0.1, graspable=(1,))


def kettle(name="kettle", graspable=(1,)):
    parts = [
        part("body", cylinder(0.5, 0.8)),
        part("handle", box((0.8, 0.1, 0.1), (0.0, 0.0, 0.7))),
        part("spout", cylinder(0.08, 0.5, (0.0, 0.6, 0.2))),
    ]
    return PartObject(name, tuple(parts), category="kettle", up=(0, 0, 1), graspable=graspable)


def cloud(n=400, seed=0):
    directions = np.random.default_rng(seed).normal(size=(n, 3))
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    top = unit[:, 2] > 0
    parts = [Part(name, unit[mask], normals=unit[mask]) for name, mask in (("top", top), ("bottom", ~top))]
    return PartObject("ball", tuple(parts))


MUG_CONTACT = Contact((0.8, 0.0, 0.0), (1.0, 0.0, 0.0), 1)
KETTLE_CONTACT = Contact((0.0, 0.0, 0.75), (0.0, 0.0, 1.0), 1)
BALL_CONTACT = Contact((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0)
PLAN = np.array([[0.5, 0.0, 0.1], [0.05, 0.3, 0.05]])


def transfer(target=None, contact=KETTLE_CONTACT, plan=PLAN):
    """What the pictures read of a `TransferredContact`."""
    source = mug()
    match = SimpleNamespace(
        demonstration=Demonstration(source, MUG_CONTACT),
        source=SimpleNamespace(object=source),
        target=SimpleNamespace(object=kettle() if target is None else target),
        transport=SimpleNamespace(plan=plan),
        cost=0.125,
        rank=0,
    )
    return SimpleNamespace(
        contact=contact,
        source_part=1,
        target_part=contact.part,
        transform=np.eye(4),
        confidence=0.8,
        share=0.75,
        match=match,
    )
