"""Step adaptation against the pendulum's own equation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.signals import PERIOD
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import LEFT, RIGHT, foothold, sole
from lola_drake.theory.step_adaptation import (
    DEAD,
    EDGE,
    MOST,
    PRESSURE,
    UPRIGHT,
    allowed_shift,
    approach,
    capture_shift,
    part_ahead,
    too_low,
)

HEIGHT = 0.87
OMEGA = np.sqrt(GRAVITY / HEIGHT)
NOTHING = np.zeros(2)


def shift_of(lean, rate=NOTHING, zmp=NOTHING, time_left=0.2, support=0.34):
    return capture_shift(np.array(lean), np.array(rate), np.array(zmp), HEIGHT, time_left, support)


def test_a_pushed_pendulum_is_taken_up_by_the_moved_foothold():
    """Played through: the pressure at the edge, then in the double support from foot to foot."""
    time_left, support, c, v, zmp = 0.3, 0.34, 0.1, 0.4, -0.03
    shift = shift_of([0, c / HEIGHT], [0, v / HEIGHT], [zmp, 0], time_left, support)[0]
    xi, dt = c + v / OMEGA, 1e-5
    for _ in range(round(time_left / dt)):
        xi += dt * OMEGA * (xi - (PRESSURE[0] - zmp))
    for k in range(round(support / dt)):
        xi += dt * OMEGA * (xi - (shift + DEAD) * k * dt / support)
    assert xi == pytest.approx(shift + DEAD, abs=1e-4)


def test_what_the_stance_foot_takes_back_by_itself_moves_nothing():
    """Planned near the heel, the pressure has more room to the front than to the back."""
    lean = 0.07 / HEIGHT
    assert not shift_of([0, lean], zmp=[-0.06, 0]).any()
    assert shift_of([0, -lean], zmp=[-0.06, 0])[0] < -0.1
    assert not shift_of([lean, 0], zmp=[0, 0.06]).any()
    assert shift_of([-lean, 0], zmp=[0, 0.06])[1] > 0.1


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.05, 0.05), st.floats(0.05, 0.4))
def test_mirrored_and_turned_about_the_law_is_the_same(x, y, zmp, time_left):
    shift = shift_of([x, y], zmp=[zmp, zmp], time_left=time_left)
    mirrored = shift_of([-x, y], zmp=[zmp, -zmp], time_left=time_left)
    turned = shift_of([-x, -y], zmp=[-zmp, -zmp], time_left=time_left)
    np.testing.assert_allclose(mirrored, shift * [1, -1], atol=1e-12)
    np.testing.assert_allclose(turned, -shift, atol=1e-12)


def test_the_torso_falls_to_the_right_about_x_and_forward_about_y():
    right, forward = shift_of([0.2, 0.0]), shift_of([0.0, 0.2])
    assert right[0] == 0 and right[1] < 0
    assert forward[0] > 0 and forward[1] == 0


def test_small_deviations_move_nothing_and_great_ones_no_more_than_allowed():
    assert not shift_of([0.0, 0.005], time_left=0.0).any()
    assert not shift_of(NOTHING, time_left=0.4).any()
    great = shift_of([-0.5, 0.4], time_left=0.4)
    assert np.linalg.norm(great) == pytest.approx(MOST)
    assert great[0] > 0 and great[1] > 0


def test_part_ahead_is_that_of_a_pressure_that_goes_from_foot_to_foot():
    assert part_ahead(HEIGHT, 1e-6) == pytest.approx(1, abs=1e-5)
    time = np.linspace(0, 0.34, 100001)
    still_behind = OMEGA * np.exp(-OMEGA * time) * (1 - time / 0.34)
    assert part_ahead(HEIGHT, 0.34) == pytest.approx(1 - np.trapezoid(still_behind, time), abs=1e-6)


@pytest.mark.parametrize("side", [1, -1])
def test_a_foot_of_a_leaning_robot_is_as_much_too_low_as_it_turned_down(side):
    """Tipping about the edge of the sole by small angles, forward and backward, and sideways."""
    angle = 0.1 - UPRIGHT
    forward = too_low(np.array([0, 0.1]), np.array([0.4, 0.2 * side]))
    backward = too_low(np.array([0, -0.1]), np.array([0.4, 0.2 * side]))
    assert forward == pytest.approx(angle * (0.4 - EDGE))
    assert backward == pytest.approx(-angle * (0.4 + EDGE))
    right = too_low(np.array([0.1, 0]), np.array([0.4, 0.2 * side]))
    assert right == pytest.approx(-angle * 0.2 * side)
    assert too_low(np.array([0.5, -0.5]) * UPRIGHT, np.array([0.4, 0.2])) == 0


shifts = st.tuples(st.floats(-MOST, MOST), st.floats(-MOST, MOST)).map(np.array)


@given(shifts, st.floats(-0.55, 0.55), st.floats(-0.5, 0.5), st.sampled_from([LEFT, RIGHT]))
def test_a_moved_foothold_keeps_off_the_other_foot_and_within_reach(shift, ahead, yaw, foot):
    standing = foothold(np.array([1.0, 2.0, yaw]), 1 - foot, 0.23)
    c, s = np.cos(yaw), np.sin(yaw)
    place = foothold(np.array([1.0 + c * ahead, 2.0 + s * ahead, yaw]), foot, 0.23)
    moved = place + np.append(allowed_shift(shift, place, foot, standing), 0.0)
    assert not sole(moved).overlaps(sole(standing))
    x, y = np.array([[c, s], [-s, c]]) @ (moved[:2] - standing[:2])
    assert abs(x) <= 0.55 + 1e-9
    assert abs(y) <= 0.52 + 1e-9


@pytest.mark.parametrize("ahead", [0.0, 0.7])
def test_a_plan_beyond_the_reach_stays_as_it_is(ahead):
    standing, place = np.zeros(3), np.array([ahead, 0.6, 0.0])
    assert allowed_shift(NOTHING, place, LEFT, standing) == pytest.approx([0, 0])
    assert allowed_shift(np.array([0.2, 0.2]), place, LEFT, standing)[1] == pytest.approx(0)


@pytest.mark.parametrize(("foot", "side"), [(LEFT, 1), (RIGHT, -1)])
def test_feet_do_not_cross(foot, side):
    """Not even where the soles would be clear of each other, one ahead of the other."""
    standing = foothold(np.zeros(3), 1 - foot, 0.23)
    place = foothold(np.array([0.4, 0.0, 0.0]), foot, 0.23)
    moved = place[:2] + allowed_shift(np.array([0.0, -0.4 * side]), place, foot, standing)
    assert moved == pytest.approx([0.4, standing[1] + 0.22 * side])


def test_a_shift_that_is_allowed_stays_what_it_is():
    place, standing = (
        foothold(np.array([0.3, 0, 0]), LEFT, 0.23),
        foothold(np.zeros(3), RIGHT, 0.23),
    )
    shift = np.array([-0.5, 0.03])
    np.testing.assert_allclose(allowed_shift(shift, place, LEFT, standing), shift, atol=1e-15)


def test_a_foot_comes_to_rest_at_its_target_in_time():
    moved, rate, target = np.zeros(2), np.array([0.3, 0.0]), np.array([0.08, -0.05])
    for left in np.arange(0.3, 0, -PERIOD):
        rate = rate + PERIOD * approach(moved, rate, target, left)
        moved = moved + PERIOD * rate
    np.testing.assert_allclose(moved, target, atol=5e-4)
    np.testing.assert_allclose(rate, 0, atol=0.05)
