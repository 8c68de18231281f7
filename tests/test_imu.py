"""The IMU: what it measures, how late, and with which errors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

from lola_drake.blocks.imu import Imu, ImuParams, inclination

PERIOD, STATE = 0.001, 61
IDEAL = ImuParams().ideal()
angles = st.floats(-0.5, 0.5)


def plant_state(roll=0.0, pitch=0.0, yaw=0.0, omega=(0.0, 0.0, 0.0)):
    """Return a plant's state with the torso in this orientation."""
    state = np.zeros(STATE)
    state[:4] = RollPitchYaw(roll, pitch, yaw).ToQuaternion().wxyz()
    state[31:34] = omega
    return state


class Watched:
    """A unit that is stepped tick by tick."""

    def __init__(self, params, seed=0):
        self.block = Imu(params, STATE, PERIOD, seed)
        self.context = self.block.CreateDefaultContext()

    def step(self, state):
        """Return what the unit reports in this tick, in which the plant has this state."""
        self.block.GetInputPort("plant_state").FixValue(self.context, state)
        report = self.block.GetOutputPort("torso_orientation").Eval(self.context).copy()
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        self.context.SetTime(self.context.get_time() + PERIOD)
        return report


@given(angles, angles, st.floats(-3, 3))
def test_inclination_is_roll_and_pitch_whatever_the_heading(roll, pitch, yaw):
    measured = inclination(plant_state(roll, pitch, yaw)[:4], [0, 0, 0])
    np.testing.assert_allclose(measured[:2], [roll, pitch], atol=1e-12)


@given(angles, angles, st.floats(-3, 3))
def test_rates_of_small_inclinations_are_their_derivatives(x, y, yaw):
    """Falling to the left or forward is the same whatever the heading in W."""
    turned = RollPitchYaw(0, 0, yaw).ToRotationMatrix()
    h, omega = 1e-6, turned.matrix() @ [x, y, 0.0]
    tilted = (RollPitchYaw(h * x, h * y, 0).ToRotationMatrix()).matrix()
    after = Quaternion(turned.matrix() @ tilted).wxyz()
    measured = inclination(after, omega)
    np.testing.assert_allclose(measured[2:], measured[:2] / h, atol=1e-5)
    np.testing.assert_allclose(measured[2:], [x, y], atol=1e-5)


def test_upside_down_stays_finite():
    assert np.all(np.isfinite(inclination(plant_state(pitch=np.pi / 2)[:4], [1, 1, 1])))


@pytest.mark.parametrize("delay", [1, 2, 3, 7])
def test_delay_in_ticks(delay):
    unit = Watched(ImuParams(0.0, 0.0, 0.0, delay))
    upright, leaning = plant_state(), plant_state(roll=0.1)
    reports = [unit.step(leaning if k == 5 else upright)[0] for k in range(20)]
    assert np.flatnonzero(np.array(reports) > 0.05).tolist() == [5 + delay]


def test_ideal_unit_is_exact_after_one_tick():
    unit = Watched(IDEAL)
    unit.step(plant_state(0.1, -0.2, 1.0))
    np.testing.assert_allclose(unit.step(plant_state())[:2], [0.1, -0.2], atol=1e-12)


def reports(params, seed):
    unit = Watched(params, seed)
    return np.array([unit.step(plant_state()) for _ in range(3000)])[params.delay_ticks :]


def test_bias_is_constant_and_noise_as_declared():
    params = ImuParams(angle_noise=1e-3, rate_noise=5e-3, angle_bias=0.05)
    first, second = reports(params, 1), reports(params, 2)
    np.testing.assert_allclose(first.std(axis=0), [1e-3, 1e-3, 5e-3, 5e-3], rtol=0.1)
    np.testing.assert_allclose(first[:, 2:].mean(axis=0), 0, atol=1e-3)
    bias = first[:, :2].mean(axis=0), second[:, :2].mean(axis=0)
    assert np.all(np.abs(bias) > 1e-4)
    assert np.all(bias[0] != bias[1])


def test_same_seed_gives_the_same_reports():
    np.testing.assert_array_equal(reports(ImuParams(), 4), reports(ImuParams(), 4))
