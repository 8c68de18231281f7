"""The foot force sensors: what they feel, their filter and their noise."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from ticking import Ticking

from lola_drake.blocks.foot_force_sensor import FootForceSensor, FootForceSensorParams
from lola_drake.signals import MEASURED_WRENCH, PERIOD

JOINTS = (4, 2)
REST = np.zeros(6)
FILTER_ALONE = {"force_noise": 0.0, "torque_noise": 0.0}


class Sensors(Ticking):
    """The sensors of both feet."""

    def __init__(self, params, initial=None, seed=0):
        start = np.zeros(12) if initial is None else initial
        super().__init__(FootForceSensor(params, JOINTS, start, seed))

    def step(self, left=REST, right=REST):
        """Let the plant report forces and torques, [F, T], on the soles."""
        forces = [SpatialForce(np.full(3, 7e3), np.full(3, 7e3)) for _ in range(6)]
        for joint, wrench in zip(JOINTS, (left, right), strict=True):
            forces[joint] = SpatialForce(tau=wrench[3:], f=wrench[:3])
        port = self.system.GetInputPort("reaction_forces")
        port.FixValue(self.context, Value[list[SpatialForce]](forces))
        super().step()
        return self.reading()

    def reading(self):
        return self.output("measured_wrench")

    def quiet(self, count):
        return np.array([self.step() for _ in range(count)])


def test_sensor_feels_the_opposite_of_what_the_plant_puts_on_the_sole():
    left, right = np.arange(1.0, 7.0), np.arange(10.0, 16.0)
    reading = Sensors(FootForceSensorParams().ideal()).step(left, right)
    for foot, wrench in (("l", left), ("r", right)):
        assert np.array_equal(reading[MEASURED_WRENCH.slice(f"F_{foot}")], -wrench[:3])
        assert np.array_equal(reading[MEASURED_WRENCH.slice(f"T_{foot}")], -wrench[3:])


def test_reading_begins_with_what_it_is_told():
    initial = np.arange(12.0)
    sensors = Sensors(FootForceSensorParams(), initial)
    assert np.array_equal(sensors.reading(), initial)


@pytest.mark.parametrize("cutoff", [20.0, 150.0])
def test_filter_answers_a_step_as_a_first_order_low_pass(cutoff):
    sensors = Sensors(FootForceSensorParams(cutoff=cutoff, **FILTER_ALONE))
    wrench = np.array([1.0, 2.0, -300.0, 4.0, -5.0, 6.0])
    for k in range(1, 30):
        part = 1 - np.exp(-2 * np.pi * cutoff * k * PERIOD)
        assert sensors.step(wrench)[:6] == pytest.approx(-part * wrench)


def test_without_cutoff_a_reading_is_one_tick_old():
    sensors = Sensors(FootForceSensorParams(cutoff=0.0, **FILTER_ALONE))
    wrench = np.full(6, 5.0)
    assert np.array_equal(sensors.step(wrench, wrench), np.full(12, -5.0))
    assert not sensors.step().any()


def test_same_seed_gives_the_same_noise():
    one, again = (Sensors(FootForceSensorParams(), seed=3).quiet(30) for _ in range(2))
    assert one.all() and np.array_equal(one, again)


def test_other_seed_gives_other_noise():
    one, other = (Sensors(FootForceSensorParams(), seed=seed).quiet(30) for seed in (3, 4))
    assert (one != other).all()


def test_noise_has_its_deviations():
    params = FootForceSensorParams(force_noise=3.0, torque_noise=0.2, cutoff=0.0)
    deviation = Sensors(params).quiet(3000).std(axis=0)
    assert deviation == pytest.approx(np.tile(np.repeat([3.0, 0.2], 3), 2), rel=0.1)


def test_filter_smooths_the_noise():
    raw, filtered = (
        Sensors(FootForceSensorParams(cutoff=cutoff)).quiet(1000).std() for cutoff in (0.0, 50.0)
    )
    assert filtered < 0.6 * raw


def test_a_bias_is_added_to_one_foot_also_in_an_ideal_sensor():
    bias = (1.0, -2.0, 30.0, 0.4, 0.5, -0.6)
    load = np.arange(1.0, 7.0)
    for foot, other in (("l", "r"), ("r", "l")):
        reading = Sensors(FootForceSensorParams(**{f"bias_{foot}": bias}).ideal()).step(load, load)
        wrong = np.r_[
            reading[MEASURED_WRENCH.slice(f"F_{foot}")], reading[MEASURED_WRENCH.slice(f"T_{foot}")]
        ]
        assert wrong == pytest.approx(bias - load)
        assert reading[MEASURED_WRENCH.slice(f"F_{other}")] == pytest.approx(-load[:3])
