"""The schedule of the gait: smooth, alternating, and standing at its end."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.blocks.walking_pattern import WalkingPatternParams
from lola_drake.robot import JOINT_INDEX, Kinematics
from lola_drake.theory.footholds import LEFT, RIGHT, UP, advance, foothold, sole
from lola_drake.theory.gait import (
    FOOT,
    HEADING,
    HEIGHT,
    PITCH,
    PITCH_PER_RISE,
    TOE,
    TOE_AXIS,
    Profile,
    make_schedule,
)

TIMING = WalkingPatternParams().timing()
displacements = st.lists(
    st.tuples(st.floats(-0.4, 0.4), st.floats(-0.1, 0.1), st.floats(-0.3, 0.3), st.just(0.0)),
    max_size=4,
)
rising = st.lists(
    st.tuples(
        st.floats(-0.4, 0.4), st.floats(-0.3, 0.3), st.floats(-0.79, 0.79), st.floats(-0.2, 0.2)
    ),
    max_size=4,
)


def schedule(steps, swing=LEFT):
    """Return the schedule of a robot that stands at the origin and takes these steps."""
    feet = tuple(
        np.insert(foothold(np.zeros(3), foot, TIMING.step_width), 2, 0.0) for foot in (LEFT, RIGHT)
    )
    return make_schedule(
        TIMING, feet, 0.5, 0.87, 0.0, np.zeros(3), 0.0, swing, 0.8, np.reshape(steps, (-1, 4))
    )


def mirrored(pose):
    """Return x, y, (z,) yaw seen in a mirror beside the robot."""
    return pose * np.array([1, -1, 1, -1])[[0, 1, 2, 3] if pose.shape[-1] == 4 else [0, 1, 3]]


def test_profile_holds_its_ends_and_sums_its_changes():
    profile = Profile(np.array([1.0, 0.0]))
    profile.add(0.2, 0.4, [1.0, 0.0])
    profile.add(0.3, 0.5, [0.0, -2.0])
    value, rate, _ = profile(np.array([0.0, 0.2, 0.5, 9.0]))
    np.testing.assert_allclose(value.T, [[1, 0], [1, 0], [2, -2], [2, -2]])
    np.testing.assert_allclose(rate, 0)
    np.testing.assert_allclose(profile.end, [2, -2])


@pytest.mark.parametrize("swing", [LEFT, RIGHT])
def test_motions_are_continuous_to_the_acceleration(swing):
    plan = schedule([[0.35, 0.05, 0.1, 0.0]] * 3, swing)
    dt = 1e-4
    time = np.arange(0.0, plan.end + 0.2, dt)
    value, rate, acceleration = plan.motion(time)
    np.testing.assert_allclose((value[:, 2:] - value[:, :-2]) / (2 * dt), rate[:, 1:-1], atol=1e-4)
    middle = (rate[:, 2:] - rate[:, :-2]) / (2 * dt)
    # The minimum-jerk transition of a change in the time T has at most the jerk 60 change/T^3.
    jerk = sum(
        60 * np.abs(change) / (end - begin) ** 3 for begin, end, change in plan.motion.changes
    )
    assert np.all(np.abs(middle - acceleration[:, 1:-1]) <= jerk[:, None] * dt + 1e-7)
    assert np.all(np.abs(np.diff(acceleration)) <= 1.01 * jerk[:, None] * dt + 1e-9)


def test_load_moves_without_jumps_and_rests_on_the_stance_foot():
    plan = schedule([[0.3, 0.0, 0.0, 0.0]] * 3)
    time = np.arange(0.0, plan.end, 1e-3)
    load = plan.load(time)[0][0]
    assert np.abs(np.diff(load)).max() < 0.005
    assert load.min() >= 0
    assert load.max() <= 1
    for foot, lift_off, touchdown in plan.swings:
        swinging = (time > lift_off) & (time < touchdown)
        np.testing.assert_allclose(load[swinging], 1.0 if foot == RIGHT else 0.0, atol=1e-12)


@given(displacements)
def test_one_foot_stands_still_while_the_other_swings(steps):
    plan = schedule(steps)
    for k, (foot, lift_off, touchdown) in enumerate(plan.swings):
        assert k == 0 or foot != plan.swings[k - 1][0]
        time = np.linspace(lift_off, touchdown, 50)
        value, rates, _ = plan.motion(time)
        stance, rate = value[FOOT[1 - foot]].T, rates[FOOT[1 - foot]]
        np.testing.assert_allclose(stance, stance[:1].repeat(50, axis=0), atol=1e-12)
        np.testing.assert_allclose(rate, 0, atol=1e-9)
        height = value[FOOT[foot]][2]
        assert height.max() == pytest.approx(TIMING.step_height)
        assert height.min() >= -1e-12


@given(displacements)
def test_ends_with_the_feet_side_by_side(steps):
    plan = schedule(steps)
    path = np.zeros(3)
    for step in steps:
        path = advance(path, np.array(step[:UP]))
    for foot in (LEFT, RIGHT):
        end = plan.motion.end[FOOT[foot]]
        np.testing.assert_allclose(
            end[[0, 1, 3]], foothold(path, foot, TIMING.step_width), atol=1e-8
        )
    assert plan.load.end == pytest.approx(0.5)
    assert len(steps) <= len(plan.swings) <= len(steps) + 2


def test_footholds_are_a_step_width_apart_and_turn_with_the_path():
    left, right = (foothold(np.array([1.0, 2.0, np.pi / 2]), foot, 0.2) for foot in (LEFT, RIGHT))
    np.testing.assert_allclose(left, [0.9, 2.0, np.pi / 2])
    np.testing.assert_allclose(right, [1.1, 2.0, np.pi / 2])


@given(rising)
def test_no_loaded_foot_stands_on_the_other_one_whatever_is_asked(steps):
    plan = schedule(steps)
    for _, _, touchdown in plan.swings:
        value, _, _ = plan.motion(np.array([touchdown, touchdown]))
        left, right = (sole(value[foot][[0, 1, 3], 0]) for foot in FOOT)
        assert not left.overlaps(right)


@given(rising)
def test_hips_turn_no_further_than_they_can(steps):
    plan = schedule(steps)
    for _, lift_off, touchdown in plan.swings:
        value, _, _ = plan.motion(np.linspace(lift_off, touchdown, 9))
        for foot in FOOT:
            turned = np.degrees(value[foot][3] - value[HEADING])
            assert np.abs(turned).max() < 24.0


@given(rising)
def test_feet_and_com_follow_the_planned_heights(steps):
    plan, ground = schedule(steps), 0.0
    heights = [0.0, 0.0]
    for step, (foot, _, touchdown) in zip(steps, plan.swings, strict=False):
        ground += step[UP]
        heights[foot] = ground
        value, _, _ = plan.motion(np.array([touchdown, touchdown]))
        for k in (LEFT, RIGHT):
            assert value[FOOT[k]][2, 0] == pytest.approx(heights[k], abs=1e-9)
        assert value[HEIGHT, 0] == pytest.approx(0.87 + np.mean(heights), abs=1e-9)


def swing_of(up):
    """Return pose, pitch and toe's lift of the foot that swings in the second of three steps."""
    plan = schedule([[0.35, 0.0, 0.0, up]] * 3)
    foot, lift_off, touchdown = plan.swings[1]
    value = plan.motion(np.linspace(lift_off, touchdown, 99))[0]
    return value[FOOT[foot]], value[PITCH[foot]], value[TOE[foot]]


