"""The force sensors: sign, filter, noise."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce

from lola_drake.blocks.foot_force_sensor import FootForceSensor, FootForceSensorParams
from lola_drake.blocks.noise import Noise

PERIOD = 0.001
JOINTS = (2, 0)
QUIET = FootForceSensorParams(force_noise=0.0, torque_noise=0.0, cutoff=150.0)


def sensor(params, seed=0):
    """Return the block with sensors at the plant's joints 2 (left) and 0, and its context."""
    block = FootForceSensor(params, JOINTS, np.zeros(12), PERIOD, seed)
    return block, block.CreateDefaultContext()


def step(block, context, left, right):
    """Load the soles by [F, T] for one tick and return what is reported in the next one."""
    forces = [SpatialForce(tau=np.zeros(3), f=np.zeros(3)) for _ in range(3)]
    for joint, load in zip(JOINTS, (left, right), strict=True):
        # The plant reports the joint's force on the sole, the ground loads the joint.
        forces[joint] = SpatialForce(tau=-np.array(load[3:]), f=-np.array(load[:3]))
    port = block.GetInputPort("reaction_forces")
    port.FixValue(context, Value[list[SpatialForce]](forces))
    context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
    context.SetTime(context.get_time() + PERIOD)
    return block.GetOutputPort("measured_wrench").Eval(context).copy()


LEFT, RIGHT = np.array([1.0, 2, 300, 4, 5, 6]), np.array([-1.0, -2, 250, -4, -5, -6])


def test_ideal_sensors_report_the_load_on_the_soles_after_one_tick():
    block, context = sensor(QUIET.ideal())
    np.testing.assert_allclose(step(block, context, LEFT, RIGHT), [*LEFT, *RIGHT])


def test_starts_with_the_load_it_is_given():
    block = FootForceSensor(QUIET, JOINTS, np.arange(12.0), PERIOD, 0)
    context = block.CreateDefaultContext()
    np.testing.assert_array_equal(
        block.GetOutputPort("measured_wrench").Eval(context), np.arange(12.0)
    )


@pytest.mark.parametrize("cutoff", [20.0, 150.0])
def test_filter_is_of_first_order(cutoff):
    """A step is followed by 1 - exp(-2 pi f t), exact at the ticks."""
    block, context = sensor(FootForceSensorParams(0.0, 0.0, cutoff))
    reports = np.array([step(block, context, LEFT, RIGHT) for _ in range(30)])
    time = PERIOD * np.arange(1, 31)
    expected = (1 - np.exp(-2 * np.pi * cutoff * time))[:, None] * [*LEFT, *RIGHT]
    np.testing.assert_allclose(reports, expected, rtol=1e-12)


def reports(seed):
    block, context = sensor(FootForceSensorParams(2.0, 0.1, 0.0), seed)
    return np.array([step(block, context, LEFT, RIGHT) for _ in range(2000)]) - [*LEFT, *RIGHT]


def test_noise_is_as_declared_and_belongs_to_the_seed():
    first = reports(1)
    np.testing.assert_allclose(first.std(axis=0), [2, 2, 2, 0.1, 0.1, 0.1] * 2, rtol=0.1)
    np.testing.assert_array_equal(first, reports(1))
    assert not np.any(first == reports(2))


def test_noise_is_not_that_of_the_imu():
    """Both draw from the run's seed; their streams differ."""
    imu = Noise(np.ones(4), seed=1, stream=1)
    angle = np.array([imu(k) for k in range(2000)])
    force = reports(1)[:, :3] / 2.0
    assert np.abs(np.corrcoef(angle.T, force.T)[:4, 4:]).max() < 0.1
