import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from graft.errors import InputError
from graft.objects import Demonstration
from graft.trajectory import Segment, Trajectory, poses_from_quaternions, segments_from_signals


def poses(seed, steps):
    rng = np.random.default_rng(seed)
    result = np.tile(np.eye(4), (steps, 1, 1))
    result[:, :3, :3] = Rotation.random(steps, rng=rng).as_matrix()
    result[:, :3, 3] = rng.normal(size=(steps, 3))
    return result


def trajectory(steps=10, **changes):
    words = {
        "times": np.arange(steps) / 20,
        "T_world_target": poses(0, steps),
        "gripper": np.where(np.arange(steps) < 6, -1.0, 1.0),
        "T_world_gripper": poses(1, steps),
        "T_world_object": {"object": poses(2, steps)},
        "segments": (Segment("reach", 0, 4, "object", "reached"), Segment("lift", 4, steps, "object")),
    }
    return Trajectory(**(words | changes))


def bent(row, value):
    changed = poses(0, 10)
    changed[row] = value
    return changed


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"times": [0, 0.1, 0.1, *range(1, 8)]}, r"times: expected increasing, got 0.1 then 0.1 at step 2"),
        ({"times": [np.nan] * 10}, r"trajectory times: expected finite numbers, got nan at \[0\]"),
        ({"times": []}, "expected at least one step"),
        ({"T_world_target": poses(0, 9)}, r"T_world_target: expected shape \(10, 4, 4\), got \(9, 4, 4\)"),
        ({"T_world_target": bent(3, 2 * np.eye(4))}, "T_world_target: expected rotations and translations, row 3"),
        ({"T_world_target": bent(7, np.diag([1, 1, -1, 1.0]))}, "row 7 is none"),
        ({"T_world_gripper": bent(2, np.ones((4, 4)))}, "T_world_gripper: .* row 2 is none"),
        ({"T_world_object": {"cup": bent(1, np.zeros((4, 4)))}, "segments": ()}, "T_world_object 'cup': .* row 1"),
        ({"gripper": np.r_[np.zeros(4), 1.5, np.zeros(5)]}, r"actions in \[-1, 1\], got 1.5 at step 4"),
        (
            {"segments": (Segment("a", 0, 4), Segment("b", 5, 10))},
            "'b': expected it to start at step 4, it starts at 5",
        ),
        ({"segments": (Segment("a", 0, 4),)}, "cover 10 steps, they end at 4"),
        ({"segments": (Segment("a", 0, 4), Segment("a", 4, 10))}, "name 'a' is there twice"),
        ({"segments": (Segment("a", 0, 4, None, "s"), Segment("b", 4, 10, None, "s"))}, "signal 's' is there twice"),
        ({"segments": (Segment("a", 0, 10, "cup"),)}, "no object called 'cup'; the objects are object"),
    ],
)
def test_bad_trajectories_are_one_line(changes, match):
    with pytest.raises(InputError, match=match) as error:
        trajectory(**changes)
    assert "\n" not in str(error.value)


def test_bad_segments():
    with pytest.raises(InputError, match="expected a name"):
        Segment("", 0, 1)
    with pytest.raises(InputError, match="expected 0 <= start < end, got start 3, end 3"):
        Segment("a", 3, 3)


def test_without_segments_one_covers_everything():
    (segment,) = trajectory(segments=()).segments
    assert (segment.start, segment.end, segment.anchor, segment.signal) == (0, 10, None, None)


def test_signals_rise_with_the_last_step_of_their_segment_and_give_the_segments_back():
    moves = trajectory()
    assert moves.term_signals["reached"].tolist() == [0, 0, 0, 1, 1, 1, 1, 1, 1, 1]
    back = segments_from_signals(moves.term_signals, 10)
    assert [(s.start, s.end, s.signal) for s in back] == [(0, 4, "reached"), (4, 10, None)]
    assert back[1].name == "end"


def test_signals_that_end_nothing():
    rises = np.arange(10) >= 5
    signals = {"b": rises, "a": rises, "never": np.zeros(10), "always": np.ones(10), "end": np.arange(10) >= 7}
    found = segments_from_signals(signals, 10, anchors={"a": "cup", "end_": "pot"})
    assert [(s.name, s.start, s.end, s.anchor) for s in found] == [
        ("a", 0, 6, "cup"), ("end", 6, 8, None), ("end_", 8, 10, "pot"),
    ]  # fmt: skip


