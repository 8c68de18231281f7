"""The figures of one run; each is a function from the run to a Matplotlib figure."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lola_drake.atomic_file import whole_file
from lola_drake.figures.balance_figures import com_zmp_dcm, foot_pressure, phase_portrait
from lola_drake.figures.footprints import footprints
from lola_drake.figures.style import (
    DASHED,
    FAINT,
    FIRST,
    FOOT_COLOURS,
    FOOT_NAMES,
    GROUND,
    LEFT,
    LIMIT,
    NOISE,
    PLAN,
    RIGHT,
    SECOND,
    add_legend,
    look,
    plot,
    time_figure,
)
from lola_drake.metrics import inclination_deg, torque_error
from lola_drake.results import Result
from lola_drake.signals import (
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    JOINTS,
    PLANNED_MOTION,
    TASK_MODIFICATION,
    TORSO_ORIENTATION,
)


def inclination(result: Result) -> Figure:
    """Return the torso's inclination: as it was, and as the IMU saw it."""
    figure, axes = time_figure(result, 2, title="Inclination of the torso")
    true = inclination_deg(result.signals["torso_pose"])
    measured = result.signals["torso_orientation"][:, TORSO_ORIENTATION.slice("phi")]
    for i, (axis, colour) in enumerate((("x (roll)", FIRST), ("y (pitch)", SECOND))):
        ax = axes[i, 0]
        plot(ax, result.times, np.degrees(measured[:, i]), color=NOISE, lw=0.7, label="IMU")
        plot(ax, result.times, true[:, i], color=colour, label="torso")
        ax.set(title=f"about {axis}", ylabel="angle (deg)")
        add_legend(ax)
    return figure


def foot_forces(result: Result) -> Figure:
    """Return desired against measured torques and vertical force of both feet."""
    figure, axes = time_figure(result, 3, 2, title="Foot forces at the TCP: desired and measured")
    units = ("T_x (Nm)", "T_y (Nm)", "F_z (N)")
    for column, foot in enumerate(FEET):
        desired = result.signals["desired_wrench"][:, DESIRED_WRENCH.slice(f"wrench_{foot}")]
        measured = result.signals[f"contact_wrench_{foot}"][:, CONTACT_WRENCH.slice("wrench")]
        for row, k in enumerate((2, 0, 1)):
            ax = axes[row, column]
            plot(ax, result.times, measured[:, k], color=FOOT_COLOURS[foot], label="measured")
            plot(ax, result.times, desired[:, k], color=PLAN, lw=0.9, ls=DASHED, label="desired")
            if column == 0:
                ax.set_ylabel(units[k])
            else:
                ax.sharey(axes[row, 0])
        axes[0, column].set_title(f"{FOOT_NAMES[foot]} foot")
        add_legend(axes[0, column])
    return figure


def foot_heights(result: Result) -> Figure:
    """Return how high each foot's TCP was over the ground and in the plan."""
    figure, axes = time_figure(result, 2, title="Height of the feet")
    start, ground = result.scenario.start, result.scenario.terrain
    base = ground.height_at(start.x, start.y)
    for row, foot in enumerate(FEET):
        ax, pose = axes[row, 0], result.signals[f"foot_pose_{foot}"]
        planned = result.signals["planned_motion"][:, PLANNED_MOTION.slice(f"foot_{foot}")][:, 2]
        every = slice(None, None, 10)
        below = 100 * ground.surface(pose[every, :2]).height
        ax.fill_between(
            result.times[every], below, -100, color=GROUND, alpha=0.35, lw=0, label="ground"
        )
        plot(ax, result.times, 100 * (planned + base), color=PLAN, lw=0.9, ls=DASHED, label="plan")
        plot(ax, result.times, 100 * pose[:, 2], color=FOOT_COLOURS[foot], label="TCP")
        low, high = 100 * pose[:, 2].min(), 100 * pose[:, 2].max()
        ax.set(title=f"{FOOT_NAMES[foot]} foot", ylabel="height (cm)", ylim=(low - 1.5, high + 1.5))
        add_legend(ax)
    return figure


def force_control(result: Result) -> Figure:
    """Return what the force control adds to the plan of the feet."""
    figure, axes = time_figure(result, 3, title="Modification of the feet by the force control")
    rows = (("Δ sin γ_x (-)", 1.0), ("Δ sin γ_y (-)", 1.0), ("Δ z (mm)", 1e3))
    delta_w = TASK_MODIFICATION.slice("delta_w")
    for k, (label, scale) in enumerate(rows):
        ax = axes[k, 0]
        for foot in FEET:
            delta = scale * result.signals[f"task_modification_{foot}"][:, delta_w][:, k]
            plot(
                ax, result.times, delta, color=FOOT_COLOURS[foot], label=f"{FOOT_NAMES[foot]} foot"
            )
        ax.set_ylabel(label)
    add_legend(axes[0, 0])
    return figure


