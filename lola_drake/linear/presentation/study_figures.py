"""Pictures of the longer studies: stability maps, Floquet multipliers, measured responses."""

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from lola_drake.figures.style import DASHED, add_title
from lola_drake.linear.frequency import Response
from lola_drake.linear.presentation.look import COLOURS, FAINT, INK, LIMIT, in_look
from lola_drake.linear.studies.flexible_torso import FlexibleTorso
from lola_drake.linear.studies.map_kinds import DELTA, GAIN, SETTINGS
from lola_drake.linear.studies.measured_steps import Steps
from lola_drake.linear.studies.poincare import MOTION, PLACE, POSTURE, StrideMap
from lola_drake.linear.studies.stability_map import StabilityMap, finer

GROWTHS = (-1.0, -0.5, -0.2, -0.1, 0.0, 1.0, 5.0, 20.0, 100.0)
"""Levels of the growth rate (1/s): what is slow matters where it is stable."""

UNSTABLE, ENDLESS = "#d8dbe0", 1e9
"""Colour of what is unstable, and a growth that nothing reaches (1/s)."""

LARGEST, SMALLEST = 6, 1e-5
"""How many multipliers are named, and what counts as zero among them."""


@in_look
def map_figure(result: StabilityMap) -> Figure:
    """Return the picture of a stability map: growth rate, and disk margin."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    add_title(figure, f"{result.kind.doc} ({result.at}{_described(result.torso)})")
    left, right = figure.subplots(1, 2)
    x, y = (finer(axis.shown(result.scenario)) for axis in (result.kind.x, result.kind.y))
    slow, fast = rates = [finer(rate) for rate in result.rates]
    norm = BoundaryNorm(GROWTHS, 256, extend="both")
    style = {"cmap": "RdBu_r", "norm": norm}
    filled = left.contourf(x, y, slow, GROWTHS, extend="both", **style)
    bar = figure.colorbar(filled, ax=left, label="growth rate (1/s), below 0 stable")
    bar.set_ticks(GROWTHS, labels=[f"{value:g}" for value in GROWTHS])
    # A fast motion tips over within less than a cell: it is drawn over the slow ones.
    if np.nanmax(fast) > 0:
        worst = np.where(fast > 0, np.maximum(slow, fast), fast)
        left.contourf(x, y, worst, [g for g in GROWTHS if g >= 0], extend="max", **style)
    margin = right.contourf(
        x, y, finer(result.disk), np.linspace(0.0, 0.8, 9), cmap="viridis", extend="max"
    )
    figure.colorbar(margin, ax=right, label="disk margin of all force signals")
    for rate in rates:
        if np.nanmax(rate) > 0:
            right.contourf(x, y, rate, [0.0, ENDLESS], colors=[UNSTABLE])
    titles = "slowest decay or fastest growth", "robustness (grey: unstable)"
    for axes, title in zip((left, right), titles, strict=True):
        _draw_border(axes, x, y, rates, colors=LIMIT, linewidths=1.6)
        axes.set(title=title, xlabel=result.kind.x.label, ylabel=result.kind.y.label)
        axes.grid(False)
        _mark_settings(axes, result, x, y)
    return figure


def _draw_border(axes: Axes, x: np.ndarray, y: np.ndarray, rates: list, **style) -> None:
    """Draw where the slow or the fast motions tip over, while the others are stable."""
    for rate, other in (rates, rates[::-1]):
        seen = np.where(other > 0, np.nan, rate)
        if np.nanmin(seen, initial=0.0) < 0 < np.nanmax(seen, initial=0.0):
            axes.contour(x, y, seen, [0.0], **style)


def _described(torso: FlexibleTorso | None) -> str:
    if torso is None:
        return ""
    share = f", {torso.share:.0%} of it seen" if torso.share != 1 else ""
    return f", torso mode {torso.frequency:g} Hz{share}"


def _mark_settings(axes: Axes, result: StabilityMap, x: np.ndarray, y: np.ndarray) -> None:
    """Mark the paper's two settings: points, delta alone, or the border that each would have."""
    keys = (result.kind.x.key, result.kind.y.key)
    for (name, setting), (marker, dashes) in zip(SETTINGS.items(), _MARKS, strict=True):
        delta, gain = 1e3 * setting[DELTA], setting[GAIN]
        label = f"paper's {name}: δ {delta:g} ms, g_a {gain:g}"
        if keys == (DELTA, GAIN):
            axes.plot(delta, gain, marker, color=INK, mfc="white", ms=7, clip_on=False)
            on_the_left = delta < (x.min() + x.max()) / 2
            axes.annotate(
                label,
                (delta, gain),
                (8 if on_the_left else -8, -14),
                textcoords="offset points",
                fontsize=7.5,
                ha="left" if on_the_left else "right",
                bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.5},
            )
        elif DELTA in keys:
            axes.axvline(
                delta, color=INK, lw=1.0, ls=dashes, label=f"paper's {name}: δ {delta:g} ms"
            )
        else:
            rates = [finer(rate) for rate in result.setting_rates[name]]
            _draw_border(axes, x, y, rates, colors=INK, linewidths=1.0, linestyles=[dashes])
            axes.plot([], [], color=INK, lw=1.0, ls=dashes, label=f"border with the {label}")
    if keys != (DELTA, GAIN):
        axes.legend(loc="upper right", frameon=True, framealpha=0.85, edgecolor="none", fontsize=7)