@pytest.mark.parametrize("up", [0.12, -0.12])
def test_swing_foot_clears_both_levels(up):
    (_, _, z, _), pitch, _ = swing_of(up)
    lifted = TOE_AXIS * pitch.max() if up < 0 else 0.0
    assert z.max() == pytest.approx(max(0.0, 2 * up) + TIMING.step_height + lifted)


@pytest.mark.parametrize("up", [0.12, 0.0, -0.12])
def test_heel_is_lifted_where_the_foot_has_far_to_go_up_or_down_and_level_where_it_lands(up):
    _, pitch, toe = swing_of(up)
    assert [*pitch[[0, -1]], *toe[[0, -1]]] == pytest.approx([0.0] * 4, abs=1e-12)
    assert pitch.max() == pytest.approx(PITCH_PER_RISE * abs(2 * up))
    assert pitch.min() > -1e-12


@pytest.mark.parametrize("up", [-0.02, -0.12, -0.2])
def test_toe_of_a_foot_that_goes_down_stays_over_its_step_and_is_never_bent_below_the_foot(up):
    """The toe's axis comes down as the heel goes up; with it all that lies ahead of it."""
    (x, _, z, _), pitch, toe = swing_of(up)
    leaving = np.arange(len(z)) <= z.argmax()
    assert (z - TOE_AXIS * np.sin(pitch))[leaving].min() > -1e-12
    assert (toe - pitch).min() > -1e-12
    assert toe.max() == pytest.approx(max(TIMING.toe_lift, pitch.max()))


def test_the_toes_axis_is_where_the_robot_has_it():
    tree, toe = Kinematics().tree, JOINT_INDEX["tzfl"]
    assert tree.offset[toe][0] - tree.p_BTcp[LEFT][0] == pytest.approx(TOE_AXIS)


@given(displacements)
def test_mirrored_steps_give_the_mirrored_schedule(steps):
    plan = schedule(steps, LEFT)
    mirror = schedule([(x, -y, -turn, up) for x, y, turn, up in steps], RIGHT)
    time = np.linspace(0.0, plan.end, 100)
    for foot in (LEFT, RIGHT):
        for one, other in zip(plan.motion(time), mirror.motion(time), strict=True):
            other = mirrored(other[FOOT[1 - foot]].T)
            np.testing.assert_allclose(one[FOOT[foot]].T, other, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(plan.load(time)[0], 1 - mirror.load(time)[0], atol=1e-12)


@pytest.mark.parametrize(
    ("heights", "ground"), [((0.0, 0.1), 0.0), ((0.1, 0.0), 0.0), ((0, 0), 0.1)]
)
def test_a_step_clears_what_is_highest_and_the_body_rises_half_way(heights, ground):
    """The stance foot, the place that it leaves, and the place where it is to stand."""
    feet = tuple(
        np.insert(foothold(np.zeros(3), foot, TIMING.step_width), 2, z)
        for foot, z in zip((LEFT, RIGHT), heights, strict=True)
    )
    step = np.array([[0.3, 0.0, 0.0, 0.0]])
    plan = make_schedule(TIMING, feet, 0.0, 0.87, 0.0, np.zeros(3), ground, LEFT, 0.4, step)
    _, lift_off, touchdown = plan.swings[0]
    value, _, _ = plan.motion(np.linspace(lift_off, touchdown, 801))
    highest = value[FOOT[LEFT]][2].max()
    lifted = TOE_AXIS * PITCH_PER_RISE * max(heights[LEFT] - ground, 0.0)
    assert highest == pytest.approx(max(*heights, ground) + TIMING.step_height + lifted)
    body = value[HEIGHT][-1] if np.ndim(value[HEIGHT]) else value[HEIGHT]
    assert body == pytest.approx(TIMING.com_height + (heights[RIGHT] + ground) / 2)
