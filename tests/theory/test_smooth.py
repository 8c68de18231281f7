"""Transitions: their ends, their derivatives."""

import numpy as np
import pytest

from lola_drake.theory.smooth import bump, linear, quintic

INSIDE = np.linspace(0.001, 0.999, 500)
STEP = 1e-5


@pytest.mark.parametrize("transition", [quintic, linear])
def test_transitions_go_from_0_to_1_and_stay_there(transition):
    value, slope, _ = transition(np.array([-0.5, 0.0, 1.0, 1.5]))
    np.testing.assert_allclose(value, [0, 0, 1, 1], atol=1e-15)
    assert slope[0] == slope[-1] == 0
    assert np.all(np.diff(transition(INSIDE)[0]) > 0)


@pytest.mark.parametrize("transition", [quintic, linear])
def test_derivatives_are_those_of_the_value(transition):
    ahead, behind = transition(INSIDE + STEP), transition(INSIDE - STEP)
    _, slope, curvature = transition(INSIDE)
    np.testing.assert_allclose((ahead[0] - behind[0]) / (2 * STEP), slope, atol=1e-8)
    np.testing.assert_allclose((ahead[1] - behind[1]) / (2 * STEP), curvature, atol=1e-7)


def test_quintic_starts_and_ends_at_rest_and_without_acceleration():
    _, slope, curvature = quintic(np.array([0.0, 1.0]))
    np.testing.assert_array_equal(slope, 0)
    np.testing.assert_array_equal(curvature, 0)


def test_quintic_is_symmetric():
    np.testing.assert_allclose(quintic(INSIDE)[0] + quintic(1 - INSIDE)[0], 1, atol=1e-14)


def test_bump_rises_to_1_and_comes_back():
    tau = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(bump(tau), [0, 0, 1, 0, 0], atol=1e-15)
