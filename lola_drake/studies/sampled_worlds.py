"""Worlds to try a scenario in: what the controller does not know, drawn at random.

What is drawn lies outside the controller: where the obstacles are, the heights of fields of boards,
and what the scenario's `worlds` has ranges of (`lola_drake/worlds.py`); the noise of the sensors
follows from the seed. A seed has the same draws in the same order for all scenarios.
"""

import dataclasses

import numpy as np

from lola_drake.blocks.joint_servos import MissedCycles
from lola_drake.model_errors import ModelErrors
from lola_drake.obstacles import Laid
from lola_drake.scenario import Ground, Scenario
from lola_drake.worlds import Worlds

EXTENDED = 1
"""Of the second row of random numbers that a seed has, for what is drawn where asked for."""


def sample_world(scenario: Scenario, seed: int) -> Scenario:
    """Return the scenario in a world of its own: the same for the same seed in all variants."""
    random, ranges = np.random.default_rng(seed), scenario.worlds
    ground = _sample_ground(scenario.ground, ranges, random)
    control, sensors = scenario.control, scenario.sensors
    bus_delay = _whole(ranges.bus_delay, random)
    imu_delay = _whole(ranges.imu_delay, random)
    servos = dataclasses.replace(control.servos, delay_ticks=bus_delay)
    imu = dataclasses.replace(sensors.imu, delay_ticks=imu_delay)
    changes = {
        "seed": seed,
        "ground": ground,
        "control": dataclasses.replace(control, servos=servos),
        "sensors": dataclasses.replace(sensors, imu=imu),
    }
    if ranges.extended:
        plain = dataclasses.replace(scenario, **changes)
        return _extended(plain, np.random.default_rng([seed, EXTENDED]))
    return dataclasses.replace(scenario, **changes)


def _whole(ends: tuple[float, float], random: np.random.Generator) -> int:
    low, high = ends
    return int(random.integers(int(low), int(high), endpoint=True))


def _sample_ground(ground: Ground, ranges: Worlds, random: np.random.Generator) -> Ground:
    friction, stiffness = random.uniform(*ranges.friction), random.uniform(*ranges.stiffness)
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


def _extended(scenario: Scenario, random: np.random.Generator) -> Scenario:
    """Return a world with what else nobody knows of it."""
    ranges, servos = scenario.worlds, scenario.control.servos
    errors = ModelErrors(
        mass=_numbers(random.uniform(*ranges.mass, 3)),
        inertia=_numbers(random.uniform(*ranges.inertia, 3)),
        pad_stiffness=_numbers(random.uniform(*ranges.pad_stiffness, 8)),
        pad_height=_numbers(random.uniform(*ranges.pad_height, 8)),
        servo_gain=random.uniform(*ranges.servo_gain),
    )
    start = dataclasses.replace(
        scenario.start,
        y=scenario.start.y + random.uniform(*ranges.start_sideways),
        heading_deg=scenario.start.heading_deg + random.uniform(*ranges.start_heading),
    )
    missed = _missed(random.uniform(*ranges.missed_cycles), scenario.duration, random)
    return dataclasses.replace(
        scenario,
        model_errors=errors,
        start=start,
        control=dataclasses.replace(
            scenario.control,
            servos=dataclasses.replace(servos, missed=(*servos.missed, *missed)),
        ),
    )


def _numbers(drawn: np.ndarray) -> tuple:
    return tuple(drawn.tolist())


def _missed(rate: float, duration: float, random: np.random.Generator) -> tuple[MissedCycles, ...]:
    """Return single cycles at random times, so many a second on average."""
    times = np.sort(random.uniform(0.0, duration, random.poisson(rate * duration)))
    return tuple(MissedCycles(time=float(f"{time:.3f}")) for time in times)
