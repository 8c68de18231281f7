"""Force control with two degrees of freedom against its equation: lag, poles, steady error."""

import numpy as np
import pytest
from one_foot import Foot, U

from lola_drake.blocks.two_dof_force_control import TwoDofForceControl
from lola_drake.signals import PERIOD

REST = np.array([0.0, 0.0, 300.0])
TAU, DELTA, K_I = 0.03, 0.02, 400.0


def foot_at_rest(k_i=K_I):
    foot = Foot(TwoDofForceControl, reference_time=TAU, time_constant=DELTA, integral_gain=k_i)
    foot.blend(1.0)
    foot.desire(REST)
    foot.press(REST[2])
    foot.set_state("reference_wrench", REST)
    return foot


def response(foot, ticks, wrench_of):
    """Return the wrench in each tick, less that at rest, shape (ticks, 3)."""
    wrenches = []
    for k in range(ticks):
        wrench = wrench_of(foot.modification(), k)
        wrenches.append(wrench - REST)
        foot.press(wrench[2], wrench[:2])
        foot.step()
    return np.array(wrenches)


def test_an_ideal_contact_follows_a_step_behind_the_lag_alone():
    """Whatever the integral: what is desired and what disturbs are apart."""
    foot, step, time = foot_at_rest(), np.array([6.0, -5.0, 40.0]), PERIOD * np.arange(200)
    foot.desire(REST + step)
    found = response(foot, len(time), lambda delta, k: REST + U @ delta)
    expected = np.outer(1 - np.exp(-time / TAU), step)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(step).max())


@pytest.mark.parametrize("k_i", [0.0, 400.0, 1000.0])
def test_an_error_dies_out_with_the_poles_of_its_dynamics(k_i):
    """Of e'' + e' / delta + k_i e = 0, from an error that the ground makes at once."""
    foot, error, time = foot_at_rest(k_i), np.array([3.0, -4.0, 30.0]), PERIOD * np.arange(300)
    found = response(foot, len(time), lambda delta, k: REST + error + U @ delta)
    fast, slow = np.roots([1.0, 1 / DELTA, k_i])
    # e(0) = 1, e'(0) = -1 / delta, which is the sum of the poles.
    expected = ((fast * np.exp(fast * time) - slow * np.exp(slow * time)) / (fast - slow)).real
    np.testing.assert_allclose(found / error, np.tile(expected, (3, 1)).T, atol=0.02)


def test_ground_that_moves_steadily_leaves_no_error():
    drift = U @ [0.05, -0.02, 0.004]

    def ground(delta, k):
        return REST + U @ delta + PERIOD * k * drift

    left = {k_i: response(foot_at_rest(k_i), 1000, ground)[-1] for k_i in (0.0, K_I)}
    assert left[0.0] == pytest.approx(DELTA * drift, rel=0.03)
    np.testing.assert_allclose(left[K_I], 0.0, atol=0.01 * np.abs(left[0.0]).min())


def test_the_integral_is_forgotten_where_the_foot_is_not_force_controlled():
    foot = foot_at_rest()
    foot.press(200.0, (5.0, 5.0))
    foot.step(10)
    assert np.abs(foot.state("wrench_integral")).min() > 0.01
    foot.blend(0.0)
    foot.step()
    assert not foot.state("wrench_integral").any()
    foot.blend(1.0)
    foot.press(0.0)
    foot.step(10)
    assert not foot.state("wrench_integral").any(), "an unloaded foot may only seek the ground"
