"""The hybrid position/force control of one foot: eq. 10 to 17 and 21."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from lola_drake.blocks.hybrid_force_control import (
    FORCE_CONTROLLED,
    FootSensor,
    HybridForceControl,
    HybridForceControlParams,
    force_control_rate,
    limited_rate,
    modification_rate,
    wrench_at_tcp,
)
from lola_drake.robot import PADS, foot_angles
from lola_drake.theory.contact_model import contact_matrix

PERIOD = 0.001
SENSOR = FootSensor(p_TcpSensor=(-0.04, 0.0, 0.055), weight=12.0, p_TcpFoot=(0.02, 0.0, 0.03))
U = contact_matrix(PADS, 1.2e5 / sum(pad.area for pad in PADS))
numbers = st.floats(-1.0, 1.0)
triples = st.tuples(*3 * [numbers])
angles = st.floats(-0.05, 0.05)


@given(triples, triples, angles, angles, st.floats(-1.0, 1.0))
def test_wrench_at_the_tcp_is_that_of_the_rigid_foot(force, torque, roll, pitch, yaw):
    """A_TF moves the wrench to the TCP and turns it to T, to first order in the inclination."""
    rotation = RollPitchYaw(roll, pitch, yaw).ToRotationMatrix().matrix()
    moment = np.add(torque, np.cross(SENSOR.p_TcpSensor, force))
    weight = np.array([0.0, 0.0, SENSOR.weight])
    expected_force = rotation @ force + weight
    expected_torque = rotation @ moment + np.cross(rotation @ SENSOR.p_TcpFoot, weight)
    got = wrench_at_tcp([*force, *torque], foot_angles(rotation), SENSOR)
    expected = [*expected_torque[:2], expected_force[2]]
    scale = (abs(roll) + abs(pitch)) * SENSOR.weight * 0.05 + 3 * (roll**2 + pitch**2)
    np.testing.assert_allclose(got, expected, atol=scale + 1e-9)


def test_foot_in_the_air_has_no_contact_wrench():
    """At rest the sensor then carries the foot's weight, hanging from it."""
    hanging = np.array([0.0, 0.0, -SENSOR.weight])
    lever = np.subtract(SENSOR.p_TcpFoot, SENSOR.p_TcpSensor)
    measured = [*hanging, *np.cross(lever, hanging)]
    np.testing.assert_allclose(wrench_at_tcp(measured, (0.0, 0.0, 0.4), SENSOR), 0, atol=1e-12)


@given(triples, triples)
def test_ideal_contact_follows_the_error_dynamics_of_equation_14(error, desired_rate):
    """With lambda = U x, the law makes e' = -e / delta."""
    delta = 0.02
    rate = force_control_rate(np.linalg.inv(U), np.array(error), np.array(desired_rate), delta)
    error_rate = np.array(desired_rate) - U @ rate
    np.testing.assert_allclose(error_rate, -np.array(error) / delta, atol=1e-9)


@given(*3 * [numbers])
def test_blend_goes_from_position_to_force_control(force_rate, com_rate, deviation):
    forces = modification_rate(force_rate, com_rate, deviation, 1.0, 6.0)
    position = modification_rate(force_rate, com_rate, deviation, 0.0, 6.0)
    half = modification_rate(force_rate, com_rate, deviation, 0.5, 6.0)
    assert forces == pytest.approx(force_rate + com_rate)
    assert position == pytest.approx(-6.0 * deviation)
    assert half == pytest.approx((forces + position) / 2)


@given(st.floats(-100, 100), st.floats(-0.25, 0.25))
def test_modification_stays_within_its_limits(rate, deviation):
    limited = limited_rate(rate, deviation, 0.25, 2.0, PERIOD)
    assert abs(limited) <= 2.0
    assert abs(deviation + PERIOD * limited) <= 0.25 * (1 + 1e-12)
    inside = abs(rate) <= 2.0 and abs(deviation + PERIOD * rate) <= 0.25
    assert not inside or limited == pytest.approx(rate, abs=1e-12)


