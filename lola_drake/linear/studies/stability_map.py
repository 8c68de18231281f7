"""Stability over two parameters: how fast the loop grows where it is unstable, how robust it is."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import control
import numpy as np

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.linearize import essential
from lola_drake.linear.margins import matrix_margins
from lola_drake.linear.poles import UNSTABLE
from lola_drake.linear.studies.bisection import border, stable_spans
from lola_drake.linear.studies.flexible_torso import FlexibleTorso, with_torso
from lola_drake.linear.studies.map_kinds import DELTA, GAIN, SETTINGS, SHARE, MapKind
from lola_drake.linear.studies.workpoint import Workpoint, make_workpoint
from lola_drake.linear.text_table import Table
from lola_drake.scenario import Scenario, override
from lola_drake.signals import PERIOD
from lola_drake.workers import in_order

LOOP = "measured_wrench"
"""Where the loop is opened for the margin."""

FAST = 5.0
"""Motions that swing faster than this are kept apart (Hz): between the points of a map the slowest
decay of all would hide how a fast one goes from stable to unstable."""

FINE = 4
"""Points that are interpolated between two of a map."""


@dataclass(frozen=True)
class AtSetting:
    """What one of the paper's two settings does, everything else being the scenario's.

    Attributes:
        growth: of the fastest growing or slowest decaying motion (1/s).
        share: up to which part of the torso's mode it is stable; None without that mode.
    """

    growth: float
    share: float | None


@dataclass(frozen=True)
class StabilityMap:
    """A map.

    Attributes:
        kind: what it is over.
        at: the operating point.
        scenario: everything else.
        torso: its mode, None for a rigid one.
        rates: growth of the slow and of the fast motions (1/s), shape (2, y, x); the least decay
            or largest growth of each. NaN where there is no equilibrium.
        disk: margin at the force sensors (0 where unstable), shape (y, x).
        settings: what the paper's settings do.
        setting_rates: `rates` with the paper's settings, where delta is on no axis.
        spans: where along x it is stable, from and to, found by bisection; one list for each y,
            and the same with the paper's settings by their names ("" for the scenario's own).
    """

    kind: MapKind
    at: str
    scenario: Scenario
    torso: FlexibleTorso | None
    rates: np.ndarray
    disk: np.ndarray
    settings: dict[str, AtSetting]
    setting_rates: dict[str, np.ndarray]
    spans: dict[str, list[list[tuple[float, float]]]]

    @property
    def growth(self) -> np.ndarray:
        """Return the growth of the fastest growing or slowest decaying motion (1/s)."""
        return self.rates.max(axis=0)

    def as_text(self) -> str:
        """Return where it is stable for every value of y, and what the paper's settings do."""
        x, y = self.kind.x, self.kind.y
        rows = []
        for k, value in enumerate(y.shown(self.scenario)):
            spans = [self._described(found[k]) for found in self.spans.values()]
            rows.append((f"{value:.4g}", *spans, f"{np.nanmax(self.disk[k], initial=0.0):.2f}"))
        others = [f"with the {name}'s δ and g_a" for name in self.setting_rates]
        header = (y.label, f"stable for {x.label}", *others, "best disk margin")
        table = Table(f"{self.kind.doc}, at {self.at}", header, tuple(rows))
        return f"{table.as_text()}\n\n{self._settings_table().as_text()}"

    def _described(self, spans: list[tuple[float, float]]) -> str:
        """Return ranges along x in the units that are shown."""
        ends = (np.sort(self.kind.x.shown(self.scenario, span)) for span in spans)
        return ", ".join(f"{low:.3g} to {high:.3g}" for low, high in ends) or "nowhere"

    def _settings_table(self) -> Table:
        """Return what the paper's settings do as a table."""
        header: tuple[str, ...] = ("", "δ (ms)", "g_a", "growth (1/s)", "stable")
        rows: list[tuple[str, ...]] = [
            (
                name,
                f"{1e3 * SETTINGS[name][DELTA]:g}",
                f"{SETTINGS[name][GAIN]:g}",
                f"{found.growth:.3g}",
                "yes" if found.growth < 0 else "NO",
            )
            for name, found in self.settings.items()
        ]
        if self.torso:
            header += ("stable up to a share of",)
            rows = [
                (*row, f"{found.share:.2f}")
                for row, found in zip(rows, self.settings.values(), strict=True)
            ]
        return Table("The paper's two settings", header, tuple(rows))

    def as_numbers(self) -> dict[str, object]:
        """Return the map as what JSON can hold."""
        return {
            "at": self.at,
            "torso": vars(self.torso) if self.torso else None,
            "x": {"key": self.kind.x.key, "values": list(self.kind.x.values)},
            "y": {"key": self.kind.y.key, "values": list(self.kind.y.values)},
            "growth_per_s": _without_nan(self.growth),
            "disk_margin": _without_nan(self.disk),
            "stable": self.spans,
            "settings": {name: vars(found) for name, found in self.settings.items()},
        }


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
        torso: a flexible torso in the IMU's path; None for a rigid one, or for the map over its
            share the default.
        jobs: number of processes.
        done: called with the number of finished rows, and of all.

    Raises:
        AnalysisError: if `at` is a moment of a walk, or the robot cannot rest there.
    """
    at = at or kind.at
    if kind.y.key == SHARE:
        torso = replace(torso or FlexibleTorso(), share=1.0)
    workpoint = make_workpoint(scenario, at, _SIGNALS, _SIGNALS)
    if workpoint.situation.residual is None:
        raise AnalysisError(f"a map needs a pose, where the robot rests: {at} is none")
    free = DELTA not in (kind.x.key, kind.y.key)
    compared = dict(SETTINGS) if free else {}
    settings = [_with(kind.y.key, y, scenario, torso) for y in kind.y.values]
    rows = in_order(jobs, partial(_row, kind, at, compared), settings, done)
    rates, disk, others, spans = zip(*rows, strict=True)
    return StabilityMap(
        kind,
        at,
        scenario,
        torso,
        np.moveaxis(np.array(rates), -1, 0),
        np.array(disk),
        {name: _at_setting(workpoint.varied(changes), torso) for name, changes in SETTINGS.items()},
        {name: np.moveaxis(np.array([row[name] for row in others]), -1, 0) for name in compared},
        {name: [row[name] for row in spans] for name in ("", *compared)},
    )


def growth_rates(workpoint: Workpoint, torso: FlexibleTorso | None = None) -> np.ndarray:
    """Return the growth of the slow and of the fast motions (1/s), the largest of each; (2,)."""
    z = np.linalg.eigvals(with_torso(workpoint, torso).A)
    z = z[(np.abs(z - 1) >= UNSTABLE) & (z != 0)]
    growth = np.log(np.abs(z)) / PERIOD
    fast = np.abs(np.angle(z)) > 2 * np.pi * FAST * PERIOD
    return np.array([growth[~fast].max(initial=-np.inf), growth[fast].max(initial=-np.inf)])


def growth_rate(workpoint: Workpoint, torso: FlexibleTorso | None = None) -> float:
    """Return the rate of the fastest growing or slowest decaying motion (1/s)."""
    return float(growth_rates(workpoint, torso).max())


def finer(values: np.ndarray) -> np.ndarray:
    """Return values with `FINE` - 1 more, linearly interpolated, between two along every axis."""
    for axis, n in enumerate(values.shape):
        place = np.linspace(0, n - 1, FINE * (n - 1) + 1)
        values = np.apply_along_axis(partial(np.interp, place, np.arange(n)), axis, values)
    return values


_SIGNALS = (LOOP, "torso_orientation")


def _with(
    key: str, value: float, scenario: Scenario, torso: FlexibleTorso | None
) -> tuple[Scenario, FlexibleTorso | None]:
    """Return scenario and torso with one of their values changed."""
    if key == SHARE:
        return scenario, replace(torso or FlexibleTorso(), share=value)
    return override(scenario, {key: value}), torso


def _row(
    kind: MapKind,
    at: str,
    compared: dict[str, dict[str, float]],
    setting: tuple[Scenario, FlexibleTorso | None],
) -> tuple[list, list, dict[str, list], dict[str, list]]:
    """Return rates and disk margins over x, the rates with other settings, and stable spans."""
    scenario, torso = setting
    try:
        workpoint = make_workpoint(scenario, at, _SIGNALS, _SIGNALS)
    except AnalysisError:
        n, unknown = len(kind.x.values), np.full(2, np.nan)
        nowhere: dict[str, list] = {name: [] for name in ("", *compared)}
        return [unknown] * n, [np.nan] * n, {name: [unknown] * n for name in compared}, nowhere
    points, rates, spans = _along_x(kind, workpoint, torso, {})
    # A margin costs far more than poles do: only where there is one.
    disk = [
        _disk_margin(point, torso) if rate.max() < 0 else 0.0
        for point, rate in zip(points, rates, strict=True)
    ]
    other_rates, all_spans = {}, {"": spans}
    for name, changes in compared.items():
        _, other_rates[name], all_spans[name] = _along_x(kind, workpoint, torso, changes)
    return rates, disk, other_rates, all_spans


def _along_x(
    kind: MapKind, workpoint: Workpoint, torso: FlexibleTorso | None, changes: dict[str, float]
) -> tuple[list[Workpoint], list[np.ndarray], list[tuple[float, float]]]:
    """Return the workpoints along x, their growth rates, and where it is stable."""

    def at_x(x: float) -> Workpoint:
        return workpoint.varied({kind.x.key: x} | changes)

    points = [at_x(x) for x in kind.x.values]
    rates = [growth_rates(point, torso) for point in points]
    stable = np.max(rates, axis=1) < 0
    spans = stable_spans(kind.x.values, stable, lambda x: growth_rate(at_x(x), torso) < 0)
    return points, rates, spans


def _disk_margin(workpoint: Workpoint, torso: FlexibleTorso | None) -> float:
    """Return the disk margin of all force signals at once; 0 where the loop is unstable."""
    matrices = with_torso(workpoint, torso, workpoint.select([LOOP]))
    kept = essential(matrices)
    loop = control.StateSpace(
        matrices.A[np.ix_(kept, kept)],
        matrices.B[kept],
        -matrices.C[:, kept],
        -matrices.D,
        PERIOD,
        remove_useless_states=False,
    )
    found = matrix_margins(loop, 20)
    return found.disk if found.stable else 0.0


def _at_setting(workpoint: Workpoint, torso: FlexibleTorso | None) -> AtSetting:
    return AtSetting(
        growth_rate(workpoint, torso), largest_share(workpoint, torso) if torso else None
    )


def largest_share(workpoint: Workpoint, torso: FlexibleTorso) -> float:
    """Return up to which share of a torso's mode a workpoint is stable, 0 to 1, to within 0.005."""

    def is_stable(share: float) -> bool:
        return growth_rate(workpoint, replace(torso, share=share)) < 0

    if is_stable(1.0):
        return 1.0
    return border(is_stable, unstable=1.0, stable=0.0, accuracy=0.005)


def _without_nan(values: np.ndarray) -> list[list[float | None]]:
    return [[None if np.isnan(value) else float(value) for value in row] for row in values]
