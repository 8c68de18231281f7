"""Panels whose abscissa is not time: the walk from above, pressure in the foot, phase portrait."""

from collections.abc import Iterator

import numpy as np

from lola_drake.figures.balance import balance, centre_of_pressure
from lola_drake.figures.balance_figures import greatest_pad_forces, inclination_rate_deg
from lola_drake.figures.footprints import pad_corners, sole_corners, stances
from lola_drake.figures.style import FIRST, FOOT_COLOURS, FOOT_NAMES, SECOND, THIRD
from lola_drake.metrics import inclination_deg
from lola_drake.reports.panels import PLAN, Cell, Curve, Panel
from lola_drake.results import Result
from lola_drake.signals import FEET

EVERY = 5
"""Only each fifth sample is drawn in a plane."""


def plane_panels(result: Result) -> Iterator[Panel]:
    """Give the panels in a plane of one run; of two runs they have the same cells."""
    yield _from_above(result)
    yield _pressure(result)
    yield _phase(result)


def _plane(name: str, points: np.ndarray, colour: str, **style) -> Curve:
    points = points[::EVERY]
    return Curve(name, points[:, 1], colour, across=points[:, 0], **style)


def _from_above(result: Result) -> Panel:
    at = balance(result)
    curves = [
        _plane("ZMP", at.zmp, SECOND),
        _plane("CoM", at.com, THIRD),
        _plane("ZMP, plan", at.planned_zmp, PLAN, dash="dot", plan=True),
    ]
    soles = [sole_corners(pose) for foot in FEET for _, pose in stances(result, foot)]
    cell = Cell("", "y (m)", curves, across="x (m)", outlines=soles, square=True)
    return Panel("From above: where the feet stood, and how CoM and ZMP went there", [cell])


def _pressure(result: Result) -> Panel:
    cells, greatest = [], greatest_pad_forces(result)
    pads = [corners[:, ::-1] * [-1, 1] for corners in pad_corners(np.zeros(3))]
    for foot, forces in zip(FEET, greatest, strict=True):
        to_right = centre_of_pressure(result, foot)[:, ::-1] * [-1, 1]
        curve = _plane("centre of pressure", to_right, FOOT_COLOURS[foot])
        notes = [
            (*pad.mean(axis=0).round(4).tolist(), f"≤ {force:.0f} N")
            for pad, force in zip(pads, forces, strict=True)
        ]
        axes = "forward (m)", [curve], "to the right (m)"
        cells.append(
            Cell(f"{FOOT_NAMES[foot]} foot", *axes, outlines=pads, square=True, notes=notes)
        )
    return Panel("Centre of pressure in the foot, and what its pads bear", cells, columns=2)


def _phase(result: Result) -> Panel:
    angle, rate = inclination_deg(result.signals["torso_pose"]), inclination_rate_deg(result)
    cells = []
    for i, (axis, colour) in enumerate((("x (roll)", FIRST), ("y (pitch)", SECOND))):
        points = np.column_stack([angle[:, i], rate[:, i]])
        curve = _plane("inclination", points, colour)
        cells.append(Cell(f"about {axis}", "dφ/dt (deg/s)", [curve], across="φ (deg)"))
    return Panel("Phase portrait of the torso", cells, columns=2)
