"""Stability over two parameters: how fast the loop grows where it is unstable, how robust it is."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed

from lola_drake.analysis.linear.bench import Bench, make_bench
from lola_drake.analysis.linear.errors import AnalysisError
from lola_drake.analysis.linear.flexible_torso import FlexibleTorso, with_torso
from lola_drake.analysis.linear.linearize import state_space
from lola_drake.analysis.linear.margins import matrix_margins
from lola_drake.analysis.linear.open_loop import negated
from lola_drake.analysis.linear.poles import spectral_radius
from lola_drake.analysis.linear.text_table import Table
from lola_drake.scenario import Scenario, override
from lola_drake.typed_yaml import suggestion

LOOP = "measured_wrench"
"""Where the loop is opened for the margin."""

SETTINGS = {"simulation": (0.02, 1.0), "robot": (0.027, 0.8)}
"""delta and g_a of the paper, in its simulation and on its robot."""

DELTA, GAIN = "control.force.time_constant", "control.com_dynamics.gain"
STIFFNESS, DELAY = "ground.stiffness", "control.servos.delay_ticks"


@dataclass(frozen=True)
class Axis:
    """One axis of a map.

    Attributes:
        key: of the scenario.
        values: of it.
        label: with its unit.
        factor: from the value to what is shown.
    """

    key: str
    values: tuple[float, ...]
    label: str
    factor: float = 1.0


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
    DELTA, tuple(float(v) for v in np.geomspace(0.005, 0.05, 21).round(5)), "delta (ms)", factor=1e3
)
_STIFFNESS = Axis(
    STIFFNESS,
    (1e5, 1.5e5, 2e5, 3e5, 4e5, 5e5, 6.5e5, 8e5, 1e6),
    "ground stiffness (kN/m)",
    factor=1e-3,
)

MAPS = {
    "gains": MapKind(
        "error dynamics delta against CoM dynamics g_a",
        _DELTA,
        Axis(GAIN, tuple(k / 8 for k in range(9)), "g_a"),
        "left",
    ),
    "stiffness": MapKind(
        "error dynamics delta against the ground's stiffness, the model's being fixed",
        _DELTA,
        _STIFFNESS,
        "left",
    ),
    "latency": MapKind(
        "delay of the bus against the ground's stiffness, the model's being fixed",
        Axis(DELAY, tuple(range(1, 13)), "bus delay (ms)"),
        _STIFFNESS,
        "left",
    ),
}


@dataclass(frozen=True)
class StabilityMap:
    """A map.

    Attributes:
        kind: what it is over.
        at: the operating point.
        scenario: everything else.
        torso: its mode, None for a rigid one.
        growth: of the fastest growing or slowest decaying motion (1/s), shape (y, x).
        disk: margin at the force sensors (0 where unstable), shape (y, x).
    """

    kind: MapKind
    at: str
    scenario: Scenario
    torso: FlexibleTorso | None
    growth: np.ndarray
    disk: np.ndarray

    def as_text(self) -> str:
        """Return the smallest stable value of x for every value of y."""
        x, y = self.kind.x, self.kind.y
        rows = []
        for value, growth, disk in zip(y.values, self.growth, self.disk, strict=True):
            stable = [f"{v * x.factor:.4g}" for v, g in zip(x.values, growth, strict=True) if g < 0]
            span = f"{stable[0]} to {stable[-1]}" if stable else "nowhere"
            rows.append((f"{value * y.factor:g}", span, f"{np.nanmax(disk, initial=0.0):.2f}"))
        header = (y.label, f"stable for {x.label}", "best disk margin")
        return Table(f"{self.kind.doc}, at {self.at}", header, tuple(rows)).as_text()

    def as_numbers(self) -> dict[str, object]:
        """Return the map as what JSON can hold."""
        return {
            "at": self.at,
            "torso": vars(self.torso) if self.torso else None,
            "x": {"key": self.kind.x.key, "values": list(self.kind.x.values)},
            "y": {"key": self.kind.y.key, "values": list(self.kind.y.values)},
            "growth_per_s": _without_nan(self.growth),
            "disk_margin": _without_nan(self.disk),
        }


def map_kind(name: str) -> MapKind:
    """Return a kind of map; AnalysisError if there is none of that name."""
    if name not in MAPS:
        raise AnalysisError(f"no map {name!r}{suggestion(name, MAPS)}")
    return MAPS[name]


def stability_map(
    kind: MapKind,
    scenario: Scenario,
    at: str | None = None,
    torso: FlexibleTorso | None = None,
    jobs: int = 2,
    done: Callable[[int, int], None] | None = None,
) -> StabilityMap:
    """Compute a map, one row of it at a time in parallel processes.

    Args:
        kind: what it is over.
        scenario: everything else.
        at: a pose, as in `operating_points.situation`; None for the kind's own.
        torso: a flexible torso in the IMU's path.
        jobs: number of processes.
        done: called with the number of finished rows, and of all.
    """
    at = at or kind.at
    rows = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_row)(kind, override(scenario, {kind.y.key: y}), at, torso) for y in _whole(kind.y)
    )
    growth, disk = [], []
    for row in rows:
        growth.append(row[0])
        disk.append(row[1])
        if done:
            done(len(growth), len(kind.y.values))
    return StabilityMap(kind, at, scenario, torso, np.array(growth), np.array(disk))


def growth_rate(bench: Bench, torso: FlexibleTorso | None = None) -> float:
    """Return the rate of the fastest growing or slowest decaying motion (1/s)."""
    return float(np.log(spectral_radius(with_torso(bench, torso))) / bench.blocks.period)


def _row(
    kind: MapKind, scenario: Scenario, at: str, torso: FlexibleTorso | None
) -> tuple[list[float], list[float]]:
    signals = (LOOP, "torso_orientation")
    try:
        bench = make_bench(scenario, at, signals, signals)
    except AnalysisError:
        nothing = [np.nan] * len(kind.x.values)
        return nothing, nothing
    growth, disk = [], []
    for x in _whole(kind.x):
        varied = bench.varied({kind.x.key: x})
        growth.append(growth_rate(varied, torso))
        disk.append(_disk_margin(varied))
    return growth, disk


def _disk_margin(bench: Bench) -> float:
    """Return the disk margin of all force signals at once; 0 where the loop is unstable."""
    at = bench.select([LOOP])
    found = matrix_margins(negated(state_space(bench.blocks, at, at, at, minimal=True)), 200)
    return found.disk if found.stable else 0.0


def _without_nan(values: np.ndarray) -> list[list[float | None]]:
    return [[None if np.isnan(value) else float(value) for value in row] for row in values]


def _whole(axis: Axis) -> list[float | int]:
    """Return the values of an axis, whole numbers as such."""
    return [int(v) if axis.key == DELAY else float(v) for v in axis.values]