_MARKS = (("o", "-"), ("s", "--"))
"""Marker and line of each of the paper's settings."""


@in_look
def multipliers_figure(maps: dict[str, StrideMap]) -> Figure:
    """Return the Floquet multipliers of several variants of a gait, in the unit circle."""
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    first = next(iter(maps.values()))
    add_title(figure, f"Floquet multipliers of {first.section.scenario.name}, stride to stride")
    plane = figure.add_subplot(1, 2, 1, projection="polar")
    bars = figure.add_subplot(1, 2, 2)
    for k, (colour, (name, stride)) in enumerate(zip(cycle(COLOURS), maps.items(), strict=False)):
        found = stride.multipliers()
        for kind, marker in _KINDS.items():
            values = np.array([m.value for m in found if m.kind == kind], dtype=complex)
            values = np.concatenate([values, values.conj()])
            radius = np.log10(np.maximum(np.abs(values), SMALLEST))
            label = f"{name}, {kind}: largest {stride.largest(kind):.2g}"
            plane.plot(
                np.angle(values), radius, marker, color=colour, mfc="none", ms=5, label=label
            )
        named = [m for m in found if m.kind == MOTION and abs(m.value) > SMALLEST][:LARGEST]
        rows = -np.arange(len(named)) - 0.36 * k
        bars.barh(rows, [abs(m.value) for m in named], 0.34, color=colour, label=name)
        for row, m in zip(rows, named, strict=True):
            bars.text(1.1 * abs(m.value), row, m.dominating, fontsize=6.5, va="center")
    decades = range(round(np.log10(SMALLEST)), 1)
    plane.set_ylim(decades[0], 0.2)
    plane.set_yticks(list(decades), labels=[f"$10^{{{d}}}$" if d else "1" for d in decades])
    plane.plot(np.linspace(0, 2 * np.pi, 200), np.zeros(200), color=LIMIT, lw=0.9)
    plane.set_title("all, over a logarithmic radius")
    plane.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), fontsize=7)
    bars.set(title="the largest of torso, CoM and legs, and whose they are")
    bars.set(xlabel="magnitude", yticks=[], xscale="log", xlim=(SMALLEST, 10.0))
    bars.legend(loc="lower right")
    return figure


_KINDS = {MOTION: "o", POSTURE: "x", PLACE: "s"}
"""Marker of each kind of multiplier."""


@in_look
def measured_figure(
    title: str, models: dict[str, Response], measured: dict[str, Response]
) -> Figure:
    """Return linear responses with what was measured in the nonlinear simulation over them."""
    figure = Figure(figsize=(3.4 * len(models) + 0.6, 4.6), layout="constrained")
    add_title(figure, title)
    axes = figure.subplots(2, len(models), squeeze=False, sharex=True)
    for column, (name, model) in enumerate(models.items()):
        gain, phase = axes[:, column]
        for response, style in ((model, {"color": COLOURS[0]}), (measured[name], _DOTS)):
            values = response.values.ravel()
            gain.semilogx(response.frequencies, 20 * np.log10(np.abs(values)), **style)
            phase.semilogx(response.frequencies, np.degrees(np.angle(values)), **style)
        gain.set_title(name.replace(" -> ", "\n\N{RIGHTWARDS ARROW} "), fontsize=8.5)
        phase.set(xlabel="frequency (Hz)", yticks=np.arange(-180, 181, 90))
        for each in (gain, phase):
            each.axhline(0.0, color=FAINT, lw=0.6)
    axes[0, 0].set_ylabel("gain (dB)")
    axes[1, 0].set_ylabel("phase (deg)")
    return figure


@in_look
def steps_figure(title: str, found: Sequence[Steps]) -> Figure:
    """Return the linear model's steps with those of the nonlinear simulation over them."""
    figure = Figure(figsize=(3.4 * len(found) + 0.6, 3.4), layout="constrained")
    add_title(figure, title)
    for axes, steps in zip(figure.subplots(1, len(found), squeeze=False)[0], found, strict=True):
        curves = zip(steps.simulated.items(), cycle(COLOURS[1:]), strict=False)
        for (height, simulated), colour in curves:
            axes.plot(steps.times, simulated, color=colour, lw=1.1, label=f"step {height:g}")
        axes.plot(steps.times, steps.linear, color=INK, lw=1.1, ls=DASHED, label="linear")
        axes.set_title(steps.name.replace(" -> ", "\n\N{RIGHTWARDS ARROW} "), fontsize=8.5)
        axes.set(xlabel="time (s)", ylim=_around(steps.linear))
        axes.legend()
    figure.axes[0].set_ylabel("output over the step's height")
    return figure


def _around(values: np.ndarray) -> tuple[float, float]:
    """Return limits that show the values; what falls over may leave them."""
    low, high = min(values.min(), 0.0), max(values.max(), 0.0)
    room = 0.4 * (high - low) or 1.0
    return low - room, high + room


_DOTS = {"color": COLOURS[1], "marker": "o", "ms": 4, "ls": "none"}
