"""Pictures of the longer studies: stability maps, Floquet multipliers, measured responses."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from lola_drake.analysis.figure_style import add_title
from lola_drake.analysis.linear.frequency import Response
from lola_drake.analysis.linear.look import COLOURS, FAINT, INK, LIMIT, in_look
from lola_drake.analysis.linear.poincare import StrideMap
from lola_drake.analysis.linear.stability_map import DELTA, GAIN, SETTINGS, StabilityMap

GROWTHS = (-1.0, -0.5, -0.2, -0.1, 0.0, 5.0, 20.0, 50.0, 100.0, 200.0, 400.0)
"""Levels of the growth rate (1/s)."""

LARGEST = 6
"""How many multipliers are named."""


@in_look
def map_figure(result: StabilityMap) -> Figure:
    """Return the picture of a stability map: growth rate, and disk margin."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    torso = f", torso mode {result.torso.frequency:g} Hz" if result.torso else ""
    add_title(figure, f"{result.kind.doc} ({result.at}{torso})")
    left, right = figure.subplots(1, 2)
    x, y = (np.array(a.values) * a.factor for a in (result.kind.x, result.kind.y))
    norm = TwoSlopeNorm(0.0, -1.0, GROWTHS[-1])
    filled = left.contourf(x, y, result.growth, GROWTHS, cmap="RdBu_r", norm=norm, extend="both")
    figure.colorbar(filled, ax=left, label="growth rate (1/s), below 0 stable", ticks=GROWTHS)
    levels = np.linspace(0.0, 0.8, 9)
    margin = right.contourf(x, y, result.disk, levels, cmap="viridis", extend="max")
    figure.colorbar(margin, ax=right, label="disk margin of all force signals")
    for axes, title in ((left, "slowest decay, fastest growth"), (right, "robustness")):
        axes.contour(x, y, result.growth, [0.0], colors=LIMIT, linewidths=1.6)
        axes.set(title=title, xlabel=result.kind.x.label, ylabel=result.kind.y.label)
        axes.grid(False)
        _mark_settings(axes, result)
    return figure


def _mark_settings(axes: Axes, result: StabilityMap) -> None:
    """Mark the paper's two settings where the map has their delta and g_a."""
    keys = (result.kind.x.key, result.kind.y.key)
    if keys[0] != DELTA:
        return
    for (name, (delta, gain)), marker in zip(SETTINGS.items(), "os", strict=True):
        y = gain if keys[1] == GAIN else None
        label = f"{name}: {1e3 * delta:g} ms, g_a {gain:g}"
        if y is None:
            axes.axvline(1e3 * delta, color=INK, lw=0.9, ls="--" if marker == "s" else "-")
        else:
            axes.plot(1e3 * delta, y, marker, color=INK, mfc="white", ms=7, clip_on=False)
            axes.annotate(label, (1e3 * delta, y), (6, -12), textcoords="offset points", fontsize=7)


@in_look
def multipliers_figure(maps: dict[str, StrideMap]) -> Figure:
    """Return the Floquet multipliers of several variants of a gait, in the unit circle."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    first = next(iter(maps.values()))
    add_title(figure, f"Floquet multipliers of {first.section.scenario.name}, stride to stride")
    plane, bars = figure.subplots(1, 2, width_ratios=(1.0, 1.4))
    angle = np.linspace(0, 2 * np.pi, 200)
    plane.plot(np.cos(angle), np.sin(angle), color=LIMIT, lw=0.9)
    for k, (colour, (name, stride)) in enumerate(zip(COLOURS, maps.items(), strict=False)):
        found = stride.multipliers()
        for neutral, face in ((False, colour), (True, "none")):
            values = np.array([m.value for m in found if m.neutral == neutral])
            label = None if neutral else f"{name}: largest {stride.radius:.2f}"
            both = np.concatenate([values, values.conj()])
            plane.plot(both.real, both.imag, "o", color=colour, mfc=face, ms=5, label=label)
        named = [m for m in found if not m.neutral][:LARGEST]
        rows = -np.arange(len(named)) - 0.36 * k
        bars.barh(rows, [abs(m.value) for m in named], 0.34, color=colour, label=name)
        for row, m in zip(rows, named, strict=True):
            bars.text(0.01, row, m.dominating, fontsize=6.5, color="white", va="center")
    plane.set(aspect="equal", xlabel="real part", ylabel="imaginary part")
    plane.set_title("hollow: place and heading")
    plane.legend(loc="lower left")
    bars.set(title="the largest, and whose they are", xlabel="magnitude", yticks=[])
    bars.legend(loc="lower right")
    return figure


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
        gain.set_title(name, fontsize=8.5)
        phase.set(xlabel="frequency (Hz)", yticks=np.arange(-180, 181, 90))
        for each in (gain, phase):
            each.axhline(0.0, color=FAINT, lw=0.6)
    axes[0, 0].set_ylabel("gain (dB)")
    axes[1, 0].set_ylabel("phase (deg)")
    return figure


_DOTS = {"color": COLOURS[1], "marker": "o", "ms": 4, "ls": "none"}
