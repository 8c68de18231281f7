"""The CoM that belongs to a ZMP: the pendulum's equation, its ends, and the spline's smoothness."""

import numpy as np
import pytest

from lola_drake.theory.com_trajectory import KnotSpline, solve_com
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.smooth import bump, quintic

STEP = 0.01
TIME = STEP * np.arange(301)
STIFFNESS = np.full(len(TIME), GRAVITY / 0.87)
VARYING = STIFFNESS * (1 + 0.05 * np.sin(4 * TIME))
SHAPE = bump(TIME / 0.3)
START, VELOCITY = np.array([0.01, 0.02]), np.array([0.1, -0.2])


def wanted_zmp():
    forward = 0.3 * quintic((TIME - 0.3) / 0.5)[0] + 0.3 * quintic((TIME - 1.1) / 0.5)[0]
    sideways = 0.08 * (quintic(TIME / 0.3)[0] - quintic((TIME - 0.8) / 0.3)[0])
    return np.column_stack([forward, sideways])


ZMP = wanted_zmp()


@pytest.fixture(scope="module", params=[STIFFNESS, VARYING], ids=["constant", "varying"])
def solved(request):
    com, amplitude = solve_com(STEP, request.param, ZMP, SHAPE, START, VELOCITY)
    return request.param, com, ZMP + SHAPE[:, None] * amplitude


def test_pendulum_equation_holds_in_the_knots(solved):
    stiffness, com, zmp = solved
    expected = stiffness[:, None] * (com.position - zmp)
    assert com.acceleration == pytest.approx(expected, abs=1e-9)


def test_begins_where_it_is_told(solved):
    _, com, _ = solved
    position, velocity, _ = com(np.zeros(1))
    assert position[0] == pytest.approx(START)
    assert velocity[0] == pytest.approx(VELOCITY)


def test_ends_on_the_stable_motion(solved):
    stiffness, com, zmp = solved
    stable = -np.sqrt(stiffness[-1]) * (com.position[-1] - zmp[-1])
    assert com.velocity[-1] == pytest.approx(stable, abs=1e-9)


def test_com_comes_to_rest_over_the_last_zmp(solved):
    _, com, zmp = solved
    assert com.position[-1] == pytest.approx(zmp[-1], abs=0.01)


def test_spline_goes_through_its_knots(solved):
    _, com, _ = solved
    position, velocity, acceleration = com(TIME)
    assert position == pytest.approx(com.position, abs=1e-9)
    assert velocity == pytest.approx(com.velocity, abs=1e-9)
    assert acceleration == pytest.approx(com.acceleration, abs=1e-6)


@pytest.mark.parametrize("derivative", [0, 1, 2])
def test_spline_is_continuous_to_the_acceleration(solved, derivative):
    _, com, _ = solved
    knots, gap = TIME[1:-1], 1e-9
    before, after = com(knots - gap)[derivative], com(knots + gap)[derivative]
    assert before == pytest.approx(after, abs=1e-6)


@pytest.mark.parametrize("derivative", [1, 2])
def test_derivatives_are_those_of_the_position(solved, derivative):
    _, com, _ = solved
    between, h = TIME[:-1] + STEP / 3, 1e-4
    difference = (com(between + h)[derivative - 1] - com(between - h)[derivative - 1]) / (2 * h)
    assert com(between)[derivative] == pytest.approx(difference, abs=1e-4)


def test_amplitude_is_zero_for_a_start_that_fits():
    com, amplitude = solve_com(STEP, STIFFNESS, ZMP, SHAPE, START, VELOCITY)
    corrected = ZMP + SHAPE[:, None] * amplitude
    _, again = solve_com(STEP, STIFFNESS, corrected, SHAPE, com.position[0], com.velocity[0])
    assert np.abs(amplitude).min() > 1e-3
    assert again == pytest.approx([0.0, 0.0], abs=1e-12)


def test_standing_over_the_zmp_stays():
    zmp = np.tile([0.1, -0.05], (len(TIME), 1))
    com, amplitude = solve_com(STEP, STIFFNESS, zmp, SHAPE, zmp[0], np.zeros(2))
    assert com.position == pytest.approx(zmp, abs=1e-12)
    assert amplitude == pytest.approx([0.0, 0.0], abs=1e-12)


def test_decay_is_that_of_the_pendulum():
    rate = np.sqrt(STIFFNESS[0])
    start = np.array([0.05])
    zmp = np.zeros((len(TIME), 1))
    com, amplitude = solve_com(STEP, STIFFNESS, zmp, SHAPE, start, -rate * start)
    assert com.position[:, 0] == pytest.approx(0.05 * np.exp(-rate * TIME), abs=1e-5)
    assert amplitude == pytest.approx([0.0], abs=1e-4)


def test_pushed_com_moves_the_zmp_the_same_way():
    zmp = np.zeros((len(TIME), 2))
    _, amplitude = solve_com(STEP, STIFFNESS, zmp, SHAPE, np.zeros(2), np.array([0.1, -0.2]))
    assert amplitude[0] > 0
    assert amplitude[1] == pytest.approx(-2 * amplitude[0])


def test_axes_are_independent():
    both, _ = solve_com(STEP, VARYING, ZMP, SHAPE, START, VELOCITY)
    alone, _ = solve_com(STEP, VARYING, ZMP[:, 1:], SHAPE, START[1:], VELOCITY[1:])
    assert alone.position[:, 0] == pytest.approx(both.position[:, 1], abs=1e-12)


def test_finer_knots_give_the_same_motion():
    coarse, _ = solve_com(2 * STEP, STIFFNESS[::2], ZMP[::2], SHAPE[::2], START, VELOCITY)
    fine, _ = solve_com(STEP, STIFFNESS, ZMP, SHAPE, START, VELOCITY)
    assert coarse.position == pytest.approx(fine.position[::2], abs=2e-4)


@pytest.mark.parametrize("knot", [30, 57, 80])
def test_plan_made_anew_continues_the_last(knot):
    first, _ = solve_com(STEP, STIFFNESS, ZMP, SHAPE, START, VELOCITY)
    shape = bump((TIME[knot:] - TIME[knot]) / 0.3)
    position, velocity, _ = first(TIME[[knot]])
    following, amplitude = solve_com(
        STEP, STIFFNESS[knot:], ZMP[knot:], shape, position[0], velocity[0]
    )
    assert following.velocity[0] == pytest.approx(velocity[0])
    # Nothing new is known, so nothing is to be corrected.
    assert amplitude == pytest.approx([0.0, 0.0], abs=1e-9)
    assert following.position == pytest.approx(first.position[knot:], abs=1e-9)


def test_plan_with_new_steps_begins_with_the_same_velocity():
    first, _ = solve_com(STEP, STIFFNESS, ZMP, SHAPE, START, VELOCITY)
    position, velocity, _ = first(np.array([0.8]))
    longer = ZMP + 0.3 * quintic((TIME - 1.0) / 0.5)[0][:, None]
    following, amplitude = solve_com(STEP, STIFFNESS, longer, SHAPE, position[0], velocity[0])
    assert following.velocity[0] == pytest.approx(velocity[0])
    assert following.velocity[1] == pytest.approx(velocity[0], abs=0.1)
    assert np.abs(amplitude).max() > 1e-3


def test_spline_of_a_cubic_is_the_cubic():
    t = np.arange(4.0)[:, None]
    spline = KnotSpline(1.0, t**3, 3 * t**2, 6 * t)
    assert spline(np.array([1.5]))[0] == pytest.approx(np.array([[1.5**3]]))
