"""Figures about balance: CoM, ZMP and DCM, the phase portrait, the pressure under the feet."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from lola_drake.figures.balance import balance, centre_of_pressure
from lola_drake.figures.footprints import pad_corners, sole_corners
from lola_drake.figures.style import (
    DASHED,
    FAINT,
    FIRST,
    FOOT_COLOURS,
    FOOT_NAMES,
    INK,
    PLAN,
    SECOND,
    THIRD,
    add_legend,
    add_title,
    plot,
    time_figure,
)
from lola_drake.metrics import inclination_deg
from lola_drake.pad_forces import pad_forces
from lola_drake.results import Result
from lola_drake.signals import FEET, TORSO_ORIENTATION

SIZE = (9.0, 4.6)
"""Of a figure of two planes beside each other (inches)."""

EVERY = 30
"""Samples from one look at the pads' forces to the next."""


def com_zmp_dcm(result: Result) -> Figure:
    """Return centre of mass, zero moment point and divergent component of motion over time."""
    figure, axes = time_figure(result, 2, title="Centre of mass, ZMP and DCM")
    at = balance(result)
    for i, axis in enumerate(("x", "y")):
        ax = axes[i, 0]
        plot(ax, result.times, at.zmp[:, i], color=SECOND, lw=0.8, label="ZMP")
        plot(ax, result.times, at.dcm[:, i], color=FIRST, label="DCM")
        plot(ax, result.times, at.com[:, i], color=THIRD, lw=1.6, label="CoM")
        planned = at.planned_zmp[:, i]
        plot(ax, result.times, planned, color=PLAN, lw=0.8, ls=DASHED, label="ZMP, plan")
        ax.set_ylabel(f"{axis} (m)")
    add_legend(axes[0, 0])
    return figure


def phase_portrait(result: Result) -> Figure:
    """Return the torso's inclination against its rate, about both axes."""
    figure = Figure(figsize=SIZE, layout="constrained")
    add_title(figure, "Phase portrait of the torso")
    angle, rate = inclination_deg(result.signals["torso_pose"]), inclination_rate_deg(result)
    for i, (axis, colour) in enumerate((("x (roll)", FIRST), ("y (pitch)", SECOND))):
        ax = figure.add_subplot(1, 2, i + 1)
        ax.axhline(0.0, color=FAINT, lw=0.6)
        ax.axvline(0.0, color=FAINT, lw=0.6)
        ax.plot(angle[::4, i], rate[::4, i], color=colour, lw=0.7)
        ax.plot(*(values[-1:, i] for values in (angle, rate)), "o", color=INK, ms=4, label="end")
        ax.set(title=f"about {axis}", xlabel="φ (deg)", ylabel="dφ/dt (deg/s)")
        add_legend(ax)
    return figure


def inclination_rate_deg(result: Result) -> np.ndarray:
    """Return the rate of the torso's inclination as the IMU has it (deg/s), shape (n, 2)."""
    return np.degrees(result.signals["torso_orientation"][:, TORSO_ORIENTATION.slice("phi_dot")])


def foot_pressure(result: Result) -> Figure:
    """Return the way of the centre of pressure in each foot, and what its pads had to bear."""
    figure = Figure(figsize=SIZE, layout="constrained")
    add_title(figure, "Centre of pressure in the foot, and the pads' greatest forces")
    greatest = greatest_pad_forces(result)
    for i, foot in enumerate(FEET):
        ax = figure.add_subplot(1, 2, i + 1)
        for corners, force in zip(pad_corners(np.zeros(3)), greatest[i], strict=True):
            shade = min(force / max(greatest.max(), 1.0), 1.0)
            around = corners[:, ::-1] * [-1, 1]
            ax.add_patch(Polygon(around, color=FOOT_COLOURS[foot], alpha=0.08 + 0.4 * shade, lw=0))
            # Beyond the pad, where no curve is.
            below = around[:, 1].mean() < 0
            at = around[:, 1].min() - 0.006 if below else around[:, 1].max() + 0.006
            x, side = around[:, 0].mean(), "top" if below else "bottom"
            ax.text(x, at, f"{force:.0f} N", ha="center", va=side, fontsize=8, color=INK)
        sole = sole_corners(np.zeros(3))[:, ::-1] * [-1, 1]
        ax.add_patch(Polygon(sole, fill=False, edgecolor=FAINT, lw=0.7))
        at = centre_of_pressure(result, foot)
        ax.plot(-at[::4, 1], at[::4, 0], color=FOOT_COLOURS[foot], lw=0.6)
        ax.set(title=f"{FOOT_NAMES[foot]} foot", xlabel="to the right (m)", ylabel="forward (m)")
        ax.set(xlim=(-0.15, 0.15), ylim=(-0.18, 0.18))
        ax.set_aspect("equal", adjustable="box")
    return figure


def greatest_pad_forces(result: Result) -> np.ndarray:
    """Return the greatest force on each pad while the run went on (N), by foot, shape (2, 4)."""
    samples = np.arange(0, len(result.times), EVERY)
    return pad_forces(result, samples).max(axis=0, initial=0.0).reshape(len(FEET), -1)
