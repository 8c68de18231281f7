"""Step adaptation against the pendulum's own equation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.signals import PERIOD
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import LEFT, RIGHT, foothold, sole
from lola_drake.theory.step_adaptation import DEAD, MOST, allowed_shift, approach, capture_shift

HEIGHT = 0.87
OMEGA = np.sqrt(GRAVITY / HEIGHT)
NOTHING = np.zeros(2)


def test_a_pushed_pendulum_is_taken_up_by_the_moved_foothold():
    """The CoM that leaves its plan by c, c' stands over the moved foothold as the planned one."""
    time_left, c, v = 0.3, 0.004, 0.05
    shift = capture_shift(np.array([0, c / HEIGHT]), np.array([0, v / HEIGHT]), HEIGHT, time_left)
    # x'' = omega^2 x of the deviation, exactly.
    end = c * np.cosh(OMEGA * time_left) + v / OMEGA * np.sinh(OMEGA * time_left)
    speed = c * OMEGA * np.sinh(OMEGA * time_left) + v * np.cosh(OMEGA * time_left)
    assert shift[0] + DEAD == pytest.approx(end + speed / OMEGA)
    assert shift[1] == pytest.approx(0, abs=1e-15)


def test_the_torso_falls_to_the_right_about_x_and_forward_about_y():
    right = capture_shift(np.array([0.03, 0.0]), NOTHING, HEIGHT, 0.2)
    forward = capture_shift(NOTHING, np.array([0.0, 0.1]), HEIGHT, 0.2)
    assert right[0] == 0 and right[1] < 0
    assert forward[0] > 0 and forward[1] == 0


def test_small_deviations_move_nothing_and_great_ones_no_more_than_allowed():
    assert not capture_shift(np.array([0.0, 0.005]), NOTHING, HEIGHT, 0.4).any()
    assert not capture_shift(NOTHING, NOTHING, HEIGHT, 0.4).any()
    great = capture_shift(np.array([-0.3, 0.2]), NOTHING, HEIGHT, 0.4)
    assert np.linalg.norm(great) == pytest.approx(MOST)
    assert great[1] / great[0] == pytest.approx(1.5)


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


def test_a_shift_that_is_allowed_stays_what_it_is():
    place, standing = (
        foothold(np.array([0.3, 0, 0]), LEFT, 0.23),
        foothold(np.zeros(3), RIGHT, 0.23),
    )
    shift = np.array([0.05, 0.03])
    np.testing.assert_allclose(allowed_shift(shift, place, LEFT, standing), shift, atol=1e-15)


def test_a_foot_comes_to_rest_at_its_target_in_time():
    moved, rate, target = np.zeros(2), np.array([0.3, 0.0]), np.array([0.08, -0.05])
    for left in np.arange(0.3, 0, -PERIOD):
        rate = rate + PERIOD * approach(moved, rate, target, left)
        moved = moved + PERIOD * rate
    np.testing.assert_allclose(moved, target, atol=5e-4)
    np.testing.assert_allclose(rate, 0, atol=0.05)