def torque_errors(result: Result) -> Figure:
    """Return the error of the torque about the CoM, desired less measured."""
    figure, axes = time_figure(result, 2, title="Error of the torque about the CoM")
    error = torque_error(result.signals)
    for i, (axis, colour) in enumerate((("x", FIRST), ("y", SECOND))):
        plot(axes[i, 0], result.times, error[:, i], color=colour)
        axes[i, 0].set(title=f"about {axis}", ylabel="torque (Nm)")
    return figure


def joint_torques(result: Result) -> Figure:
    """Return every joint's torque between its limits, left and right side by side."""
    from lola_drake.robot import Kinematics

    limits = dict(zip(JOINTS, Kinematics().effort_limits, strict=True))
    panels = _joint_panels()
    columns = 5
    rows = -(-len(panels) // columns)
    figure, axes = time_figure(
        result, rows, columns, title="Joint torques and their limits (Nm)", row_height=1.15
    )
    torque = result.signals["joint_torque"]
    for ax, (title, joints) in zip(axes.flat, panels.items(), strict=False):
        limit = limits[joints[0]]
        for joint in joints:
            colour = {"l": LEFT, "r": RIGHT}[joint[-1]] if len(joints) == 2 else FIRST
            plot(ax, result.times, torque[:, JOINTS.index(joint)], color=colour, lw=0.8)
        ax.axhspan(-limit, limit, color=FAINT, alpha=0.08, lw=0)
        for bound in (-limit, limit):
            ax.axhline(bound, color=LIMIT, lw=0.9, ls=DASHED)
        ax.set(title=title, ylim=(-1.15 * limit, 1.15 * limit), yticks=[-limit, 0, limit])
    for ax in axes.flat[len(panels) :]:
        ax.axis("off")
    handles = [
        Line2D([], [], color=colour, ls=dash, label=label)
        for colour, dash, label in (
            (LEFT, "-", "left"),
            (RIGHT, "-", "right"),
            (FIRST, "-", "middle"),
            (LIMIT, DASHED, "limit"),
        )
    ]
    axes.flat[-1].legend(handles=handles, loc="center")
    return figure


_SEGMENTS = {
    "thr": "hip rotation",
    "tha": "hip adduction",
    "thf": "hip flexion",
    "tkf": "knee",
    "tsa": "ankle adduction",
    "tsf": "ankle flexion",
    "tzf": "toe",
    "taf": "shoulder flexion",
    "taa": "shoulder adduction",
    "tef": "elbow",
    "tbr": "pelvis rotation",
    "tba": "pelvis adduction",
    "tvp": "head pan",
    "tvt": "head tilt",
}


def _joint_panels() -> dict[str, list[str]]:
    """Return which joints share a panel, by its title."""
    return {
        title: [name for name in JOINTS if name in (stem, stem + "l", stem + "r")]
        for stem, title in _SEGMENTS.items()
    }


FIGURES: dict[str, Callable[[Result], Figure]] = {
    "inclination": inclination,
    "foot_forces": foot_forces,
    "footprints": footprints,
    "com_zmp_dcm": com_zmp_dcm,
    "foot_pressure": foot_pressure,
    "phase_portrait": phase_portrait,
    "foot_heights": foot_heights,
    "force_control": force_control,
    "torque_errors": torque_errors,
    "joint_torques": joint_torques,
}
"""Every figure by the name of its file."""


def draw_figures(result: Result) -> dict[str, Figure]:
    """Return every figure of a run by its name."""
    with look():
        return {name: draw(result) for name, draw in FIGURES.items()}


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """Return a figure as "svg" or "png"; it is laid out once, for all formats."""
    file = BytesIO()
    with look():
        figure.align_ylabels()
        engine = figure.get_layout_engine()
        if engine is not None:
            engine.execute(figure)
        figure.set_layout_engine("none")
        # By the canvas itself: what is laid out once savefig would draw twice.
        if kind == "svg":
            FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
        else:
            figure.set_dpi(150)
            FigureCanvasAgg(figure).print_png(file)
    return file.getvalue()


def save_figure(figure: Figure, folder: str | Path, name: str) -> None:
    """Write a figure as SVG and PNG into a folder."""
    for kind in ("svg", "png"):
        with whole_file(Path(folder) / f"{name}.{kind}") as file:
            file.write_bytes(figure_bytes(figure, kind))
