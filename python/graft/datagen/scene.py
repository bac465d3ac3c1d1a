"""The scene of an episode as MJCF text: what is simulated is compiled from the text that the episode keeps.

MuJoCo's writer leaves explicit masses out and prints six digits; so the masses are put back, and a run and its replay
both read the text, which makes them alike to the last bit.
"""

from __future__ import annotations

import weakref
from xml.etree import ElementTree as Xml

import numpy as np

from graft.errors import InputError
from graft.grasp import Gripper
from graft.objects import Floats
from graft.sim import SimulationConfig
from graft.sim.compiled import CompiledScene
from graft.sim.scene import FINGER_MASS, GYRATION, Body, scene_spec

BODIES = ("object", "hand", "finger_left", "finger_right")
"""Bodies that a scene has."""


def scene_xml(body: Body, config: SimulationConfig, gripper: Gripper) -> str:
    """Return the MJCF of an object on the table below a hand; it needs no other file."""
    spec = scene_spec(body, config, gripper)
    spec.compile()
    root = Xml.fromstring(spec.to_xml())
    inertia = config.mass * body.unit_inertia
    palm = max(gripper.mass - 2 * FINGER_MASS, FINGER_MASS)
    masses = {"object": (body.center_of_mass, config.mass, inertia)}
    masses |= {
        name: (np.zeros(3), mass, mass * GYRATION**2 * np.eye(3))
        for name, mass in (("hand", palm), ("finger_left", FINGER_MASS), ("finger_right", FINGER_MASS))
    }
    for name, (center, mass, tensor) in masses.items():
        element = root.find(f".//body[@name='{name}']")
        assert element is not None
        for there in element.findall("inertial"):
            element.remove(there)
        entry = Xml.Element("inertial", pos=_text(center), mass=repr(float(mass)), fullinertia=_text(_six(tensor)))
        element.insert(0, entry)
    return Xml.tostring(root, encoding="unicode")


def scene_from_xml(xml: str) -> CompiledScene:
    """Compile the scene of an episode.

    Raises:
        InputError: It is no MJCF, or lacks a body that every scene of graft has.
    """
    try:
        scene = CompiledScene.from_xml(xml)
    except (ValueError, KeyError) as error:
        raise InputError(f"model: {str(error).splitlines()[0]}") from None
    names = {scene.model.body(i).name for i in range(scene.model.nbody)}
    missing = [name for name in BODIES if name not in names]
    if missing or scene.model.nu != 1 or scene.model.nmocap != 1 or scene.model.nq != 16:
        raise InputError(f"model: expected a hand over one object as graft makes it, missing {missing or 'the servo'}")
    return scene


_SCENES: weakref.WeakKeyDictionary[Body, dict[tuple[object, ...], tuple[str, CompiledScene]]] = (
    weakref.WeakKeyDictionary()
)
"""The last scene of each object: attempts on it follow each other."""


def episode_scene(body: Body, config: SimulationConfig, gripper: Gripper) -> tuple[str, CompiledScene]:
    """Return the text and the scene; those of the object's last settings are kept."""
    key = (*config.document().values(),)
    key = (gripper.name, *(tuple(v) if isinstance(v, list) else v for v in key))
    kept = _SCENES.get(body, {})
    if key not in kept:
        xml = scene_xml(body, config, gripper)
        kept = {key: (xml, scene_from_xml(xml))}
        _SCENES[body] = kept
    return kept[key]


def _six(tensor: Floats) -> Floats:
    return np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]])


def _text(numbers: Floats) -> str:
    return " ".join(repr(float(number)) for number in numbers)
