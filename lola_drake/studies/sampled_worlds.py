"""Worlds to try a scenario in: what the controller does not know, drawn at random.

What is drawn lies outside the controller: where the obstacles are, the heights of fields of boards,
the ground's friction and stiffness, the noise of the sensors, the delays of the bus and the IMU.
The ranges are estimates of what a laboratory offers.
"""

import dataclasses

import numpy as np

from lola_drake.obstacles import Laid
from lola_drake.scenario import Ground, Scenario

FRICTION = (0.6, 1.0)
"""Coulomb friction of the ground."""

STIFFNESS = (0.7, 1.3)
"""Stiffness of the ground over the scenario's own."""

BUS_TICKS = (1, 2)
"""Delay of the bus to the joints (control periods, both included)."""

IMU_TICKS = (2, 4)
"""Delay of the IMU (control periods, both included)."""


def sample_world(scenario: Scenario, seed: int) -> Scenario:
    """Return the scenario in a world of its own: the same for the same seed in all variants."""
    random = np.random.default_rng(seed)
    ground = _sample_ground(scenario.ground, random)
    control, sensors = scenario.control, scenario.sensors
    bus_delay = int(random.integers(*BUS_TICKS, endpoint=True))
    imu_delay = int(random.integers(*IMU_TICKS, endpoint=True))
    servos = dataclasses.replace(control.servos, delay_ticks=bus_delay)
    imu = dataclasses.replace(sensors.imu, delay_ticks=imu_delay)
    return dataclasses.replace(
        scenario,
        seed=seed,
        ground=ground,
        control=dataclasses.replace(control, servos=servos),
        sensors=dataclasses.replace(sensors, imu=imu),
    )


def _sample_ground(ground: Ground, random: np.random.Generator) -> Ground:
    friction, stiffness = random.uniform(*FRICTION), random.uniform(*STIFFNESS)
    return dataclasses.replace(
        ground,
        friction=friction,
        stiffness=stiffness * ground.stiffness,
        obstacles=_moved(ground.obstacles, random),
        stairs=_moved(ground.stairs, random),
        fields=tuple(
            dataclasses.replace(field, seed=int(random.integers(1_000_000_000)))
            for field in _moved(ground.fields, random)
        ),
        footholds=_moved(ground.footholds, random),
    )


def _moved(laid: tuple[Laid, ...], random: np.random.Generator) -> tuple[Laid, ...]:
    return tuple(one.shifted(random.uniform(*one.free_shift)) for one in laid)
