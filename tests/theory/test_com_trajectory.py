"""The CoM spline fulfils the pendulum's equation, its boundary conditions, and is smooth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.theory.com_trajectory import solve_com
from lola_drake.theory.smooth import bump

STEP = 0.01
TIME = np.arange(0.0, 3.0, STEP)
OMEGA = 3.3


def walk(position=(0.0, 0.02), velocity=(0.1, -0.05)):
    """Return the spline over a ZMP that goes from foot to foot, and what made it."""
    zmp = np.column_stack([0.3 * np.floor(TIME), 0.1 * np.sign(np.sin(3 * TIME))])
    stiffness = OMEGA**2 * (1 + 0.05 * np.sin(5 * TIME))
    shape = bump(TIME / 0.4)
    spline, amplitude = solve_com(
        STEP, stiffness, zmp, shape, np.array(position), np.array(velocity)
    )
    return spline, zmp + shape[:, None] * amplitude, stiffness


def test_equation_holds_in_every_knot():
    com, zmp, stiffness = walk()
    expected = stiffness[:, None] * (com.position - zmp)
    np.testing.assert_allclose(com.acceleration, expected, rtol=0, atol=1e-10)


@given(*2 * [st.tuples(*2 * [st.floats(-0.3, 0.3)])])
def test_starts_where_and_as_fast_as_it_should(position, velocity):
    com, _, _ = walk(position, velocity)
    np.testing.assert_allclose(com.position[0], position, atol=1e-12)
    np.testing.assert_allclose(com.velocity[0], velocity, atol=1e-12)


def test_ends_on_the_stable_motion():
    com, zmp, stiffness = walk()
    stable = -np.sqrt(stiffness[-1]) * (com.position[-1] - zmp[-1])
    np.testing.assert_allclose(com.velocity[-1], stable, atol=1e-9)


def test_spline_is_smooth_through_its_knots():
    """Position and velocity at the end of each piece are those at the start of the next."""
    com, _, _ = walk()
    end = np.nextafter(TIME[1:-1], 0) - 1e-12
    for before, knot in zip(com(end), (com.position, com.velocity, com.acceleration), strict=True):
        np.testing.assert_allclose(before, knot[1:-1], atol=1e-9)


def test_velocity_and_acceleration_are_derivatives():
    com, _, _ = walk()
    time, h = np.linspace(0.015, 2.8, 400), 1e-5
    (ahead, v_ahead, _), (behind, v_behind, _) = com(time + h), com(time - h)
    _, velocity, acceleration = com(time)
    np.testing.assert_allclose((ahead - behind) / (2 * h), velocity, atol=1e-8)
    np.testing.assert_allclose((v_ahead - v_behind) / (2 * h), acceleration, atol=1e-3)


def test_standing_needs_no_shift_of_the_zmp():
    zmp = np.full((len(TIME), 2), 0.1)
    stiffness = np.full(len(TIME), OMEGA**2)
    com, amplitude = solve_com(STEP, stiffness, zmp, bump(TIME), zmp[0], np.zeros(2))
    np.testing.assert_allclose(com.position, 0.1, atol=1e-14)
    np.testing.assert_allclose(amplitude, 0, atol=1e-12)


def test_without_a_change_of_the_zmp_the_pendulum_falls_onto_it():
    """From the stable start c' = -omega c, the exact solution is an exponential."""
    zmp, stiffness = np.zeros((len(TIME), 1)), np.full(len(TIME), OMEGA**2)
    com, amplitude = solve_com(
        STEP, stiffness, zmp, bump(TIME / 0.4), np.array([0.1]), np.array([-0.1 * OMEGA])
    )
    np.testing.assert_allclose(com.position[:, 0], 0.1 * np.exp(-OMEGA * TIME), atol=1e-5)
    assert amplitude == pytest.approx(0, abs=1e-4)
