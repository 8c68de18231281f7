"""The walk from above: footprints, centre of mass, zero moment point."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon
from matplotlib.transforms import Affine2D
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from lola_drake.figures.style import (
    DASHED,
    FOOT_COLOURS,
    FOOT_NAMES,
    PLAN,
    SECOND,
    THIRD,
    WIDTH,
    add_title,
)
from lola_drake.results import Result
from lola_drake.robot import PADS
from lola_drake.scenario import Obstacle, Scenario
from lola_drake.signals import CONTACT_WRENCH, FEET, GAIT_PHASE, PLANNED_MOTION

LOADED = 60.0
"""Vertical force of both feet (N) below which there is no point of pressure to speak of."""

_AROUND = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def footprints(result: Result) -> Figure:
    """Return where the feet stood, what they could support, and how CoM and ZMP went there."""
    signals = result.signals
    standing = [stance for foot in FEET for stance in stances(result, foot)]
    areas = [area for area in support_areas(result) if len(area)]
    zmp, com = zero_moment_point(signals), signals["com_position"][:, :2]
    planned = to_world(result.scenario, signals["planned_motion"][:, PLANNED_MOTION.slice("zmp")])

    outlines = [sole_corners(pose) for _, pose in standing]
    points = np.vstack([com, *outlines])
    low, high = points.min(axis=0) - 0.1, points.max(axis=0) + 0.1
    aspect = (high[1] - low[1]) / (high[0] - low[0])
    height = min((WIDTH - 0.8) * aspect, 6.5) + 1.15
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    add_title(figure, "Centre of mass and zero moment point from above")
    ax = figure.add_subplot()
    for board in result.scenario.terrain.boards:
        ax.add_patch(_outline(board))
    for area in areas:
        ax.add_patch(Polygon(area, facecolor="#000000", alpha=0.035, lw=0))
    for foot, pose in standing:
        for corners in pad_corners(pose):
            ax.add_patch(Polygon(corners, facecolor=FOOT_COLOURS[foot], alpha=0.28, lw=0))
        ax.add_patch(Polygon(sole_corners(pose), fill=False, edgecolor=FOOT_COLOURS[foot], lw=0.7))
    ax.plot(*planned.T, color=PLAN, lw=0.8, ls=DASHED, label="ZMP, plan")
    ax.plot(*zmp.T, color=SECOND, lw=0.8, label="ZMP, measured")
    ax.plot(*com.T, color=THIRD, lw=1.6, label="CoM")
    ax.set(xlabel="x (m)", ylabel="y (m)", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set_aspect("equal", adjustable="box")
    feet = [Patch(color=FOOT_COLOURS[f], alpha=0.4, label=f"{FOOT_NAMES[f]} foot") for f in FEET]
    feet.append(Patch(color="#000000", alpha=0.1, label="double support"))
    handles = [*ax.get_legend_handles_labels()[0], *feet]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def to_world(scenario: Scenario, points: np.ndarray) -> np.ndarray:
    """Return points of the plan's frame P in W, shape (n, 2)."""
    start = scenario.start
    turn = Affine2D().rotate_deg(start.heading_deg).translate(start.x, start.y)
    return turn.transform(points)


