"""What the stability maps are over: the axes, and the paper's two settings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.studies.analyses import value_of
from lola_drake.scenario import Scenario
from lola_drake.typed_yaml import suggestion

DELTA, GAIN = "control.force.time_constant", "control.com_dynamics.gain"
MODEL, GROUND = "pattern.ground_stiffness", "ground.stiffness"
DELAY = "control.servos.delay_ticks"
SHARE = "torso.share"
"""Not of the scenario: the part of the torso's mode that the IMU sees."""

SETTINGS = {"simulation": {DELTA: 0.02, GAIN: 1.0}, "robot": {DELTA: 0.027, GAIN: 0.8}}
"""delta and g_a of the paper, in its simulation and on its robot."""


@dataclass(frozen=True)
class Axis:
    """One axis of a map.

    Attributes:
        key: of the scenario, or `SHARE`.
        values: of it.
        label: with the unit of what is shown.
        factor: from the value to what is shown.
        over: key of a value that is divided by this one to be shown; then `factor` has no part.
    """

    key: str
    values: tuple[float, ...]
    label: str
    factor: float = 1.0
    over: str | None = None

    def shown(self, scenario: Scenario, values: Sequence[float] | None = None) -> np.ndarray:
        """Return what is shown for the axis's values, or for others; shape (n,)."""
        found = np.array(self.values if values is None else values)
        return value_of(scenario, self.over) / found if self.over else self.factor * found


@dataclass(frozen=True)
class MapKind:
    """What a map is over.

    Attributes:
        doc: in one line.
        x, y: its axes.
        at: operating point, unless another is asked for.
    """

    doc: str
    x: Axis
    y: Axis
    at: str


_DELTA = Axis(
    DELTA, tuple(float(v) for v in np.geomspace(0.002, 0.05, 21).round(5)), "δ (ms)", factor=1e3
)
_RATIO = Axis(
    MODEL,
    (6e5, 4.5e5, 3e5, 2e5, 1.5e5, 1.2e5, 1e5, 7.5e4, 6e4),
    "true / model stiffness of the pads",
    over=GROUND,
)

MAPS = {
    "gains": MapKind(
        "δ of the error dynamics against g_a of the CoM dynamics",
        _DELTA,
        Axis(GAIN, tuple(k / 8 for k in range(9)), "g_a"),
        "left",
    ),
    "stiffness": MapKind(
        "δ of the error dynamics against the error of the contact model",
        _DELTA,
        _RATIO,
        "left",
    ),
    "latency": MapKind(
        "delay of the bus against the stiffness of the ground",
        Axis(DELAY, (1, 2, 3, 4, 5, 6, 7, 8, 10, 12), "bus delay (ms)"),
        Axis(
            GROUND,
            (1e5, 1.5e5, 2e5, 3e5, 4e5, 5e5, 6.5e5, 8e5, 1e6),
            "ground stiffness (kN/m)",
            factor=1e-3,
        ),
        "left",
    ),
    "torso": MapKind(
        "δ of the error dynamics against the part of the torso's mode that the IMU sees",
        _DELTA,
        Axis(SHARE, tuple(k / 10 for k in range(11)), "share of the mode"),
        "stand",
    ),
}


def map_kind(name: str) -> MapKind:
    """Return a kind of map; AnalysisError if there is none of that name."""
    if name not in MAPS:
        raise AnalysisError(f"no map {name!r}{suggestion(name, MAPS)}")
    return MAPS[name]
