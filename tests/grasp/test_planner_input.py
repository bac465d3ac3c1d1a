"""What the planner does with bad input, seeds and threads."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest
from grasp_shapes import UP, ball, block, contact

from graft.errors import InputError
from graft.grasp import AntipodalPlanner, ScoreWeights, plan_grasps
from graft.objects import Part, PartObject

HASH = """
import hashlib, sys
from graft import zoo
from graft.grasp import plan_grasps
demonstration = zoo.demonstration("teapot", 0)
grasps = plan_grasps(demonstration.object, demonstration.contact, seed=3)
assert len(grasps) > 5
arrays = (grasps.poses, grasps.widths, grasps.scores, grasps.contacts, *grasps.terms.values())
print(hashlib.sha256(b"".join(a.tobytes() for a in arrays)).hexdigest(), dict(grasps.rejected))
"""


def test_threads_change_no_bit() -> None:
    answers = {
        subprocess.run(
            [sys.executable, "-c", HASH],
            env={**os.environ, "RAYON_NUM_THREADS": threads},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for threads in ("1", "2", "5")
    }
    assert len(answers) == 1


def test_a_seed_is_kept_and_another_differs() -> None:
    first, again, other = (plan_grasps(ball(), seed=seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first.poses, again.poses)
    assert not np.array_equal(first.poses, other.poses)


def test_terms_are_the_weights_fields_and_make_the_score() -> None:
    grasps = plan_grasps(block(), contact((0.02, 0.0, 0.03), (1.0, 0.0, 0.0)))
    weights = ScoreWeights()
    assert tuple(grasps.terms) == tuple(field.name for field in fields(ScoreWeights))
    logs = np.log(np.maximum(np.array(list(grasps.terms.values())), 1e-3))
    scores = np.exp(np.array(weights.values()) @ logs / sum(weights.values()))
    np.testing.assert_allclose(grasps.scores, scores, rtol=1e-12)


def test_grasps_differ_by_the_spacing() -> None:
    planner = AntipodalPlanner(spacing=0.02, turn=0.5)
    grasps = plan_grasps(ball(), planner=planner, k=50)
    half_turn = np.diag([-1.0, -1.0, 1.0])
    for i, a in enumerate(grasps):
        for b in list(grasps)[:i]:
            turns = [a.pose[:3, :3].T @ b.pose[:3, :3] @ turn for turn in (np.eye(3), half_turn)]
            angle = min(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)) for turn in turns)
            assert angle > 0.5 - 1e-6 or np.linalg.norm(a.pose[:3, 3] - b.pose[:3, 3]) > 0.02 - 1e-9


def test_without_fitting_parts_nothing_is_found() -> None:
    grasps = plan_grasps(ball(0.06), contact((0.0, 0.0, 0.06), UP))
    assert len(grasps) == 0
    assert set(grasps.rejected) <= {"too wide", "no antipode"}


def test_a_contact_off_the_surface_is_named() -> None:
    with pytest.raises(InputError, match="'ball': contact: expected a point within"):
        plan_grasps(ball(), contact((0.0, 0.0, 0.045), UP))


def test_an_object_without_area_is_named() -> None:
    line = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    flat = PartObject("line", (Part("line", line, np.array([[0, 1, 2]])),), scale_to_metres=1.0)
    with pytest.raises(InputError, match="'line': faces: expected a surface of some area"):
        plan_grasps(flat)


def test_an_object_of_the_wrong_unit_is_named() -> None:
    with pytest.raises(InputError, match="diagonal"):
        plan_grasps(ball(30.0))


def test_a_part_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match="no part called 'handle'"):
        plan_grasps(ball(), part="handle")
    with pytest.raises(InputError, match="part index 3 out of range"):
        plan_grasps(ball(), contact((0.0, 0.0, 0.03), UP, part=3))


@pytest.mark.parametrize(
    ("name", "value"),
    [("radius", 0.0), ("friction", -1.0), ("samples", 0), ("margin", float("nan")), ("depths", ()), ("turn", np.inf)],
)
def test_bad_parameters_are_named(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"planner {name}"):
        AntipodalPlanner(**{name: value})


def test_bad_weights_and_counts_are_named() -> None:
    with pytest.raises(InputError, match="weight cone"):
        ScoreWeights(cone=-1.0)
    with pytest.raises(InputError, match="k: expected at least 1"):
        plan_grasps(ball(), k=0)
