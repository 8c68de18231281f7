"""What can be zoomed in a report: panels of cells of curves, without any drawing."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from lola_drake.figures.balance import Balance, balance
from lola_drake.figures.style import FIRST, FOOT_COLOURS, FOOT_NAMES, GROUND, SECOND, THIRD
from lola_drake.metrics import inclination_deg, torque_error
from lola_drake.results import Result
from lola_drake.robot import Kinematics
from lola_drake.signals import (
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    JOINTS,
    PLANNED_MOTION,
    TASK_MODIFICATION,
    TORSO_ORIENTATION,
)

PLAN, NOISE = "ink", "noise"
"""Colours of the reader's theme: the plan has that of text, noise is paler."""


@dataclass(frozen=True)
class Curve:
    """One line.

    Attributes:
        name: In the legend.
        values: Over time; in a plane the ordinates.
        colour: Of a line, "#rrggbb" or one of the theme.
        dash: As Plotly calls it.
        plan: Whether it only tells what was wanted or is noise: a comparison leaves it out of
            all runs but the one it is about.
        across: In a plane the abscissas.
    """

    name: str
    values: np.ndarray
    colour: str
    dash: str = "solid"
    plan: bool = False
    across: np.ndarray | None = None


@dataclass(frozen=True)
class Cell:
    """One pair of axes.

    Attributes:
        title: Above it.
        unit: Of the ordinate.
        curves: In it.
        across: Of the abscissa, if that is not time.
        outlines: Closed lines that lie behind, each of shape (n, 2).
        square: Whether both axes have the same scale.
        notes: Abscissa, ordinate and text of what is written in it; a comparison has none.
    """

    title: str
    unit: str
    curves: list[Curve]
    across: str = ""
    outlines: list[np.ndarray] = field(default_factory=list)
    square: bool = False
    notes: list[tuple[float, float, str]] = field(default_factory=list)


@dataclass(frozen=True)
class Panel:
    """Cells under one title, in rows of some columns.

    Attributes:
        title: Above them.
        cells: Row by row.
        columns: How many stand beside each other where there is room.
        folded: Whether a reader has to open it.
    """

    title: str
    cells: list[Cell]
    columns: int = 1
    folded: bool = False


def time_panels(result: Result) -> Iterator[Panel]:
    """Give the panels over time of one run; of two runs they have the same cells."""
    yield _inclination(result)
    yield _foot_forces(result)
    yield _balance(balance(result))
    yield _foot_heights(result)
    yield _torque_errors(result)
    yield _force_control(result)
    yield _joint_torques(result)


def _inclination(result: Result) -> Panel:
    true = inclination_deg(result.signals["torso_pose"])
    seen = np.degrees(result.signals["torso_orientation"][:, TORSO_ORIENTATION.slice("phi")])
    cells = [
        Cell(
            f"about {axis}",
            "deg",
            [Curve("IMU", seen[:, i], NOISE, plan=True), Curve("torso", true[:, i], colour)],
        )
        for i, (axis, colour) in enumerate((("x (roll)", FIRST), ("y (pitch)", SECOND)))
    ]
    return Panel("Inclination of the torso", cells)


def _foot_forces(result: Result) -> Panel:
    cells = []
    for name, unit, k in (("F_z", "N", 2), ("T_x", "Nm", 0), ("T_y", "Nm", 1)):
        for foot in FEET:
            desired = result.signals["desired_wrench"][:, DESIRED_WRENCH.slice(f"wrench_{foot}")]
            measured = result.signals[f"contact_wrench_{foot}"][:, CONTACT_WRENCH.slice("wrench")]
            curves = [
                Curve("measured", measured[:, k], FOOT_COLOURS[foot]),
                Curve("desired", desired[:, k], PLAN, "dot", plan=True),
            ]
            cells.append(Cell(f"{name}, {FOOT_NAMES[foot]} foot", unit, curves))
    return Panel("Foot forces at the TCP", cells, columns=2)


def _balance(at: Balance) -> Panel:
    cells = [
        Cell(
            axis,
            "m",
            [
                Curve("ZMP", at.zmp[:, i], SECOND),
                Curve("DCM", at.dcm[:, i], FIRST),
                Curve("CoM", at.com[:, i], THIRD),
                Curve("ZMP, plan", at.planned_zmp[:, i], PLAN, "dot", plan=True),
            ],
        )
        for i, axis in enumerate(("x", "y"))
    ]
    return Panel("Centre of mass, zero moment point, divergent component of motion", cells)


def _foot_heights(result: Result) -> Panel:
    start, ground = result.scenario.start, result.scenario.terrain
    base = ground.height_at(start.x, start.y)
    cells = []
    for foot in FEET:
        pose = result.signals[f"foot_pose_{foot}"]
        planned = result.signals["planned_motion"][:, PLANNED_MOTION.slice(f"foot_{foot}")][:, 2]
        below = ground.surface(pose[:, :2]).height
        curves = [
            Curve("ground", 100 * below, GROUND, plan=True),
            Curve("TCP", 100 * pose[:, 2], FOOT_COLOURS[foot]),
            Curve("plan", 100 * (planned + base), PLAN, "dot", plan=True),
        ]
        cells.append(Cell(f"{FOOT_NAMES[foot]} foot", "cm", curves))
    return Panel("Height of the feet", cells)


def _torque_errors(result: Result) -> Panel:
    error = torque_error(result.signals)
    cells = [
        Cell(f"about {axis}", "Nm", [Curve("desired − measured", error[:, i], colour)])
        for i, (axis, colour) in enumerate((("x", FIRST), ("y", SECOND)))
    ]
    return Panel("Error of the torque about the CoM", cells)


def _force_control(result: Result) -> Panel:
    cells = []
    for k, (name, unit, scale) in enumerate(
        (("Δ sin γ_x", "–", 1.0), ("Δ sin γ_y", "–", 1.0), ("Δ z", "mm", 1e3))
    ):
        for foot in FEET:
            delta = result.signals[f"task_modification_{foot}"][
                :, TASK_MODIFICATION.slice("delta_w")
            ]
            curve = Curve("modification", scale * delta[:, k], FOOT_COLOURS[foot])
            cells.append(Cell(f"{name}, {FOOT_NAMES[foot]} foot", unit, [curve]))
    return Panel("What the force control adds to the plan of the feet", cells, columns=2)


def _joint_torques(result: Result) -> Panel:
    limits = Kinematics().effort_limits
    torques = result.signals["joint_torque"]
    cells = []
    for i in sorted(range(len(JOINTS)), key=lambda i: (JOINTS[i][:-1], JOINTS[i])):
        side = JOINTS[i][-1]
        colour = FOOT_COLOURS.get(side, FIRST) if len(JOINTS[i]) == 4 else FIRST
        curve = Curve("torque", torques[:, i], colour)
        cells.append(Cell(f"{JOINTS[i]}, limit ±{limits[i]:.0f} Nm", "Nm", [curve]))
    return Panel("Joint torques", cells, columns=4, folded=True)
