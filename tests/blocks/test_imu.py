"""The IMU: inclination at any heading, delay, bias and noise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw
from ticking import Ticking

from lola_drake.blocks.imu import Imu, ImuParams, inclination, sample

STATE_SIZE = 61
LEAN = st.floats(-1.2, 1.2)
HEADING = st.floats(-np.pi, np.pi)
RATE = st.floats(-3, 3)


class Torso(Ticking):
    """The unit in a torso."""

    def __init__(self, params, seed=0):
        super().__init__(Imu(params, seed))

    def step(self, roll=0.0, pitch=0.0, heading=0.0, rates=(0.0, 0.0, 0.0)):
        state = np.zeros(STATE_SIZE)
        state[:4] = quaternion(roll, pitch, heading)
        state[31:34] = rates
        self.fix("plant_state", state)
        super().step()
        return self.reading()

    def reading(self):
        return self.output("torso_orientation")

    def upright(self, count):
        return np.array([self.step() for _ in range(count)])


def quaternion(roll, pitch, heading):
    return RollPitchYaw(roll, pitch, heading).ToQuaternion().wxyz()


@given(LEAN, LEAN, HEADING)
def test_inclination_is_roll_and_pitch_at_any_heading(roll, pitch, heading):
    found = inclination(quaternion(roll, pitch, heading), (0.0, 0.0, 0.0))
    assert found == pytest.approx([roll, pitch, 0.0, 0.0], abs=1e-7)


@given(LEAN, LEAN, HEADING, RATE, RATE, RATE)
def test_rates_are_those_about_the_heading_axes(roll, pitch, heading, w_x, w_y, w_z):
    c, s = np.cos(heading), np.sin(heading)
    in_world = (c * w_x - s * w_y, s * w_x + c * w_y, w_z)
    found = inclination(quaternion(roll, pitch, heading), in_world)
    assert found[2:] == pytest.approx([w_x, w_y], abs=1e-6)


@given(LEAN, LEAN, HEADING)
def test_a_quaternion_and_its_negative_are_the_same_torso(roll, pitch, heading):
    one = quaternion(roll, pitch, heading)
    assert inclination(-one, (1.0, 2.0, 3.0)) == pytest.approx(inclination(one, (1.0, 2.0, 3.0)))


@pytest.mark.parametrize("axis", [0, 1])
def test_rate_is_the_derivative_of_the_inclination_near_upright(axis):
    step, lean = 1e-6, np.zeros(2)
    lean[axis] = step
    angular_velocity = np.zeros(3)
    angular_velocity[axis] = 1.0
    before = np.array(inclination(quaternion(0.0, 0.0, 0.0), angular_velocity))
    after = np.array(inclination(quaternion(*lean, 0.0), angular_velocity))
    assert (after[:2] - before[:2]) / step == pytest.approx(before[2:], abs=1e-5)


def test_errors_are_added_to_what_is_measured():
    turn, rates = quaternion(0.1, -0.2, 0.3), np.array([0.4, -0.5, 0.6])
    bias, noise = np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.1, 0.2, 0.3, 0.4])
    expected = np.array(inclination(turn, rates)) + bias + noise
    assert sample(turn, rates, bias, noise) == pytest.approx(expected)


@pytest.mark.parametrize("delay", [1, 3, 7])
def test_sample_is_reported_after_the_delay(delay):
    torso = Torso(ImuParams(angle_noise=0, rate_noise=0, angle_bias=0, delay_ticks=delay))
    readings = [torso.step(0.1, -0.2, 2.0, (0.0, 0.0, 1.0))]
    readings += [torso.step() for _ in range(9)]
    seen = [k + 1 for k, reading in enumerate(readings) if np.abs(reading).max() > 1e-9]
    assert seen == [delay]
    assert readings[delay - 1] == pytest.approx([0.1, -0.2, 0.0, 0.0])


def test_ideal_unit_has_one_tick_and_no_errors():
    torso = Torso(ImuParams().ideal(), seed=5)
    assert torso.step(0.1, 0.2, 0.3) == pytest.approx([0.1, 0.2, 0.0, 0.0])


def test_same_seed_gives_the_same_errors():
    one, again = (Torso(ImuParams(), seed=3).upright(50) for _ in range(2))
    assert np.array_equal(one, again)


def test_other_seed_gives_other_noise_and_bias():
    noise, bias = ImuParams(angle_bias=0.0), ImuParams(angle_noise=0.0, rate_noise=0.0)
    for params in (noise, bias):
        one, other = (Torso(params, seed=seed).upright(10)[-1] for seed in (3, 4))
        assert (one[:2] != other[:2]).all()


def test_bias_is_constant_and_on_the_angles_alone():
    readings = Torso(ImuParams(angle_noise=0.0, rate_noise=0.0)).upright(20)[5:]
    assert (readings == readings[0]).all()
    assert readings[0, :2].all() and not readings[0, 2:].any()


def test_bias_has_its_deviation_over_the_seeds():
    params = ImuParams(angle_noise=0.0, rate_noise=0.0, angle_bias=0.01, delay_ticks=1)
    biases = [Torso(params, seed=seed).step()[:2] for seed in range(400)]
    assert np.std(biases) == pytest.approx(0.01, rel=0.15)


def test_noise_has_its_deviations():
    params = ImuParams(angle_noise=0.001, rate_noise=0.02, angle_bias=0.0, delay_ticks=1)
    deviation = Torso(params).upright(3000).std(axis=0)
    assert deviation == pytest.approx([0.001, 0.001, 0.02, 0.02], rel=0.1)


def test_a_drift_grows_with_time_also_in_an_ideal_unit():
    torso = Torso(ImuParams(drift=(0.02, -0.05), angle_noise=0.1).ideal())
    readings = torso.upright(2001)
    np.testing.assert_allclose(readings[2000], [0.04, -0.1, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(readings[1000], [0.02, -0.05, 0.0, 0.0], atol=1e-12)
