"""What every variant must be: closed, outward, connected, of a plausible size."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from mesh_measures import floating_parts

from graft import zoo
from graft.objects import PartObject

SEEDS = range(4)

LONGEST = {
    "water_bucket": (0.28, 0.50),
    "teapot": (0.15, 0.30),
    "wine_bottle": (0.28, 0.36),
    "mug": (0.09, 0.14),
    "detergent": (0.22, 0.33),
    "shampoo": (0.15, 0.27),
    "spray": (0.20, 0.29),
    "kettle": (0.20, 0.30),
    "briefcase": (0.36, 0.48),
    "handbag": (0.25, 0.42),
    "phone": (0.13, 0.17),
    "remote": (0.14, 0.23),
    "pan": (0.28, 0.55),
    "jug": (0.20, 0.30),
    "watering_can": (0.28, 0.48),
    "hammer": (0.25, 0.38),
    "screwdriver": (0.16, 0.29),
    "knife": (0.24, 0.36),
    "scissors": (0.13, 0.26),
    "headphones": (0.17, 0.27),
    "basket": (0.26, 0.46),
    "flashlight": (0.13, 0.26),
}
"""Shortest and longest that the real thing comes, metres."""


@pytest.fixture(scope="module", params=[(c, s) for c in zoo.categories() for s in SEEDS], ids=str)
def variant(request: pytest.FixtureRequest) -> PartObject:
    return zoo.make(*request.param)


def test_every_part_is_closed_and_wound_outwards(variant: PartObject) -> None:
    for part in variant.parts:
        mesh = trimesh.Trimesh(part.vertices, part.faces, process=False)
        assert mesh.is_watertight, part.name
        assert mesh.is_winding_consistent, part.name
        for piece in mesh.split(only_watertight=False):
            assert piece.volume > 0, part.name


def test_no_part_has_flat_faces_or_loose_vertices(variant: PartObject) -> None:
    for part in variant.parts:
        corners = part.vertices[part.faces]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        assert areas.min() > 1e-12, part.name  # a millionth of a square millimetre
        assert len(np.unique(part.faces)) == len(part.vertices), part.name
        assert 500 <= len(part.faces) <= 6000, part.name


def test_parts_are_few_and_hold_together(variant: PartObject) -> None:
    assert 3 <= len(variant.parts) <= 8
    assert not floating_parts(variant, tolerance=0.002)


def test_size_is_that_of_the_thing(variant: PartObject) -> None:
    low, high = LONGEST[str(variant.category)]
    assert low <= np.ptp(variant.bounds, axis=0).max() <= high
    assert variant.scale_to_metres == 1.0
    assert abs(variant.bounds[0, 2]) < 1e-12


def test_graspable_parts_fit_a_gripper(variant: PartObject) -> None:
    assert variant.graspable
    assert len(variant.graspable) < len(variant.parts)
    for index in variant.graspable:
        # A gripper with a stroke of 8 cm can close over some direction of the part's section.
        vertices = variant.parts[index].vertices
        widths = [np.ptp(vertices @ direction) for direction in np.linalg.qr(vertices.T @ vertices)[0].T]
        thinnest = min(*widths, *np.ptp(vertices, axis=0))
        assert thinnest < 0.08, variant.part_names[index]
