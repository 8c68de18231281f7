"""What is drawn at random for a world, and in which range: what the controller does not know.

Each range says what it is an estimate of. The four that every world has are those of which the
README's figures tell; the others are drawn where `extended` says so, from numbers of their own, so
that the four stay the same.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any

from lola_drake.parameters import ParameterError, parameter, validate


def _range(low: float, high: float, doc: str, unit: str = "", **bounds: Any) -> Any:
    return parameter((low, high), f"from, to: {doc}", unit, **bounds)


@dataclass(frozen=True)
class Worlds:
    """Ranges, both ends included."""

    friction: tuple[float, float] = _range(
        0.6, 1.0, "of the ground; rubber on dry floors of laboratories", minimum=0.05, maximum=1.5
    )
    stiffness: tuple[float, float] = _range(
        0.7,
        1.3,
        "of the ground over the scenario's own; pads of one kind, by wear and temperature",
        minimum=0.1,
        maximum=10,
    )
    bus_delay: tuple[float, float] = _range(
        1,
        2,
        "whole control periods to the joints; a bus of one cycle, and one more",
        "",
        minimum=1,
        maximum=20,
    )
    imu_delay: tuple[float, float] = _range(
        2, 4, "whole control periods of the IMU; its filter and its line", minimum=0, maximum=20
    )
    extended: bool = parameter(False, "whether what follows is drawn, too")
    mass: tuple[float, float] = _range(
        0.95,
        1.05,
        "of trunk and each leg over the controller's model; CAD without cables, weighed parts",
        minimum=0.5,
        maximum=2,
    )
    inertia: tuple[float, float] = _range(
        0.95, 1.05, "of the same, beyond their mass; CAD", minimum=0.5, maximum=2
    )
    pad_stiffness: tuple[float, float] = _range(
        0.9, 1.1, "of each pad beside the others; hardness of one batch", minimum=0.5, maximum=2
    )
    servo_gain: tuple[float, float] = _range(
        0.9,
        1.1,
        "of the position loops over what the controller takes them for; friction and temperature "
        "of the drives",
        minimum=0.5,
        maximum=2,
    )
    missed_cycles: tuple[float, float] = _range(
        0.0,
        1.0,
        "cycles of the bus without a command, on average; jitter of a real-time system under load",
        "1/s",
        minimum=0,
        maximum=100,
    )
    pad_height: tuple[float, float] = _range(
        -5e-4,
        5e-4,
        "of each pad over where it should be; mounting, wear, and dents of the floor",
        "m",
        minimum=-0.005,
        maximum=0.005,
    )
    start_sideways: tuple[float, float] = _range(
        -0.003,
        0.003,
        "from the scenario's start; marks on the floor",
        "m",
        minimum=-0.5,
        maximum=0.5,
    )
    start_heading: tuple[float, float] = _range(
        -0.3,
        0.3,
        "from the scenario's start; along a line on the floor",
        "deg",
        minimum=-45,
        maximum=45,
    )

    def __post_init__(self):
        validate(self)
        for field in dataclasses.fields(self):
            ends = getattr(self, field.name)
            if field.name == "extended":
                continue
            if ends[0] > ends[1]:
                raise ParameterError(field.name, list(ends), "from a number to one as large")
            if field.name.endswith("_delay") and any(end != int(end) for end in ends):
                raise ParameterError(field.name, list(ends), "two whole numbers")
