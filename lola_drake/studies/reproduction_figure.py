"""The paired differences of all experiments: every world a dot."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lola_drake.figures.style import FAINT, INK, LEFT, RIGHT, look
from lola_drake.studies.reproduction import Outcome
from lola_drake.studies.row import Summary, survived

WIDTH, ROW = 7.0, 1.75
"""Inches: the width of both columns of a paper, and the height of an experiment."""

ENTRIES = (
    ("max_inclination_deg", "x", "max $|\\varphi_x|$"),
    ("max_inclination_deg", "y", "max $|\\varphi_y|$"),
    ("rms_torque_error_Nm", "x", "RMS $e_{T_x}$"),
    ("rms_torque_error_Nm", "y", "RMS $e_{T_y}$"),
)

WORLD: dict[str, Any] = {"marker": "o", "color": LEFT, "ms": 3, "alpha": 0.6, "mec": "none"}
MEDIAN: dict[str, Any] = {"marker": "|", "color": INK, "ms": 13, "mew": 1.6}
PAPER: dict[str, Any] = {"marker": "D", "color": RIGHT, "ms": 5}
LEGEND = [
    Line2D([], [], ls="none", label=label, **style)
    for label, style in (("world", WORLD), ("median, quartiles", MEDIAN), ("paper", PAPER))
]


def reproduction_figure(outcomes: Sequence[Outcome]) -> Figure:
    """Return, for each experiment, the inclination in both variants and the paired changes."""
    with look():
        figure = Figure(figsize=(WIDTH, ROW * len(outcomes) + 0.5), layout="constrained")
        _draw(figure, outcomes)
    return figure


def _draw(figure: Figure, outcomes: Sequence[Outcome]) -> None:
    axes = figure.subplots(len(outcomes), 2, width_ratios=(1.0, 1.7), squeeze=False)
    for (pairs, changes), outcome in zip(axes, outcomes, strict=True):
        _draw_pairs(pairs, outcome)
        _draw_changes(changes, outcome)
    axes[-1, 1].set_xlabel("change in the same world (%)")
    axes[0, 1].legend(handles=LEGEND, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3)


def _draw_pairs(ax: Axes, outcome: Outcome) -> None:
    """Join the largest inclination of both variants in each world; a fall leaves the axes."""
    values = np.array([[_inclination(summary) for summary in pair] for pair in outcome.pairs])
    top = 1.25 * np.nanmax(values, initial=1.0)
    for pair in np.nan_to_num(values, nan=1.1 * top):
        ax.plot([0, 1], pair, lw=0.7, **WORLD)
    names = [f"{name}\n{fallen} fell" for name, fallen in outcome.falls().items()]
    ax.set(xlim=(-0.3, 1.3), ylim=(0.0, top), xticks=[0, 1], xticklabels=names)
    ax.set_ylabel("inclination (°)")
    ax.set_title(outcome.experiment.title, fontsize=8.5)
    ax.grid(axis="x", visible=False)


def _inclination(summary: Summary) -> float:
    """Return the largest inclination about both axes together; NaN for a fall or an error."""
    if not survived(summary):
        return np.nan
    return float(np.hypot(*summary["max_inclination_deg"].values()))


def _draw_changes(ax: Axes, outcome: Outcome) -> None:
    """Draw every paired change, their median and quartiles, and the paper's figure."""
    ax.axvline(0.0, color=FAINT, lw=0.8)
    for row, (metric, axis, _) in enumerate(ENTRIES):
        changes = outcome.changes(metric, axis)
        if len(changes):
            spread = 0.15 * (np.arange(len(changes)) % 5 - 2) if len(changes) > 1 else 0.0
            ax.plot(changes, np.full(len(changes), row) + spread, ls="none", **WORLD)
            first, middle, third = np.percentile(changes, [25, 50, 75])
            ax.plot([first, third], [row, row], color=INK, lw=3.5, alpha=0.35)
            ax.plot(middle, row, **MEDIAN)
        reported = outcome.experiment.paper.get(metric, {}).get(axis)
        if reported is not None:
            ax.plot(reported, row, **PAPER)
    if not len(changes):
        ax.text(0.5, 0.5, "in no world both stay up", transform=ax.transAxes, ha="center")
    low, high = ax.get_xlim()
    ax.set(ylim=(len(ENTRIES) - 0.5, -0.5), xlim=(min(low, -10.0), max(high, 10.0)))
    ax.set_yticks(range(len(ENTRIES)), [label for *_, label in ENTRIES])
    ax.grid(axis="y", visible=False)
