"""Damping control against its equation: pole, return to the plan, steady error, and the feet."""

import numpy as np
import pytest
from one_foot import Foot, U

from lola_drake.blocks.damping_force_control import DampingForceControl, force_difference
from lola_drake.signals import DESIRED_WRENCH, GAIT_PHASE, MEASURED_WRENCH, PERIOD

D, D_Z, T_S = 40.0, 4000.0, 0.5


def foot_of(side="l"):
    foot = Foot(DampingForceControl, side, torque_damping=D, force_damping=D_Z, decay_time=T_S)
    foot.blend(1.0)
    return foot


@pytest.mark.parametrize("axis", [0, 1])
def test_the_torque_of_an_ideal_contact_follows_a_step_with_its_pole_and_steady_error(axis):
    """By the equation 1 / tau = |U| / D + 1 / T_s; what remains is D / (D + |U| T_s)."""
    foot, step, stiffness = foot_of(), 10.0, -U[axis, axis]
    wanted = np.eye(3)[axis] * step + [0.0, 0.0, 300.0]
    foot.desire(wanted)
    torques = []
    for _ in range(300):
        torque = -stiffness * foot.modification()[:2]
        torques.append(torque[axis])
        foot.press(300.0, torque)
        foot.step()
    rate = stiffness / D + 1 / T_S
    steady = step * stiffness / D / rate
    assert step - steady == pytest.approx(step * D / (D + stiffness * T_S))
    time = PERIOD * np.arange(300)
    np.testing.assert_allclose(torques, steady * (1 - np.exp(-rate * time)), atol=0.01 * step)
    assert np.diff(torques)[1] / np.diff(torques)[0] == pytest.approx(1 - PERIOD * rate)


def test_the_difference_of_both_feets_forces_follows_a_step_with_its_pole_and_steady_error():
    """Both feet are pressed by the ground; the difference is c (z_r - z_l)."""
    feet, step, stiffness = [foot_of("l"), foot_of("r")], 100.0, -U[2, 2]
    differences = []
    for foot in feet:
        foot.fix("gait_phase", 1.0, GAIT_PHASE.slice("support"))
        for side, force in enumerate((300.0 + step / 2, 300.0 - step / 2)):
            foot.fix("desired_wrench", force, 3 * side + 2)
    for _ in range(300):
        heights = [foot.modification()[2] for foot in feet]
        forces = [300.0 - stiffness * height for height in heights]
        differences.append(forces[0] - forces[1])
        for foot in feet:
            for side, force in enumerate(forces):
                foot.fix("measured_wrench", force, 6 * side + 2)
            foot.step()
    rate = stiffness / D_Z + 1 / T_S
    steady = step * stiffness / D_Z / rate
    time = PERIOD * np.arange(300)
    np.testing.assert_allclose(differences, steady * (1 - np.exp(-rate * time)), atol=0.02 * step)
    assert feet[0].modification()[2] == pytest.approx(-feet[1].modification()[2])
    assert feet[0].modification()[2] < 0, "the foot that is to carry more goes down"


@pytest.mark.parametrize("support", [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0)])
def test_without_double_support_nothing_controls_the_vertical_force(support):
    wanted, felt, phase = (np.zeros(s.size) for s in (DESIRED_WRENCH, MEASURED_WRENCH, GAIT_PHASE))
    wanted[2], phase[GAIT_PHASE.slice("support")] = 500.0, support
    assert force_difference(wanted, felt, phase, 0) == 0.0
    phase[GAIT_PHASE.slice("support")] = 1.0
    assert force_difference(wanted, felt, phase, 0) == 250.0
    assert force_difference(wanted, felt, phase, 1) == -250.0


def test_a_foot_without_error_returns_to_its_plan_within_its_time():
    foot = foot_of()
    foot.desire([0.0, 0.0, 300.0])
    foot.press(300.0)
    foot.set_state("task_modification", [0.1, -0.1, 0.02])
    foot.step(round(T_S / PERIOD))
    left = foot.modification() / [0.1, -0.1, 0.02]
    assert left == pytest.approx(np.full(3, np.exp(-1)), rel=2e-3)
