"""The Panda of primitives, and arms of users, against MuJoCo."""

import numpy as np
import pytest

from graft import zoo
from graft.errors import InputError
from graft.grasp import PANDA_HAND, Grasp, Support, in_metres
from graft.motion import MotionConfig
from graft.motion.joints import clear_joints, plan_joints, world_around

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("mink")

from graft.sim.arm import IkConfig, load_arm, panda_arm, plan_arm, solve_ik  # noqa: E402
from graft.sim.arm_approach import plan_arm_approach  # noqa: E402

ARM = panda_arm()
TABLE = Support(np.array([0.0, 0.0, 1.0]), 0.0)
NOTHING = world_around(None, np.eye(4), None)

ODD = """
<mujoco><compiler angle="radian"/><worldbody>
  <body name="foot" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1"><geom type="box" size=".1 .1 .1"/>
    <body name="twice" pos="0 0 0.2" euler="0.1 0 0.4">
      <joint name="a" axis="1 0 0" pos="0.05 0 0.02" ref="0.4" range="-1 1"/>
      <joint name="b" axis="0 0.6 0.8" pos="0 0.1 0" range="-2 2"/>
      <geom type="capsule" size=".03 .1"/>
      <body name="slider" pos="0.3 0 0"><joint name="c" type="slide" axis="0 1 0" ref="0.05" range="-0.1 0.2"/>
        <geom type="sphere" size=".05"/><site name="tool" pos="0 0 0.1"/>
      </body></body></body>
</worldbody></mujoco>"""


def site_pose(arm, joints):
    data = mujoco.MjData(arm.model)
    data.qpos[:] = joints
    mujoco.mj_kinematics(arm.model, data)
    pose = np.eye(4)
    pose[:3, :3] = data.site(arm.site).xmat.reshape(3, 3)
    pose[:3, 3] = data.site(arm.site).xpos
    return pose


def random_joints(arm, count, seed=0):
    return np.random.default_rng(seed).uniform(*arm.chain.limits.T, (count, arm.chain.n_joints))


def grip():
    """A mug on the table, its handle towards the arm, and the hand about the handle, coming from the arm's side."""
    mug = in_metres(zoo.make("mug", 0))
    T_world_object = np.diag([-1.0, -1.0, 1.0, 1.0])
    T_world_object[:3, 3] = 0.6, 0.0, 0.0
    T_object_gripper = np.array([[0.0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0.07], [0, 0, 0, 1]])
    T_object_gripper[0, 3] = mug.bounds[1][0] - 0.012
    return mug, T_world_object, T_world_object @ T_object_gripper


@pytest.mark.parametrize("arm", [ARM, load_arm(ODD, site="tool")], ids=["panda", "odd"])
def test_links_are_where_mujoco_puts_them(arm):
    joints = random_joints(arm, 50)
    poses = arm.chain.poses(joints)
    data = mujoco.MjData(arm.model)
    for q, links in zip(joints, poses, strict=True):
        data.qpos[:] = q
        mujoco.mj_kinematics(arm.model, data)
        # A body's last joint carries it.
        for body in range(1, arm.model.nbody):
            last = sum(max(int(arm.model.body_jntnum[b]), 1) for b in range(1, body + 1)) - 1
            assert np.allclose(links[last][:3, 3], data.xpos[body], atol=1e-9)
            assert np.allclose(links[last][:3, :3], data.xmat[body].reshape(3, 3), atol=1e-9)


def test_the_tcp_is_the_grippers():
    # The joints' ready position of Franka: the hand looks down, 48.7 cm high and 30.7 cm away.
    pose = site_pose(ARM, ARM.home)
    assert np.allclose(pose[:3, 2], [0, 0, -1], atol=1e-5)
    assert np.allclose(pose[:3, 3], [0.307, 0, 0.487], atol=1e-3)


