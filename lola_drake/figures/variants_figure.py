"""Variants of one scenario over time, as in the paper's Fig. 6 and 7."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lola_drake.contact_events import Landing, surprises
from lola_drake.figures.comparison import RUN_COLOURS
from lola_drake.figures.style import DASHED, FAINT, FOOT_NAMES, NOISE, look, mark_pushes, plot
from lola_drake.logged import COM_POSITION
from lola_drake.metrics import inclination_deg, vertical_acceleration
from lola_drake.results import Result
from lola_drake.signals import PLANNED_MOTION

SIZE = (7.0, 5.2)
"""Inches: the width of both columns of a paper."""

LEAD, TAIL = 1.0, 3.0
"""What is shown before the first and after the last unexpected contact (s)."""

STYLES = (DASHED, "-", ":", "-.")
"""Of the lines, so that they can be told apart without colours."""

ROWS = (
    "inclination $\\varphi_x$ (°)",
    "inclination $\\varphi_y$ (°)",
    "$\\Delta\\ddot z_c$ (m/s²)",
)


def variants_figure(results: Sequence[Result]) -> Figure:
    """Return inclinations and the CoM's vertical acceleration over the planned one.

    Around contacts that come early or late; all of a run in which there are none. Where somebody
    falls, the axes are those of the others.
    """
    with look():
        figure = Figure(figsize=SIZE, layout="constrained")
        _draw(figure, results)
    return figure


def _draw(figure: Figure, results: Sequence[Result]) -> None:
    axes = figure.subplots(len(ROWS), 1, sharex=True)
    for result, colour, style in zip(results, RUN_COLOURS, STYLES, strict=False):
        name, fall_time = result.scenario.variant, result.fall_time
        label = name if fall_time is None else f"{name}, fell at {fall_time:.1f} s"
        for ax, curve in zip(axes, _curves(result), strict=True):
            plot(ax, result.times, curve, color=colour, ls=style, label=label)
    for ax, label in zip(axes, ROWS, strict=True):
        ax.set_ylabel(label)
        ax.axhline(0.0, color=FAINT, lw=0.6)
    unexpected = surprises(results)
    _mark(axes, unexpected)
    mark_pushes(results[0], axes)
    axes[-1].set(xlabel="time (s)", xlim=_window(results, unexpected))
    axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(results))
    standing = [_curves(result) for result in results if result.fall_time is None]
    if 0 < len(standing) < len(results):
        for ax, *curves in zip(axes, *standing, strict=True):
            low, high = min(map(np.min, curves)), max(map(np.max, curves))
            margin = 0.3 * (high - low) or 1.0
            ax.set_ylim(low - margin, high + margin)
    figure.align_ylabels(axes)


def _curves(result: Result) -> list[np.ndarray]:
    return [*inclination_deg(result.signals["torso_pose"]).T, unplanned_acceleration(result)]


def unplanned_acceleration(result: Result) -> np.ndarray:
    """Return by how much the CoM's vertical acceleration differs from the plan's (m/s^2)."""
    height = result.signals["com_position"][:, COM_POSITION.slice("p").start + 2]
    planned = result.signals["planned_motion"][:, PLANNED_MOTION.slice("com").start + 2]
    return vertical_acceleration(result.times, height - planned)


def _window(
    results: Sequence[Result], unexpected: Sequence[tuple[Landing, ...]]
) -> tuple[float, float]:
    end = max(result.duration for result in results)
    times = [t for same in unexpected for x in same for t in (x.planned, x.measured)]
    if not times:
        return 0.0, end
    return max(min(times) - LEAD, 0.0), min(max(times) + TAIL, end)


def _mark(axes: Sequence[Axes], unexpected: Sequence[tuple[Landing, ...]]) -> None:
    """Shade from the planned to the last real landing; a line for the landing of each variant."""
    for same in unexpected:
        times = [time for landing in same for time in (landing.planned, landing.measured)]
        for ax in axes:
            ax.axvspan(min(times), max(times), color=NOISE, alpha=0.45, lw=0)
            for landing, colour, style in zip(same, RUN_COLOURS, STYLES, strict=False):
                ax.axvline(landing.measured, color=colour, ls=style, lw=0.7, zorder=0.5)
        axes[0].annotate(
            f"{FOOT_NAMES[same[0].foot]} foot {same[0].kind}",
            (min(times), 1.03),
            xycoords=axes[0].get_xaxis_transform(),
            va="bottom",
            fontsize=7.5,
        )
