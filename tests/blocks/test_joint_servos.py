"""The joint servos: the delay of the bus, the limits, and the gains in the plant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant
from ticking import Ticking

from lola_drake.blocks.joint_servos import (
    JointServos,
    JointServosParams,
    limited_command,
    servo_gains,
    set_servo_gains,
)
from lola_drake.bus import MissedCycles
from lola_drake.robot import add_lola
from lola_drake.signals import JOINTS, PERIOD

N = len(JOINTS)
INITIAL = np.linspace(-0.5, 0.5, N)
SPEED, TORQUE = np.linspace(3.0, 8.0, N), np.linspace(50.0, 300.0, N)
LIMITS = np.r_[PERIOD * SPEED, SPEED, TORQUE]


class Bus(Ticking):
    """The block."""

    def __init__(self, delay_ticks=1, missed=()):
        params = JointServosParams(delay_ticks=delay_ticks, missed=missed)
        super().__init__(JointServos(params, SPEED, TORQUE, INITIAL))

    def step(self, q, q_dot, torque):
        self.fix("joint_command", np.concatenate([q, q_dot, torque]))
        super().step()

    def arrived(self):
        state, torque = self.output("joint_desired_state"), self.output("joint_feedforward")
        return state[:N], state[N:], torque


def test_joints_are_held_at_the_start():
    q, q_dot, torque = Bus(3).arrived()
    assert np.array_equal(q, INITIAL)
    assert not q_dot.any() and not torque.any()


@pytest.mark.parametrize("delay", [1, 2, 5])
def test_command_arrives_after_the_delay_and_whole(delay):
    bus = Bus(delay)
    for k in range(12):
        q, q_dot, torque = bus.arrived()
        sent = max(k - delay + 1, 0)
        assert q == pytest.approx(INITIAL + 1e-4 * sent)
        assert q_dot == pytest.approx(np.full(N, 0.1 * sent))
        assert torque == pytest.approx(np.full(N, 1.0 * sent))
        step = k + 1.0
        bus.step(INITIAL + 1e-4 * step, np.full(N, 0.1 * step), np.full(N, step))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_joint_moves_no_faster_than_its_limit(side):
    bus = Bus()
    for k in range(1, 20):
        bus.step(INITIAL + side, np.zeros(N), np.zeros(N))
        assert bus.arrived()[0] == pytest.approx(INITIAL + side * k * PERIOD * SPEED)


def test_slow_joint_arrives_where_it_shall():
    bus = Bus()
    for _ in range(20):
        bus.step(INITIAL + 0.03, np.zeros(N), np.zeros(N))
    assert np.array_equal(bus.arrived()[0], INITIAL + 0.03)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_speed_and_torque_end_at_their_limits(side):
    bus = Bus()
    bus.step(INITIAL, np.full(N, side * 100.0), np.full(N, side * 1e4))
    _, q_dot, torque = bus.arrived()
    assert np.array_equal(q_dot, side * SPEED)
    assert np.array_equal(torque, side * TORQUE)


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100))
def test_limited_command_is_within_every_limit(seed, size):
    random = np.random.default_rng(seed)
    command, sent = size * random.normal(size=3 * N), random.normal(size=N)
    limited = limited_command(command, sent, SPEED, TORQUE)
    assert (np.abs(limited[:N] - sent) <= PERIOD * SPEED + 1e-12).all()
    assert (np.abs(limited[N:]) <= LIMITS[N:]).all()


@given(st.integers(0, 2**32 - 1))
def test_command_within_the_limits_is_left_alone(seed):
    random = np.random.default_rng(seed)
    sent, part = random.normal(size=N), random.uniform(-0.99, 0.99, 3 * N)
    command = np.r_[sent, np.zeros(2 * N)] + part * LIMITS
    assert np.array_equal(limited_command(command, sent, SPEED, TORQUE), command)


def test_every_actuator_has_the_gains_of_its_rotor():
    plant = MultibodyPlant(time_step=PERIOD)
    add_lola(plant)
    plant.Finalize()
    params = JointServosParams(position_gain=50.0, velocity_bandwidth=600.0)
    set_servo_gains(plant, params)
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    assert [actuator.joint().name() for actuator in actuators] == list(JOINTS)
    for actuator in actuators:
        inertia = actuator.default_rotor_inertia() * actuator.default_gear_ratio() ** 2
        gains = actuator.get_controller_gains()
        assert inertia > 0
        assert gains.d == pytest.approx(600.0 * inertia)
        assert gains.p == pytest.approx(50.0 * gains.d)
    p, d = servo_gains(plant, params)
    assert p.tolist() == [actuator.get_controller_gains().p for actuator in actuators]
    assert d.tolist() == [actuator.get_controller_gains().d for actuator in actuators]


@pytest.mark.parametrize("delay", [1, 3])
def test_in_a_missed_cycle_nothing_arrives_and_what_is_under_way_moves_on(delay):
    bus, whole = Bus(delay, (MissedCycles(0.005, 2),)), Bus(delay)
    rows = []
    for k in range(12):
        command = INITIAL + 1e-4 * k, np.full(N, 0.01 * k), np.full(N, 0.1 * k)
        for each in (bus, whole):
            each.step(*command)
        rows.append([np.concatenate(each.arrived()) for each in (bus, whole)])
    for k, (found, expected) in enumerate(rows):
        # The cycles at 5 and 6 ms are missed: what arrived in the one before stays.
        np.testing.assert_array_equal(found, rows[4][1] if k in (5, 6) else expected)