@given(st.integers(0, 100))
@settings(max_examples=20, deadline=None)
def test_another_world_changes_no_relative_pose(seed):
    moves, move = trajectory(), poses(seed, 1)[0]
    moved = moves.transformed(move)
    for name in ("T_world_target", "T_world_gripper"):
        before = np.linalg.inv(moves.T_world_object["object"]) @ getattr(moves, name)
        after = np.linalg.inv(moved.T_world_object["object"]) @ getattr(moved, name)
        assert_allclose(after, before, atol=1e-12)
    assert_allclose(moved.T_world_target[3], move @ moves.T_world_target[3])
    with pytest.raises(InputError, match="transform: expected rotations and translations"):
        moves.transformed(2 * np.eye(4))


def test_resampling_at_its_own_times_changes_nothing():
    moves = trajectory()
    again = moves.resampled(moves.times)
    assert_allclose(again.T_world_target, moves.T_world_target, atol=1e-12)
    assert_allclose(again.T_world_object["object"], moves.T_world_object["object"], atol=1e-12)
    assert again.gripper.tolist() == moves.gripper.tolist()
    assert again.segments == moves.segments


def test_resampling_interpolates_poses_and_holds_commands():
    start, end = np.eye(4), np.eye(4)
    end[:3, :3] = Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    end[:3, 3] = [1, 2, 3]
    moves = Trajectory([0.0, 1.0], [start, end], [-1, 1], segments=())
    half = moves.resampled([0.0, 0.25, 0.999, 1.0])
    assert_allclose(half.T_world_target[1, :3, 3], [0.25, 0.5, 0.75])
    assert_allclose(Rotation.from_matrix(half.T_world_target[1, :3, :3]).as_rotvec(), [0, 0, 0.25])
    assert half.gripper.tolist() == [-1, -1, -1, 1]


def test_resampling_keeps_segments_at_their_times():
    moves = trajectory()
    fine = moves.resampled(np.linspace(0, moves.times[-1], 91))
    assert [s.name for s in fine.segments] == ["reach", "lift"]
    assert fine.times[fine.segments[0].end - 1] <= moves.times[3] < fine.times[fine.segments[1].start]
    with pytest.raises(InputError, match="none falls into segment 'reach'"):
        moves.resampled([0.3, 0.4])
    with pytest.raises(InputError, match=r"expected 0 to 0.45 s, got 0 to 0.5"):
        moves.resampled([0, 0.5])


def test_subset_cuts_segments_and_drops_the_signal_of_one_without_its_end():
    part = trajectory().subset(2, 8)
    assert len(part) == 6
    assert [(s.name, s.start, s.end, s.signal) for s in part.segments] == [
        ("reach", 0, 2, "reached"), ("lift", 2, 6, None),
    ]  # fmt: skip
    assert part.T_world_object["object"].tolist() == trajectory().T_world_object["object"][2:8].tolist()
    (cut,) = trajectory().subset(0, 3).segments
    assert cut.signal is None
    with pytest.raises(InputError, match="expected 0 <= start < end <= 10, got start 4, end 11"):
        trajectory().subset(4, 11)


def test_quaternions_are_wxyz_of_unit_length():
    got = poses_from_quaternions("target", [[1, 2, 3]], [[np.sqrt(0.5), 0, 0, np.sqrt(0.5)]])[0]
    assert_allclose(got, [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], atol=1e-12)
    with pytest.raises(InputError, match="target quaternions: expected unit length, row 0 has 0"):
        poses_from_quaternions("target", [[1, 2, 3]], [[0, 0, 0, 0]])


def test_everything_is_read_only():
    moves = trajectory()
    with pytest.raises(ValueError, match="read-only"):
        moves.T_world_target[0, 0, 0] = 2
    with pytest.raises(AttributeError):
        moves.times = [1]


def test_a_demonstration_takes_a_grasp_in_metres(tetrahedron_demo):
    obj, contact = tetrahedron_demo
    demo = Demonstration(obj, contact, grasp=np.eye(4), trajectory=trajectory())
    assert demo.grasp.flags.writeable is False
    assert demo.trajectory.duration == pytest.approx(0.45)
    with pytest.raises(InputError, match="demonstration 'o' grasp: expected a rotation"):
        Demonstration(obj, contact, grasp=2 * np.eye(4))


@pytest.fixture
def tetrahedron_demo():
    from graft.objects import Contact, Part, PartObject

    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    obj = PartObject("o", (Part("p", corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),))
    return obj, Contact([0, 0, 0], [0, 0, -1], 0)