def zero_moment_point(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return where the pressure under both feet acts, from their sensors, in W, shape (n, 2).

    NaN where the feet are not loaded.
    """
    forces = np.array([vertical_force(signals, foot) for foot in FEET])
    points = np.array([pressure_point(signals, foot) for foot in FEET])
    total = forces.sum(axis=0)
    weighted = np.where(forces[..., None] > 0.0, forces[..., None] * points, 0.0).sum(axis=0)
    return weighted / np.where(total > LOADED, total, np.nan)[:, None]


def vertical_force(signals: Mapping[str, np.ndarray], foot: str) -> np.ndarray:
    """Return the vertical force on one foot as its sensor has it, none if it is hardly loaded."""
    force = signals[f"contact_wrench_{foot}"][:, CONTACT_WRENCH.slice("wrench")][:, 2]
    return np.where(force > LOADED, force, 0.0)


def pressure_point(signals: Mapping[str, np.ndarray], foot: str) -> np.ndarray:
    """Return where the pressure under one foot acts, in W, shape (n, 2); NaN if hardly loaded."""
    torque = signals[f"contact_wrench_{foot}"][:, CONTACT_WRENCH.slice("wrench")][:, :2]
    force = vertical_force(signals, foot)[:, None]
    x, y = np.divide([-1, 1] * torque[:, ::-1], np.where(force > 0, force, np.nan)).T
    # The torques are about T's axes, which are turned by the robot's heading.
    yaw = signals["torso_pose"][:, 5]
    c, s = np.cos(yaw), np.sin(yaw)
    return signals[f"foot_pose_{foot}"][:, :2] + np.column_stack([c * x - s * y, s * x + c * y])


def planned_footsteps(result: Result) -> dict[str, list[np.ndarray]]:
    """Return x, y, z, yaw in W of every place where a foot was planned to stand, by foot."""
    start = result.scenario.start
    base = result.scenario.terrain.height_at(start.x, start.y)
    footsteps = {}
    for foot in FEET:
        planned = result.signals["planned_motion"][:, PLANNED_MOTION.slice(f"foot_{foot}")]
        places = planned[_stance_middles(result, foot)]
        footsteps[foot] = [
            np.r_[
                to_world(result.scenario, place[None, :2])[0], place[2] + base, place[3] + heading
            ]
            for place, heading in ((p, np.deg2rad(start.heading_deg)) for p in places)
        ]
    return footsteps


def stances(result: Result, foot: str) -> list[tuple[str, np.ndarray]]:
    """Return (foot, x, y, yaw) in the middle of every time the foot was planned to stand."""
    places = result.signals[f"foot_pose_{foot}"][_stance_middles(result, foot)]
    return [(foot, place[[0, 1, 5]]) for place in places]


def _stance_middles(result: Result, foot: str) -> np.ndarray:
    column = GAIT_PHASE.slice("support").start + FEET.index(foot)
    return _middles(result.signals["gait_phase"][:, column] > 0.5)


def _middles(true: ArrayLike) -> np.ndarray:
    """Return the middle sample of every run of samples for which something is true."""
    edges = np.flatnonzero(np.diff(np.r_[False, true, False].astype(int))).reshape(-1, 2)
    return edges.mean(axis=1).astype(int)


def support_areas(result: Result) -> list[np.ndarray]:
    """Return the convex hull of both feet in every double support."""
    support = result.signals["gait_phase"][:, GAIT_PHASE.slice("support")] > 0.5
    areas = []
    for middle in _middles(support.all(axis=1)):
        poses = [result.signals[f"foot_pose_{foot}"][middle][[0, 1, 5]] for foot in FEET]
        corners = np.vstack([sole_corners(pose) for pose in poses])
        areas.append(corners[ConvexHull(corners).vertices])
    return areas


def pad_corners(pose: np.ndarray) -> list[np.ndarray]:
    """Return the corners of each pad of a foot at x, y, yaw in W."""
    place = Affine2D().rotate(pose[2]).translate(*pose[:2])
    return [
        place.transform(
            [(pad.x + a * pad.length / 2, pad.y + b * pad.width / 2) for a, b in _AROUND]
        )
        for pad in PADS
    ]


def sole_corners(pose: np.ndarray) -> np.ndarray:
    """Return the corners of the rectangle around the pads of a foot at x, y, yaw in W."""
    points = np.vstack(pad_corners(np.zeros(3)))
    (x_low, y_low), (x_high, y_high) = points.min(axis=0), points.max(axis=0)
    corners = [(x_low, y_low), (x_high, y_low), (x_high, y_high), (x_low, y_high)]
    return Affine2D().rotate(pose[2]).translate(*pose[:2]).transform(corners)


def _outline(board: Obstacle) -> Polygon:
    return Polygon(board.outline.corners(), color=board.colour, alpha=0.3, lw=0)
