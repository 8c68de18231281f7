"""The stabiliser: the torque against the inclination, the force against the sinking, limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ticking import Ticking

from lola_drake.blocks.imu_stabilizer import ImuStabilizer, ImuStabilizerParams
from lola_drake.signals import GAIT_PHASE

IDEAL = np.array([10.0, -20.0, 588.0, 4.0, -6.0, 2.0])
ANGLES = st.floats(-0.5, 0.5)
RATES = st.floats(-2, 2)
GAINS = {"stiffness": 1000.0, "damping": 200.0, "torque_limit": 100.0, "height_stiffness": 1500.0}


def added(orientation, sinking=0.0, **gains):
    lowered, law = (0.0, 0.0, sinking), ImuStabilizer.laws["modified_wrench"]
    wrench = law(
        IDEAL, orientation[:2], orientation[2:], (0.5, 0.5), lowered, lowered, **(GAINS | gains)
    )
    return np.array(wrench) - IDEAL


def output(orientation, left=0.0, right=0.0, load=(0.5, 0.5)):
    """Return the block's modified wrench for height modifications of the feet."""
    block = Ticking(ImuStabilizer(ImuStabilizerParams()))
    phase = np.zeros(GAIT_PHASE.size)
    phase[GAIT_PHASE.slice("load")] = load
    for name, value in (
        ("ideal_wrench", IDEAL),
        ("torso_orientation", orientation),
        ("gait_phase", phase),
        ("task_modification_l", [0.1, 0.1, left]),
        ("task_modification_r", [0.1, 0.1, right]),
    ):
        block.fix(name, value)
    return block.output("modified_wrench")


def test_upright_torso_at_its_height_changes_nothing():
    assert np.array_equal(output(np.zeros(4)), IDEAL)


@pytest.mark.parametrize("axis", [0, 1])
def test_torque_is_against_the_inclination(axis):
    orientation = np.zeros(4)
    orientation[axis] = 0.02
    expected = np.zeros(6)
    expected[3 + axis] = -20.0
    assert added(orientation) == pytest.approx(expected)


@pytest.mark.parametrize("axis", [0, 1])
def test_torque_is_against_the_rate_of_inclination(axis):
    orientation = np.zeros(4)
    orientation[2 + axis] = 0.1
    expected = np.zeros(6)
    expected[3 + axis] = -20.0
    assert added(orientation) == pytest.approx(expected)


@given(ANGLES, ANGLES, RATES, RATES)
def test_added_torque_is_limited(phi_x, phi_y, rate_x, rate_y):
    torque = added((phi_x, phi_y, rate_x, rate_y))[3:5]
    assert (np.abs(torque) <= GAINS["torque_limit"] + 1e-9).all()


@given(ANGLES, ANGLES, RATES, RATES)
def test_mirrored_inclination_gives_the_mirrored_torque(phi_x, phi_y, rate_x, rate_y):
    t_x, t_y = added((phi_x, phi_y, rate_x, rate_y))[3:5]
    mirrored = added((-phi_x, phi_y, -rate_x, rate_y))
    assert mirrored[3:5] == pytest.approx([-t_x, t_y], abs=1e-9)


@given(ANGLES, RATES)
def test_force_in_the_plane_and_torque_about_the_vertical_are_ideal(phi, rate):
    assert np.array_equal(added((phi, phi, rate, rate), sinking=0.01)[[0, 1, 5]], np.zeros(3))


def test_sunken_com_asks_for_more_force():
    assert added(np.zeros(4), sinking=0.01)[2] == pytest.approx(15.0)


def test_sinking_is_that_of_the_loaded_feet():
    change = output(np.zeros(4), left=0.01, right=-0.02, load=(0.75, 0.25)) - IDEAL
    expected = ImuStabilizerParams().height_stiffness * (0.75 * 0.01 - 0.25 * 0.02)
    assert change == pytest.approx([0.0, 0.0, expected, 0.0, 0.0, 0.0])


def test_swing_foot_has_no_part_in_the_sinking():
    assert np.array_equal(output(np.zeros(4), left=0.05, load=(0.0, 1.0)), IDEAL)
