"""The hybrid position/force control against the paper's equations 8, 14 and 15."""

import numpy as np
import pytest
from one_foot import Foot, U

from lola_drake.blocks.hybrid_force_control import (
    force_control_rate,
    held_time_constant,
    inverse_gradient,
)
from lola_drake.signals import PERIOD
from lola_drake.theory.contact_model import ServoCompliance, command_gradient


def test_error_of_an_ideal_contact_decays_with_the_time_constant():
    delta = 0.02
    wrench, desired = np.array([10.0, -5.0, 300.0]), np.array([0.0, 4.0, 400.0])
    start = desired - wrench
    for _ in range(round(delta / PERIOD)):
        held = held_time_constant(delta)
        rate = force_control_rate(np.linalg.inv(U), desired - wrench, np.zeros(3), held)
        wrench = wrench + PERIOD * U @ np.array(rate)
    ratio = (desired - wrench) / start
    assert ratio == pytest.approx(np.full(3, np.exp(-1)))


def test_the_gradient_is_that_of_pads_and_servos_in_series():
    servos = ServoCompliance(np.diag([1e-4, 1.5e-4, 1e-6]) + 1e-7, relaxation=0.014)
    inverse = inverse_gradient(np.linalg.inv(U), servos.matrix, servos.relaxation, 0.02)
    expected = command_gradient(U, servos.within(0.02))
    np.testing.assert_allclose(np.linalg.inv(inverse), expected, rtol=1e-9)
    assert (np.abs(np.diag(expected)) < np.abs(np.diag(U))).all()


def test_a_moving_desired_wrench_is_followed_without_lag():
    inverse, slope = np.linalg.inv(U), np.array([20.0, -30.0, 500.0])
    wrench = np.zeros(3)
    for _ in range(100):
        rate = force_control_rate(inverse, np.zeros(3), slope, 0.02)
        wrench = wrench + PERIOD * U @ np.array(rate)
    assert wrench == pytest.approx(0.1 * slope)


def test_the_block_lets_the_error_of_an_ideal_contact_decay():
    foot = Foot()
    foot.blend(1.0)
    foot.desire([0.0, 0.0, 310.0])
    for _ in range(20):
        foot.press(300.0 + U[2, 2] * foot.modification()[2])
        foot.step()
    left = 10.0 - U[2, 2] * foot.modification()[2]
    assert left / 10.0 == pytest.approx(np.exp(-1), rel=1e-6)


def test_more_desired_force_lowers_the_foot():
    foot = Foot()
    foot.blend(1.0)
    foot.press(300.0)
    foot.desire([0.0, 0.0, 400.0])
    foot.step()
    assert foot.modification()[2] < 0


def test_height_of_an_unloaded_foot_is_force_controlled():
    foot = Foot()
    foot.blend(1.0)
    foot.press(0.0)
    foot.desire([0.0, 0.0, 30.0])
    foot.step()
    assert foot.modification()[2] == pytest.approx((1 - np.exp(-PERIOD / 0.02)) * 30.0 / U[2, 2])