def test_what_mujoco_sees_touching_is_not_clear():
    joints = random_joints(ARM, 400)
    clear = clear_joints(ARM.chain, NOTHING, joints, 0.0)
    data = mujoco.MjData(ARM.model)
    fingers = {ARM.model.body(name).id for name in ("finger_right", "finger_left")}
    touching = np.zeros(len(joints), bool)
    for i, q in enumerate(joints):
        data.qpos[:] = q
        mujoco.mj_forward(ARM.model, data)
        bodies = [{int(ARM.model.geom_bodyid[g]) for g in contact.geom} for contact in data.contact]
        touching[i] = any(pair != fingers for pair in bodies)  # the pads are meant to meet
    assert 20 < touching.sum() < 380
    assert not (touching & clear).any()
    # Boxes are larger than capsules, but not by much.
    assert (clear | touching).mean() > 0.9


def test_inverse_kinematics_arrives_within_the_limits():
    poses = [site_pose(ARM, q) for q in random_joints(ARM, 20, 1)]
    solved = 0
    for pose in poses:
        solutions = solve_ik(ARM, pose, config=IkConfig(solutions=2))
        solved += len(solutions) > 0
        for q in solutions:
            assert np.linalg.norm(site_pose(ARM, q)[:3, 3] - pose[:3, 3]) < 1.1e-4
            assert np.abs(site_pose(ARM, q)[:3, :3] - pose[:3, :3]).max() < 1.1e-3
            assert (q >= ARM.chain.limits[:, 0]).all()
            assert (q <= ARM.chain.limits[:, 1]).all()
    assert solved >= 18


def test_plans_to_a_handle_and_touches_nothing_on_the_way():
    mug, T_world_object, goal = grip()
    motion = plan_arm(ARM, mug, T_world_object, goal, support=TABLE, opening=0.06)
    assert motion.found
    assert np.allclose(motion.joints[:, 7:], 0.03)
    assert np.allclose(motion.joints[0, :7], ARM.home[:7])
    assert np.allclose(site_pose(ARM, motion.joints[-1]), goal, atol=2e-3)
    dense = motion.at(np.linspace(0, motion.duration, 2000))
    world = world_around(mug, T_world_object, TABLE)
    assert clear_joints(ARM.holding(0.06).chain, world, dense, 0.0).all()
    speeds = np.abs(np.diff(dense, axis=0)).max(axis=1) / (motion.duration / 1999)
    assert speeds.max() <= MotionConfig().joint_speed * (1 + 1e-6)


def test_the_same_seed_gives_the_same_motion():
    mug, T_world_object, _ = grip()
    world = world_around(mug, T_world_object, TABLE)
    held = ARM.holding(0.08).chain
    joints = random_joints(ARM.holding(0.08), 120)
    joints = joints[clear_joints(held, world, joints, 0.001)][:60]
    runs = [plan_joints(held, world, joints[:30], joints[30:]) for _ in range(2)]
    assert all(motion.found for motion in runs[0])
    assert any(motion.iterations for motion in runs[0])
    assert all(np.array_equal(a.joints, b.joints) for a, b in zip(*runs, strict=True))


def test_an_approach_ends_straight_and_lifts():
    mug, T_world_object, goal = grip()
    grasp = Grasp(np.linalg.inv(T_world_object) @ goal, 0.016, 1.0, np.zeros((2, 3)), 0.0, PANDA_HAND)
    plan = plan_arm_approach(ARM, mug, T_world_object, grasp, support=TABLE)
    assert plan.found
    assert np.array_equal(plan.transit.joints[-1], plan.straight.joints[0])
    assert np.array_equal(plan.straight.joints[-1], plan.lift.joints[0])
    for leg, direction, length in ((plan.straight, goal[:3, 2], 0.08), (plan.lift, TABLE.normal, 0.1)):
        poses = np.stack([site_pose(ARM, q) for q in leg.at(np.linspace(0, leg.duration, 60))])
        ways = poses[:, :3, 3] - poses[0, :3, 3]
        assert ways[-1] @ direction == pytest.approx(length, abs=3e-4)
        assert np.linalg.norm(ways - np.outer(ways @ direction, direction), axis=1).max() < 4e-4
        assert np.abs(poses[:, :3, :3] - goal[:3, :3]).max() < 5e-3
    far = np.eye(4)
    far[0, 3] = 3.0
    assert plan_arm_approach(ARM, mug, far, grasp, support=TABLE).reason.startswith("grasp out of reach")
    sunk = Support(np.array([0.0, 0.0, 1.0]), 0.06)
    assert "blocked" in plan_arm_approach(ARM, mug, T_world_object, grasp, support=sunk).reason


