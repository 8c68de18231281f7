"""The schedule of the gait: what the feet, the load and the heading do over the next steps."""

import numpy as np
import pytest

from lola_drake.blocks.walking_pattern import WalkingPatternParams, standing_request
from lola_drake.theory.gait import LEFT, RIGHT, Profile, advance, foothold, make_schedule
from lola_drake.theory.smooth import linear

PARAMS = WalkingPatternParams()
TIMING = PARAMS.timing()
DT = 0.001
FORWARD = np.tile([0.4, 0.0, 0.0], (3, 1))
TURNING = np.tile([0.2, 0.03, 0.25], (3, 1))
IN_PLACE = np.zeros((1, 3))
NONE = np.zeros((0, 3))
WALKS = pytest.mark.parametrize("steps", [FORWARD, TURNING, IN_PLACE])


def schedule(steps, *, ground=0.0, swing=LEFT, feet=None):
    start = standing_request(PARAMS)
    return make_schedule(
        TIMING,
        start.feet if feet is None else feet,
        start.load,
        start.com[2],
        start.heading,
        start.path,
        ground,
        swing,
        start.support,
        steps,
    )


def times(plan):
    return np.arange(0.0, plan.end + 0.1, DT)


def at(profile, time):
    """Return the value of a profile at one time."""
    return profile(np.array([time]))[0][0]


def side_by_side(plan, path):
    return all(
        plan.foot[foot].end[[0, 1, 3]]
        == pytest.approx(foothold(path, foot, TIMING.step_width), abs=1e-12)
        for foot in (LEFT, RIGHT)
    )


def test_profile_without_changes_stays():
    value, rate = Profile(np.array([2.0, 3.0]))(np.linspace(0, 1, 5))
    assert value == pytest.approx(np.tile([2.0, 3.0], (5, 1)))
    assert not rate.any()


def test_profile_adds_its_changes_up():
    profile = Profile(np.array([1.0]))
    profile.add(0.0, 1.0, [2.0])
    profile.add(0.5, 2.0, [-5.0])
    assert profile.end == pytest.approx([-2.0])
    assert at(profile, 2.0) == pytest.approx(profile.end)
    assert at(profile, 0.0) == pytest.approx(profile.start)


def test_linear_profile_is_a_straight_line():
    profile = Profile(np.array([1.0]), transition=linear)
    profile.add(1.0, 3.0, [4.0])
    value, rate = profile(np.array([0.5, 1.5, 2.0, 3.5]))
    assert value[:, 0] == pytest.approx([1.0, 2.0, 3.0, 5.0])
    assert rate[:, 0] == pytest.approx([0.0, 2.0, 2.0, 0.0])


def test_profile_is_the_same_however_far_it_is_asked_for():
    plan = schedule(FORWARD)
    long = times(plan)
    short = long[:900]
    assert np.allclose(plan.foot[LEFT](short)[0], plan.foot[LEFT](long)[0][:900], atol=1e-15)


@WALKS
def test_rates_of_the_feet_are_those_of_their_places(steps):
    plan = schedule(steps)
    for profile in (*plan.foot, *plan.toe, plan.heading, plan.height):
        value, rate = profile(times(plan))
        assert np.gradient(value, DT, axis=0)[1:-1] == pytest.approx(rate[1:-1], abs=2e-3)


@WALKS
def test_feet_are_continuous_to_the_acceleration(steps):
    plan = schedule(steps)
    for profile in plan.foot:
        value, _ = profile(times(plan))
        acceleration = np.diff(value, 2, axis=0) / DT**2
        jerk = np.diff(acceleration, axis=0) / DT
        assert np.abs(acceleration).max() < 30
        # Of a jump, the difference quotient would be its height over 1 ms.
        assert np.abs(jerk).max() < 1500


@WALKS
def test_feet_are_at_rest_at_lift_off_and_touchdown(steps):
    plan = schedule(steps)
    for foot, lift_off, touchdown in plan.swings:
        for event in (lift_off, touchdown):
            around = np.array([event - DT, event, event + DT])
            value, rate = plan.foot[foot](around)
            assert rate == pytest.approx(np.zeros((3, 4)), abs=2e-3)
            assert np.diff(value, 2, axis=0) / DT**2 == pytest.approx(np.zeros((1, 4)), abs=1.5)


@WALKS
def test_stance_foot_does_not_move(steps):
    plan = schedule(steps)
    for foot, lift_off, touchdown in plan.swings:
        _, rate = plan.foot[1 - foot](np.linspace(lift_off, touchdown, 50))
        assert not rate.any()


@WALKS
@pytest.mark.parametrize("swing", [LEFT, RIGHT])
def test_feet_are_side_by_side_at_the_end(steps, swing):
    plan = schedule(steps, swing=swing)
    assert side_by_side(plan, plan.path[-1])


def test_forward_steps_need_a_closing_step():
    plan = schedule(FORWARD)
    assert len(plan.swings) == len(FORWARD) + 1
    assert plan.path[-1] == pytest.approx(plan.path[-2])


