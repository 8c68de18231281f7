"""What there is to see at one time of a recorded run, beside the robot itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from lola_drake.figures.footprints import pressure_point, zero_moment_point
from lola_drake.pushes import Push
from lola_drake.results import Result
from lola_drake.robot import Kinematics
from lola_drake.scenario import Ground, Scenario
from lola_drake.signals import FEET, GROUND_FORCE

SEEN = 0.3
"""For so long (s) a push can be seen, also if it is shorter."""


@dataclass(frozen=True)
class Frame:
    """What the markers show at one time, everything in W.

    Attributes:
        torso: x, y, z (m), roll, pitch, yaw (rad), shape (6,).
        com: Centre of mass (m), shape (3,).
        zmp: On the ground (m), shape (3,); NaN where nothing is loaded.
        forces: Ground force on the left and right foot (N), shape (2, 3).
        origins: Where they act (m), shape (2, 3).
        pushes: Where a push acts (m) and its mean force (N), shape (n, 2, 3).
    """

    torso: np.ndarray
    com: np.ndarray
    zmp: np.ndarray
    forces: np.ndarray
    origins: np.ndarray
    pushes: np.ndarray


def frame_samples(times: np.ndarray, per_second: float) -> np.ndarray:
    """Return which samples of a run are the frames of a film."""
    frames = np.arange(times[0], times[-1] + 1e-9, 1 / per_second)
    return np.searchsorted(times, frames - 1e-9)


def frames_at(result: Result, samples: np.ndarray) -> list[Frame]:
    """Return what there is to see at some samples of a run."""
    signals = {name: values[samples] for name, values in result.signals.items()}
    pushes = [seen_pushes(result.scenario, time) for time in result.times[samples]]
    return frames_of(signals, result.scenario.terrain, pushes)


def seen_pushes(scenario: Scenario, time: float) -> list[Push]:
    """Return the pushes that can be seen at a time (s)."""
    return [p for p in scenario.pushes if p.time <= time < max(p.end, p.time + SEEN)]


def frames_of(
    signals: dict[str, np.ndarray],
    ground: Ground,
    pushes: Sequence[Sequence[Push]] | None = None,
) -> list[Frame]:
    """Return what there is to see in each row of the signals.

    Args:
        signals: of a record.
        ground: that the robot is on.
        pushes: those to be seen in each row; none unless given.
    """
    zmp = zero_moment_point(signals)
    heights = np.where(np.isfinite(zmp).all(axis=1), ground.surface(zmp).height, np.nan)
    forces = [signals["ground_force"][:, GROUND_FORCE.slice(f"F_{foot}")] for foot in FEET]
    origins = [
        np.column_stack([pressure_point(signals, foot), signals[f"foot_pose_{foot}"][:, 2]])
        for foot in FEET
    ]
    return [
        Frame(
            torso=torso,
            com=signals["com_position"][i],
            zmp=np.r_[zmp[i], heights[i]],
            forces=np.array([force[i] for force in forces]),
            origins=np.array([origin[i] for origin in origins]),
            pushes=_arrows(pushes[i] if pushes else (), torso, signals["joint_position"][i]),
        )
        for i, torso in enumerate(signals["torso_pose"])
    ]


_kinematics = cache(Kinematics)


def _arrows(pushes: Sequence[Push], torso: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return where pushes act in W and their mean forces, shape (n, 2, 3)."""
    if not pushes:
        return np.empty((0, 2, 3))
    robot, place = _kinematics(), RigidTransform(RollPitchYaw(torso[3:]), torso[:3])
    robot.update(joints)
    # The model's torso stands upright in its own world.
    bodies = [robot.plant.GetBodyByName(push.body) for push in pushes]
    points = [
        place @ body.EvalPoseInWorld(robot.context) @ push.point
        for push, body in zip(pushes, bodies, strict=True)
    ]
    forces = [push.mean_force() for push in pushes]
    return np.stack([points, forces], axis=1)
