from dataclasses import replace

import numpy as np
import pytest
import trimesh
from motion_scenes import beside, down, mug

from graft.errors import InputError
from graft.grasp import PANDA_HAND, Support
from graft.motion import MotionConfig, plan_motion, plan_motions
from graft.objects import Part, PartObject

OBJECT, TABLE = mug()
LEFT, RIGHT = beside(OBJECT, -1, 0.06), beside(OBJECT, 1, 0.06)


def same(a, b):
    return a.reason == b.reason and a.poses.shape == b.poses.shape and np.array_equal(a.poses, b.poses)


def test_flies_around_the_object():
    motion = plan_motion(OBJECT, LEFT, RIGHT, PANDA_HAND, support=TABLE)
    assert motion.found
    assert motion.iterations > 0
    assert np.array_equal(motion.poses[0], LEFT)
    assert np.array_equal(motion.poses[-1], RIGHT)


def test_an_open_way_is_direct():
    motion = plan_motion(OBJECT, down([0, 0, 0.3]), down([0, 0.2, 0.4]), PANDA_HAND, support=TABLE)
    assert motion.found
    assert motion.iterations == 0
    assert len(motion.poses) == 2


def test_the_same_seed_gives_the_same_motion_alone_or_in_company():
    config = MotionConfig(seed=5)
    ends = [(LEFT, RIGHT), (RIGHT, LEFT), (LEFT, down([0, 0, 0.3]))]
    alone = [plan_motion(OBJECT, a, b, PANDA_HAND, support=TABLE, config=config) for a, b in ends]
    batch = plan_motions(OBJECT, [a for a, _ in ends], [b for _, b in ends], PANDA_HAND, support=TABLE, config=config)
    assert all(same(a, b) for a, b in zip(alone, batch, strict=True))
    other = plan_motion(OBJECT, LEFT, RIGHT, PANDA_HAND, support=TABLE, config=MotionConfig(seed=6))
    assert not same(alone[0], other)


def test_units_of_the_object_do_not_matter():
    inches = replace(OBJECT.transformed(np.diag([32.0, 32.0, 32.0, 1.0])), scale_to_metres=1 / 32)  # exact in floats
    a = plan_motion(OBJECT, LEFT, RIGHT, PANDA_HAND, support=TABLE)
    b = plan_motion(inches, LEFT, RIGHT, PANDA_HAND, support=TABLE)
    assert same(a, b)


@pytest.mark.parametrize(
    ("start", "goal", "what"),
    [
        (down([0.04, 0, 0.05]), RIGHT, "start in collision"),
        (LEFT, down([0.04, 0, 0.05]), "goal in collision"),
        (LEFT, down([0.3, 0, -0.05]), "goal in collision"),
    ],
)
def test_says_which_end_collides(start, goal, what):
    motion = plan_motion(OBJECT, start, goal, PANDA_HAND, support=TABLE)
    assert not motion.found
    assert motion.reason.startswith(what)
    assert motion.poses.shape == (0, 4, 4)
    with pytest.raises(InputError, match=what):
        motion.at([0.0])


def cage():
    """A closed box, 40 cm wide, around the origin."""
    return trimesh.creation.box([0.4, 0.4, 0.4])


def test_gives_up_with_a_reason():
    inside, outside = down([0, 0, -0.05]), down([0, 0, 0.6])
    counted = plan_motion(cage(), inside, outside, PANDA_HAND, config=MotionConfig(max_iterations=30))
    assert counted.reason.startswith("no way found after 30 iterations")
    hurried = MotionConfig(max_iterations=10**9, time_limit=0.02)
    timed = plan_motion(cage(), inside, outside, PANDA_HAND, config=hurried)
    assert timed.reason.startswith("timed out after 0.02 s")


def test_a_narrower_opening_gets_through_where_the_stroke_does_not():
    # Two blocks, 13 cm apart: the open fingers, 8 cm + 2 x 1.5 cm wide, pass; a slot of 10 cm only lets closed ones in.
    wall = [
        trimesh.creation.box([0.4, 0.2, 0.04], trimesh.transformations.translation_matrix([0, y, 0]))
        for y in (-0.15, 0.15)
    ]
    blocks = trimesh.util.concatenate(wall)
    through = down([0, 0, 0.0])
    above = down([0, 0, 0.3])
    assert not plan_motion(blocks, above, through, PANDA_HAND).found
    assert plan_motion(blocks, above, through, PANDA_HAND, opening=0.04).found


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"start": np.full((4, 4), np.nan)}, "start: expected finite"),
        ({"goal": np.diag([2.0, 1.0, 1.0, 1.0])}, "goal: expected a rotation"),
        ({"goal": np.diag([-1.0, 1.0, 1.0, 1.0])}, "goal: expected a rotation"),
        ({"start": np.eye(3)}, "start: expected shape"),
        ({"opening": 0.081}, "opening: expected metres from 0 to the stroke 0.08"),
        ({"opening": float("nan")}, "opening"),
        ({"obj": trimesh.creation.box([90.0, 90.0, 90.0])}, "give scale_to_metres"),
    ],
)
def test_bad_input_is_one_line(change, match):
    arguments = {"obj": OBJECT, "start": LEFT, "goal": RIGHT, "opening": None} | change
    with pytest.raises(InputError, match=match) as error:
        plan_motion(arguments["obj"], arguments["start"], arguments["goal"], PANDA_HAND, opening=arguments["opening"])
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "field", ["clearance", "step", "linear_speed", "goal_bias", "margin", "max_iterations", "time_limit", "seed"]
)
def test_bad_settings_are_refused(field):
    for value in (-1, float("nan")):
        with pytest.raises(InputError, match=field):
            MotionConfig(**{field: value})


def test_clouds_are_in_the_way_too():
    points = OBJECT.parts[0].vertices
    cloud = PartObject("cloud", (Part("points", points),), scale_to_metres=1.0)
    motion = plan_motion(cloud, LEFT, RIGHT, PANDA_HAND, support=TABLE)
    assert motion.found
    assert motion.iterations > 0
    assert "goal in collision" in plan_motion(cloud, LEFT, down([0.04, 0, 0.05]), PANDA_HAND).reason


def test_nothing_goes_below_the_support():
    deep = Support(np.array([0.0, 0.0, 1.0]), 0.0)
    low = np.array([[1.0, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0.02], [0, 0, 0, 1]])  # palm below the fingers
    assert "start in collision" in plan_motion(OBJECT, low, RIGHT, PANDA_HAND, support=deep).reason
    assert plan_motion(OBJECT, low, RIGHT, PANDA_HAND).found
