"""Several runs in one figure."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure

from lola_drake.figures.style import FIRST, INK, LEFT, RIGHT, add_legend, plot, time_figure
from lola_drake.metrics import inclination_deg, torque_error
from lola_drake.results import Result

RUN_COLOURS = (INK, RIGHT, LEFT, FIRST)
"""The first run is what the others are compared with: it is drawn in the colour of text."""


def labels(results: Sequence[Result]) -> list[str]:
    """Return short, different names for runs: what tells them apart."""
    scenarios = [result.scenario for result in results]
    for of in (
        lambda scenario: scenario.variant,
        lambda scenario: scenario.active_control().law,
        lambda scenario: f"{scenario.active_control().law} {scenario.variant}",
        lambda scenario: scenario.name,
        lambda scenario: f"{scenario.name} {scenario.variant}",
        lambda scenario: f"{scenario.name} {scenario.variant} seed {scenario.seed}",
    ):
        names = [of(scenario) for scenario in scenarios]
        if len(set(names)) == len(names):
            return names
    return [f"{name} ({i + 1})" for i, name in enumerate(names)]


def inclinations(results: Sequence[Result]) -> Figure:
    """Return the torso's inclination in all runs."""
    return _overlay(
        results,
        "Inclination of the torso",
        "angle (deg)",
        lambda result: inclination_deg(result.signals["torso_pose"]),
    )


def torque_errors(results: Sequence[Result]) -> Figure:
    """Return the error of the torque about the CoM in all runs."""
    return _overlay(
        results,
        "Error of the torque about the CoM",
        "torque (Nm)",
        lambda result: torque_error(result.signals),
    )


COMPARISONS: dict[str, Callable[[Sequence[Result]], Figure]] = {
    "inclinations": inclinations,
    "torque_errors": torque_errors,
}
"""Every figure of several runs by its name."""


def _overlay(
    results: Sequence[Result], title: str, unit: str, of: Callable[[Result], np.ndarray]
) -> Figure:
    """Return a figure of x and y of something; the gait below is that of the longest run."""
    names = labels(results)
    longest = max(range(len(results)), key=lambda i: results[i].duration)
    figure, axes = time_figure(results[longest], 2, title=title)
    figure.axes[-1].set_xlabel(f"time (s); the gait is that of {names[longest]}")
    for result, name, colour in zip(results, names, RUN_COLOURS, strict=False):
        for i, values in enumerate(of(result).T):
            plot(axes[i, 0], result.times, values, color=colour, label=name)
    for ax, axis in zip(axes[:, 0], "xy", strict=True):
        ax.set(title=f"about {axis}", ylabel=unit)
    add_legend(axes[0, 0])
    return figure
