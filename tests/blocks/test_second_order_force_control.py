"""Impedance control against its equation: frequency, damping and steady error of a contact."""

import numpy as np
import pytest
from one_foot import Foot, U

from lola_drake.blocks.second_order_force_control import SecondOrderForceControl, impedance_rate
from lola_drake.signals import PERIOD


def response(step, ticks, **params):
    """Return the wrench of an ideal contact after a step of the desired one, shape (ticks, 3)."""
    foot = Foot(SecondOrderForceControl, **params)
    foot.blend(1.0)
    rest = np.array([0.0, 0.0, 300.0])
    foot.desire(rest + step)
    wrenches = []
    for _ in range(ticks):
        wrench = rest + U @ foot.modification()
        wrenches.append(wrench - rest)
        foot.press(wrench[2], wrench[:2])
        foot.step()
    return np.array(wrenches)


def step_response(time, m, d, k):
    """Return the solution of m y'' + d y' + (1 + k) y = 1 from rest."""
    omega, sigma = np.sqrt((1 + k) / m), d / (2 * m)
    omega_d = np.sqrt(omega**2 - sigma**2)
    swing = np.cos(omega_d * time) + sigma / omega_d * np.sin(omega_d * time)
    return (1 - np.exp(-sigma * time) * swing) / (1 + k)


STEP = np.array([6.0, -5.0, 40.0])
TIME = PERIOD * np.arange(400)


@pytest.mark.parametrize(
    ("m", "d", "k"), [(0.002, 0.04, 0.1), (0.01, 0.05, 0.5), (0.005, 0.1, 0.0)]
)
def test_an_ideal_contact_answers_in_all_directions_as_the_impedance_says(m, d, k):
    found = response(STEP, len(TIME), inertia=m, damping=d, stiffness=k)
    expected = step_response(TIME, m, d, k)
    np.testing.assert_allclose(found / STEP, np.tile(expected, (3, 1)).T, atol=0.02)


def test_what_the_spring_keeps_of_a_step_is_its_part_of_the_stiffness():
    found = response(STEP, 1000, inertia=1e-4, damping=0.02, stiffness=0.25)[-1]
    assert STEP - found == pytest.approx(STEP * 0.25 / 1.25, rel=1e-6)


def test_without_mass_and_spring_the_error_decays_with_the_damping():
    found = response(STEP, 21, inertia=0.0, damping=0.02, stiffness=0.0)
    assert (STEP - found[1]) / STEP == pytest.approx(np.full(3, 1 - PERIOD / 0.02))


def test_a_mass_keeps_its_speed_and_a_spring_pulls_it_back():
    assert impedance_rate(0.2, 0.0, 0.0, 1.0, 0.0, 0.0) == 0.2
    assert impedance_rate(0.0, 0.0, 0.1, 1.0, 0.0, 2.0) == pytest.approx(-0.2 * PERIOD)
    assert impedance_rate(0.0, 0.3, 0.0, 1.0, 0.0, 2.0) == pytest.approx(0.3 * PERIOD)


def test_a_foot_that_is_taken_back_to_its_plan_brings_no_speed_along():
    foot = Foot(SecondOrderForceControl)
    foot.blend(1.0)
    foot.press(300.0)
    foot.desire([5.0, 5.0, 500.0])
    foot.step(20)
    assert np.abs(foot.state("yielding")).min() > 1e-4
    foot.blend(0.0)
    foot.step()
    assert not foot.state("yielding").any()


def test_at_a_limit_it_has_no_speed_into_it():
    foot = Foot(SecondOrderForceControl)
    foot.blend(1.0)
    foot.press(300.0)
    foot.desire([0.0, 0.0, 9000.0])
    foot.step(300)
    assert foot.modification()[2] == pytest.approx(-0.08)
    assert foot.state("yielding")[2] == pytest.approx(0.0, abs=1e-9)
    foot.desire([0.0, 0.0, 0.0])
    foot.step(10)
    assert foot.modification()[2] > -0.08