class Foot:
    """The left foot's force control, stepped tick by tick."""

    def __init__(self, **params):
        self.params = HybridForceControlParams(**params)
        self.block = HybridForceControl(self.params, "l", U, SENSOR, PERIOD)
        self.context = self.block.CreateDefaultContext()
        self.reference = 0.01 * np.arange(28.0)
        self.reference[3:6] = 0.0
        self.blend, self.desired, self.com_rate = 1.0, np.zeros(12), np.zeros(3)
        self.orientation, self.measured = np.zeros(4), np.zeros(12)
        self.press([0.0, 0.0, 300.0])

    def press(self, wrench):
        """Let the sensor report a ground that presses with T_x, T_y, F_z on a level foot."""
        t_x, t_y, f_z = wrench
        x, y, _ = SENSOR.p_TcpSensor
        c_x, c_y, _ = SENSOR.p_TcpFoot
        force = f_z - SENSOR.weight
        self.measured[2] = force
        self.measured[3] = t_x - y * force - SENSOR.weight * c_y
        self.measured[4] = t_y + x * force + SENSOR.weight * c_x

    def fix(self):
        inputs = {
            "task_reference": self.reference,
            "gait_phase": np.array([1, 1, 1, 0, self.blend, 1, 0, 0], dtype=float),
            "desired_wrench": self.desired,
            "measured_wrench": self.measured,
            "com_dynamics_rate": self.com_rate,
            "torso_orientation": self.orientation,
        }
        for name, value in inputs.items():
            self.block.GetInputPort(name).FixValue(self.context, value)

    def output(self, name):
        return self.block.GetOutputPort(name).Eval(self.context).copy()

    def step(self):
        """Return Delta w after one more tick."""
        self.fix()
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        return self.output("task_modification")


def test_command_is_the_reference_where_nothing_is_to_be_done():
    foot = Foot()
    foot.desired[2] = 300.0
    foot.fix()
    np.testing.assert_allclose(foot.output("contact_wrench"), [0, 0, 300], atol=1e-9)
    np.testing.assert_allclose(
        foot.output("task_command"), [*foot.reference[:6], *foot.reference[14:20]], atol=1e-12
    )


def test_error_of_an_ideal_contact_decays_with_delta():
    """Closed over lambda = U x, the error shrinks by 1 - T/delta in every tick."""
    foot = Foot(time_constant=0.02)
    start = np.array([0.0, 0.0, 280.0])
    foot.desired[:3] = [2.0, -1.5, 300.0]
    errors = []
    for _ in range(60):
        delta = foot.output("task_modification")
        contact = start + U @ delta
        foot.press(contact)
        foot.reference[3:5] = -delta[:2]  # a level foot, so that the sensor's frame is T's
        errors.append(foot.desired[:3] - contact)
        foot.step()
    factors = np.array(errors[1:]) / np.array(errors[:-1])
    np.testing.assert_allclose(factors, 1 - PERIOD / 0.02, rtol=1e-6)


def test_swing_foot_returns_to_the_plan():
    foot = Foot(position_gain=6.0)
    foot.desired[2] = 320.0
    for _ in range(20):
        away = foot.step()
    foot.blend = 0.0
    back = np.array([foot.step() for _ in range(10)])
    np.testing.assert_allclose(back, away * 0.994 ** np.arange(1, 11)[:, None], atol=1e-12)


def test_unloaded_foot_is_leveled_against_the_inclination():
    foot = Foot(leveling=1.0)
    foot.blend, foot.orientation[:2] = 0.0, [0.05, -0.02]
    for _ in range(2000):
        delta = foot.step()
    np.testing.assert_allclose(delta, [-0.05, 0.02, 0.0], atol=1e-5)


def test_torques_are_controlled_only_under_load():
    foot = Foot(grip_force=50.0)
    foot.desired[:3] = [3.0, 3.0, 0.0]
    foot.press([0.0, 0.0, 0.0])
    foot.fix()
    rates = foot.output("task_command")[6:] - foot.reference[14:20]
    np.testing.assert_allclose(rates[FORCE_CONTROLLED], 0, atol=1e-9)


def test_modification_is_limited_and_leaves_its_limit_without_delay():
    foot = Foot(max_height=0.01)
    foot.press([0.0, 0.0, 600.0])
    for _ in range(500):
        delta = foot.step()
    assert delta[2] == pytest.approx(foot.params.max_height)
    foot.press([0.0, 0.0, 0.0])
    foot.desired[2] = 600.0
    assert foot.step()[2] < delta[2]


def test_com_dynamics_add_to_the_rate():
    foot = Foot()
    foot.desired[2] = 300.0
    foot.com_rate = np.array([0.1, -0.2, 0.05])
    foot.fix()
    rates = foot.output("task_command")[6:] - foot.reference[14:20]
    np.testing.assert_allclose(rates[FORCE_CONTROLLED], foot.com_rate, atol=1e-9)


def test_gains_are_turned_without_a_rebuild():
    foot = Foot(time_constant=0.02)
    foot.desired[2] = 310.0
    foot.fix()
    slow = foot.output("task_command")[8] - foot.reference[16]
    foot.context.get_mutable_numeric_parameter(0).SetAtIndex(0, 0.01)
    fast = foot.output("task_command")[8] - foot.reference[16]
    assert fast == pytest.approx(2 * slow)
