"""The joint servos: the bus delay, the limits, and the plant's implicit gains."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.multibody.plant import MultibodyPlant

from lola_drake.blocks.joint_servos import (
    JointServos,
    JointServosParams,
    limit_command,
    set_servo_gains,
)
from lola_drake.robot import add_lola

PERIOD, N = 0.001, 24
SPEED, TORQUE = np.linspace(1, 6, N), np.linspace(10, 300, N)
INITIAL = np.linspace(-1, 1, N)


def vectors(size, bound):
    return arrays(float, size, elements=st.floats(-bound, bound))


@given(vectors(72, 1e4), vectors(N, 3.0))
def test_command_stays_within_speeds_and_torques(command, sent):
    limits = np.concatenate([SPEED, TORQUE])
    got = limit_command(command, sent, PERIOD * SPEED, limits)
    assert np.all(np.abs(got[:N] - sent) <= PERIOD * SPEED * (1 + 1e-9))
    assert np.all(np.abs(got[N:]) <= limits)
    inside = np.abs(command - np.r_[sent, np.zeros(48)]) <= np.r_[PERIOD * SPEED, limits]
    np.testing.assert_allclose(got[inside], command[inside], atol=1e-12)


class Bus:
    """Servos that are stepped tick by tick."""

    def __init__(self, delay):
        params = JointServosParams(delay_ticks=delay)
        self.block = JointServos(params, SPEED, TORQUE, INITIAL, PERIOD)
        self.context = self.block.CreateDefaultContext()

    def outputs(self):
        names = ("joint_desired_state", "joint_feedforward")
        return np.concatenate([self.block.GetOutputPort(n).Eval(self.context) for n in names])

    def step(self, command):
        """Send a command; return what the servos hold in this tick."""
        self.block.GetInputPort("joint_command").FixValue(self.context, command)
        held = self.outputs()
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        return held


@pytest.mark.parametrize("delay", [1, 2, 5])
def test_command_arrives_after_the_delay(delay):
    bus = Bus(delay)
    rest = np.concatenate([INITIAL, np.zeros(2 * N)])
    np.testing.assert_array_equal(bus.outputs(), rest)
    sent = [rest + 1e-5 * (k + 1) for k in range(10)]
    held = [bus.step(command) for command in sent]
    np.testing.assert_array_equal(held[:delay], [rest] * delay)
    np.testing.assert_allclose(held[delay:], sent[:-delay], atol=1e-15)


def test_far_command_is_approached_at_the_greatest_speed():
    bus = Bus(1)
    for k in range(20):
        held = bus.step(np.concatenate([INITIAL + 1.0, np.zeros(2 * N)]))
        np.testing.assert_allclose(held[:N], INITIAL + k * PERIOD * SPEED, atol=1e-12)


def test_gains_are_a_position_loop_over_a_velocity_loop():
    plant = MultibodyPlant(PERIOD)
    add_lola(plant)
    params = JointServosParams(position_gain=50.0, velocity_bandwidth=200.0)
    set_servo_gains(plant, params)
    plant.Finalize()
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        gains = actuator.get_controller_gains()
        assert gains.d == pytest.approx(200.0 * actuator.default_reflected_inertia())
        assert gains.p == pytest.approx(50.0 * gains.d)