def test_says_why_there_is_no_motion():
    mug, T_world_object, goal = grip()
    far, low = goal.copy(), goal.copy()
    far[:3, 3] = 2.0, 0.0, 0.5
    low[2, 3] = -0.02
    quick = IkConfig(attempts=3, iterations=20)
    plan = lambda *a, **k: plan_arm(ARM, mug, T_world_object, *a, support=TABLE, ik=quick, **k).reason  # noqa: E731
    assert plan(far).startswith("goal out of reach")
    assert plan(low).startswith("goal in collision in all")
    folded = ARM.home.copy()
    folded[:7] = 0.0, 1.7, 0.0, -0.1, 0.0, 0.0, 0.0  # stretched out into the table
    assert plan(goal, folded).startswith("start in collision")
    world = world_around(mug, T_world_object, TABLE)
    beyond = ARM.home.copy()
    beyond[1] = 2.0
    motion = plan_joints(ARM.chain, world, ARM.home[None], beyond[None])[0]
    assert motion.reason.startswith("goal beyond the limits of joint 1: 2.000 of -1.763 to 1.763")


def test_bad_input_is_one_line():
    mug, T_world_object, goal = grip()
    cases = [
        (lambda: plan_arm(ARM, mug, np.zeros((4, 4)), goal), "T_world_object"),
        (lambda: plan_arm(ARM, mug, T_world_object, goal * np.nan), "T_world_gripper"),
        (lambda: plan_arm(ARM, mug, T_world_object, goal, np.zeros(7)), "start joints: expected shape"),
        (lambda: plan_arm(ARM, mug, T_world_object, goal, opening=0.09), "opening: expected metres from 0 to 0.08"),
        (lambda: load_arm("<mujoco><worldbody><geom/></worldbody></mujoco>", site="tcp"), "MuJoCo cannot compile"),
        (lambda: load_arm(ODD, site="tcp"), "no site 'tcp'; its sites are tool"),
        (
            lambda: load_arm(
                ODD.replace(
                    '<joint name="a" axis="1 0 0" pos="0.05 0 0.02" ref="0.4" range="-1 1"/>',
                    '<joint name="a" type="ball"/>',
                ).replace('<joint name="b" axis="0 0.6 0.8" pos="0 0.1 0" range="-2 2"/>', ""),
                site="tool",
            ),
            "joint 'a': expected a hinge",
        ),
        (lambda: load_arm(ODD, site="tool", home=[0.0]), "home: expected shape"),
        (lambda: load_arm("/nowhere/arm.xml", site="tool"), "MuJoCo cannot compile"),
        (lambda: IkConfig(attempts=0), "attempts: expected at least 1"),
        (lambda: IkConfig(angle_tolerance=float("nan")), "angle_tolerance"),
    ]
    for call, match in cases:
        with pytest.raises(InputError, match=match) as error:
            call()
        assert "\n" not in str(error.value)


def test_the_same_model_can_be_simulated():
    data = mujoco.MjData(ARM.model)
    data.qpos[:] = ARM.home
    data.ctrl[:] = ARM.home
    mujoco.mj_step(ARM.model, data, 500)
    assert np.abs(data.qpos - ARM.home).max() < 0.01
    assert not any(warning.number for warning in data.warning)