def test_steps_in_place_need_no_closing_step():
    assert len(schedule(IN_PLACE).swings) == 1


def test_standing_apart_is_closed_even_without_steps():
    left, right = standing_request(PARAMS).feet
    plan = schedule(NONE, feet=(left + [0.2, 0, 0, 0], right))
    assert [foot for foot, *_ in plan.swings] == [LEFT]
    assert side_by_side(plan, np.zeros(3))


def test_standing_side_by_side_takes_no_step():
    plan = schedule(NONE)
    assert plan.swings == []
    assert plan.end == pytest.approx(TIMING.last_double_support)


@pytest.mark.parametrize("swing", [LEFT, RIGHT])
def test_feet_swing_in_turn(swing):
    plan = schedule(FORWARD, swing=swing)
    assert [foot for foot, *_ in plan.swings] == [swing, 1 - swing, swing, 1 - swing]


def test_steps_last_the_step_time():
    touchdowns = [touchdown for *_, touchdown in schedule(FORWARD).swings]
    assert np.diff(touchdowns) == pytest.approx(np.full(3, TIMING.step_time))


def test_between_swings_is_the_double_support():
    plan = schedule(FORWARD)
    for (*_, touchdown), (_, lift_off, _) in zip(plan.swings, plan.swings[1:], strict=False):
        assert lift_off - touchdown == pytest.approx(TIMING.double_support)


@WALKS
def test_load_is_a_share(steps):
    plan = schedule(steps)
    load, _ = plan.load(times(plan))
    assert load.min() >= -1e-12
    assert load.max() <= 1 + 1e-12


@WALKS
def test_load_is_on_the_stance_foot_during_a_swing(steps):
    plan = schedule(steps)
    for foot, lift_off, touchdown in plan.swings:
        load, _ = plan.load(np.linspace(lift_off, touchdown, 50))
        assert load == pytest.approx(np.full((50, 1), float(foot == RIGHT)), abs=1e-12)


@WALKS
def test_load_is_shared_at_the_end(steps):
    plan = schedule(steps)
    assert at(plan.load, plan.end) == pytest.approx([0.5])


@WALKS
@pytest.mark.parametrize("ground", [0.0, 0.03, -0.03])
def test_swing_foot_clears_the_ground_by_the_step_height(steps, ground):
    plan = schedule(steps, ground=ground)
    foot, lift_off, touchdown = plan.swings[0]
    height = plan.foot[foot](np.linspace(lift_off, touchdown, 501))[0][:, 2]
    assert height.max() == pytest.approx(max(0.0, ground) + TIMING.step_height)
    assert height[-1] == pytest.approx(ground)


@WALKS
def test_toes_lift_in_the_swing_and_come_back(steps):
    plan = schedule(steps)
    for foot, lift_off, touchdown in plan.swings:
        assert at(plan.toe[foot], (lift_off + touchdown) / 2) == pytest.approx([TIMING.toe_lift])
        assert at(plan.toe[foot], lift_off) == pytest.approx([0.0], abs=1e-12)
        assert at(plan.toe[foot], touchdown) == pytest.approx([0.0], abs=1e-12)


@WALKS
def test_every_step_lands_on_the_path(steps):
    plan = schedule(steps)
    for path, (foot, _, touchdown) in zip(plan.path, plan.swings, strict=True):
        landed = at(plan.foot[foot], touchdown)[[0, 1, 3]]
        assert landed == pytest.approx(foothold(path, foot, TIMING.step_width))


def test_path_of_turning_steps_is_an_arc():
    plan = schedule(TURNING)
    angles = 0.25 * np.arange(3)
    c, s = np.cos(angles), np.sin(angles)
    x, y = np.cumsum(0.2 * c - 0.03 * s), np.cumsum(0.2 * s + 0.03 * c)
    expected = np.column_stack([x, y, angles + 0.25])
    assert np.array(plan.path[:3]) == pytest.approx(expected)


def test_torso_turns_with_the_path():
    plan = schedule(TURNING)
    for path, (*_, touchdown) in zip(plan.path, plan.swings, strict=True):
        assert at(plan.heading, touchdown) == pytest.approx(path[2:])


def test_com_height_follows_the_ground():
    plan = schedule(FORWARD, ground=0.04)
    assert plan.height.end == pytest.approx([TIMING.com_height + 0.04])
    assert at(plan.height, plan.swings[0][2]) == pytest.approx([TIMING.com_height + 0.02])


def test_advance_there_and_back_is_nothing():
    path = np.array([1.0, 2.0, 0.7])
    there = advance(path, np.array([0.3, 0.1, 0.0]))
    assert advance(there, np.array([-0.3, -0.1, 0.0])) == pytest.approx(path)


def test_footholds_are_a_step_width_apart():
    path = np.array([1.0, 2.0, 0.7])
    left, right = (foothold(path, foot, 0.25) for foot in (LEFT, RIGHT))
    assert np.linalg.norm((left - right)[:2]) == pytest.approx(0.25)
    assert (left + right) / 2 == pytest.approx(path)
