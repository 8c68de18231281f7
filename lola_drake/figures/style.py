"""The one look of all figures: colours, sizes, and the gait's phases under every time axis."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import product
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from lola_drake.metrics import touchdowns
from lola_drake.results import Result
from lola_drake.signals import CONTACT, FEET, GAIT_PHASE

# Okabe and Ito: told apart by readers with any colour vision.
LEFT, RIGHT = "#0072B2", "#D55E00"
FIRST, SECOND, THIRD = "#009E73", "#CC79A7", "#56B4E9"
PLAN, INK, FAINT, NOISE = "#222222", "#222222", "#8a8f98", "#c3c8cf"
GROUND, LIMIT, PUSHED = "#b8935a", "#b00020", "#8e24aa"
DASHED = (0, (4, 2))
FOOT_COLOURS = dict(zip(FEET, (LEFT, RIGHT), strict=True))
FOOT_NAMES = dict(zip(FEET, ("left", "right"), strict=True))

LOOK: dict[Any, object] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#c4c8ce",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8eb",
    "grid.linewidth": 0.7,
    "xtick.color": "#5f6873",
    "ytick.color": "#5f6873",
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "lines.linewidth": 1.1,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "svg.hashsalt": "lola",
    "path.simplify_threshold": 0.4,
}

WIDTH, ROW, BAND = 9.0, 1.65, 0.34
"""Width of a figure, height of one row of axes, height of the gait band (inches)."""

PIECES = 1200
"""Into how many pieces a signal is cut to plot it; a figure has fewer pixels across than twice
as many."""


@contextmanager
def look() -> Iterator[None]:
    """Make figures in the one look while it lasts."""
    with matplotlib.rc_context(LOOK):
        yield


def time_figure(
    result: Result, rows: int, columns: int = 1, *, title: str, row_height: float = ROW
) -> tuple[Figure, np.ndarray]:
    """Return a figure of axes over time, shape (rows, columns), with the gait band below."""
    height = rows * row_height + BAND + 0.95
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    add_title(figure, title)
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[row_height] * rows + [BAND])
    axes = np.empty((rows, columns), dtype=object)
    first: Axes | None = None
    for column in range(columns):
        for row in range(rows):
            axes[row, column] = figure.add_subplot(grid[row, column], sharex=first)
            first = first or axes[row, column]
            axes[row, column].tick_params(labelbottom=False)
        draw_gait(figure.add_subplot(grid[rows, column], sharex=first), result)
    mark_pushes(result, axes.flat)
    if result.fall_time is not None:
        for ax in axes.flat:
            ax.axvline(result.fall_time, color=LIMIT, lw=1.2)
        fall = f"fell at {result.fall_time:.2f} s"
        figure.text(0.99, 0.995, fall, color=LIMIT, ha="right", va="top", fontweight="bold")
    axes[0, 0].set_xlim(0.0, max(result.duration, 1e-3))
    return figure, axes


def mark_pushes(result: Result, axes: Iterable[Axes]) -> None:
    """Draw the times of a run's pushes into axes over time."""
    for push, ax in product(result.scenario.pushes, axes):
        if push.time < result.duration:
            ax.axvspan(push.time, push.end, color=PUSHED, alpha=0.25, lw=0)


def add_title(figure: Figure, title: str) -> None:
    """Write the title at the upper left of a figure."""
    figure.suptitle(title, x=0.012, ha="left", fontsize=11, fontweight="bold", color=INK)


def add_legend(axes: Axes) -> None:
    """Write the legend above the axes, where it hides nothing."""
    count = len(axes.get_legend_handles_labels()[0])
    axes.legend(
        **{"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": count},
        **{"borderpad": 0.1, "borderaxespad": 0.15, "handlelength": 1.6, "columnspacing": 1.4},
    )


def plot(axes: Axes, times: np.ndarray, values: np.ndarray, **style) -> None:
    """Plot a long signal by the least and greatest value in each of many short pieces."""
    step = max(len(times) // PIECES, 1)
    if step > 1:
        whole = len(times) // step * step
        pieces = values[:whole].reshape(-1, step)
        extremes = np.sort(np.column_stack([pieces.argmin(axis=1), pieces.argmax(axis=1)]), axis=1)
        kept = (extremes + step * np.arange(len(pieces))[:, None]).ravel()
        times, values = times[kept], values[kept]
    axes.plot(times, values, **style)


def draw_gait(axes: Axes, result: Result) -> None:
    """Fill the axes with the gait: planned support as bars, closed contacts as lines in them."""
    times, gait = result.times, result.signals["gait_phase"]
    support = gait[:, GAIT_PHASE.slice("support")] > 0.5
    for i, foot in enumerate(FEET):
        closed = result.signals["contact"][:, CONTACT.slice(f"pads_{foot}")].any(axis=1)
        y, colour = -i, FOOT_COLOURS[foot]
        axes.broken_barh(intervals(times, support[:, i]), (y - 0.4, 0.8), color=colour, alpha=0.3)
        axes.broken_barh(intervals(times, closed), (y - 0.12, 0.24), color=colour)
    for time in times[touchdowns(gait)]:
        axes.axvline(time, color=FAINT, lw=0.6)
    axes.set(ylim=(-1.5, 0.5), yticks=[0, -1], yticklabels=["L", "R"], xlabel="time (s)")
    axes.tick_params(axis="y", labelsize=7)
    axes.grid(False)
    axes.spines["left"].set_visible(False)


def intervals(times: np.ndarray, true: ArrayLike) -> list[tuple[float, float]]:
    """Return (start, duration) of every time during which something is true."""
    edges = np.flatnonzero(np.diff(np.r_[False, true, False].astype(int)))
    last = len(times) - 1
    return [
        (times[start], times[min(end, last)] - times[start]) for start, end in edges.reshape(-1, 2)
    ]
