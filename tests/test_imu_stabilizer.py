"""The local stabiliser: a limited PD control of the inclination, and the height feedback."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.blocks.imu_stabilizer import ImuStabilizer, ImuStabilizerParams, stabilize

IDEAL = np.array([1.0, 2.0, 600.0, 10.0, 20.0, 5.0])
GAINS = {"stiffness": 1200.0, "damping": 300.0, "torque_limit": 120.0, "height_stiffness": 1500.0}
orientations = st.tuples(*4 * [st.floats(-1.0, 1.0)])


def test_upright_robot_gets_the_ideal_wrench():
    np.testing.assert_array_equal(stabilize(IDEAL, np.zeros(4), 0.0, **GAINS), IDEAL)


def test_leaning_robot_is_turned_back():
    got = stabilize(IDEAL, np.array([0.01, -0.02, 0.02, 0.01]), 0.001, **GAINS)
    expected = IDEAL + [0, 0, 1.5, -(12 + 6), -(-24 + 3), 0]
    np.testing.assert_allclose(got, expected)


@given(orientations)
def test_torque_is_limited_and_nothing_else_changes(orientation):
    change = stabilize(IDEAL, orientation, 0.0, **GAINS) - IDEAL
    assert np.abs(change[3:5]).max() <= GAINS["torque_limit"] + 1e-9
    np.testing.assert_array_equal(change[[0, 1, 2, 5]], 0)


@given(orientations)
def test_law_is_odd_in_the_inclination(orientation):
    change = stabilize(np.zeros(6), orientation, 0.0, **GAINS)
    np.testing.assert_allclose(
        stabilize(np.zeros(6), [-x for x in orientation], 0.0, **GAINS), -change
    )


@pytest.fixture
def block():
    block = ImuStabilizer(ImuStabilizerParams(**GAINS))
    context = block.CreateDefaultContext()
    inputs = {
        "ideal_wrench": IDEAL,
        "torso_orientation": [0.01, 0.0, 0.0, 0.0],
        "gait_phase": [1, 1, 0.25, 0.75, 1, 1, 0, 0],
        "task_modification_l": [0, 0, 0.004],
        "task_modification_r": [0, 0, -0.001],
    }
    for name, value in inputs.items():
        block.GetInputPort(name).FixValue(context, np.array(value, dtype=float))
    return block, context


def test_height_is_that_of_the_loaded_feet(block):
    block, context = block
    modified = block.GetOutputPort("modified_wrench").Eval(context)
    assert modified[2] == pytest.approx(600 + 1500 * (0.25 * 0.004 - 0.75 * 0.001))


def test_gains_are_turned_without_a_rebuild(block):
    block, context = block
    context.get_mutable_numeric_parameter(0).SetAtIndex(0, 0.0)
    modified = block.GetOutputPort("modified_wrench").Eval(context)
    assert modified[3] == IDEAL[3]
