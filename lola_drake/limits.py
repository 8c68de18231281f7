"""What no step of a run should reach: the limits of joints, drives and friction."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lola_drake.ground import Ground
from lola_drake.signals import FEET, GROUND_FORCE

LIMITS = ("joint_angle", "joint_speed", "joint_torque", "friction")

LOADED = 50.0
"""Vertical force (N) from which on a foot counts as standing."""

SLIDING = 0.98
"""Part of the friction coefficient from which on the friction counts as used up."""

Signals = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Limits:
    """What no step of a run should reach.

    Attributes:
        lower, upper: hardware stops of the joints (rad), shape (24,).
        speed: greatest joint speeds (rad/s), shape (24,).
        torque: greatest joint torques (Nm), shape (24,).
        ground: with what lies on it.
    """

    lower: np.ndarray
    upper: np.ndarray
    speed: np.ndarray
    torque: np.ndarray
    ground: Ground


def beyond_limits(signals: Signals, limits: Limits) -> np.ndarray:
    """Return whether a step reached each of the `LIMITS`, shape (n, 4)."""
    reached = limits_reached(signals, limits).values()
    return np.column_stack([where.any(axis=1) for where in reached])


def limits_reached(signals: Signals, limits: Limits) -> dict[str, np.ndarray]:
    """Return when what is at its limit, by the `LIMITS`.

    Of joints the arrays have the shape (n, 24), of the friction (n, 2), a column for each foot.
    """
    q = signals["joint_position"]
    reached = (
        (q <= limits.lower) | (q >= limits.upper),
        np.abs(signals["joint_velocity"]) >= limits.speed,
        np.abs(signals["joint_torque"]) >= limits.torque,
        np.column_stack([_sliding(signals, foot, limits.ground) for foot in FEET]),
    )
    return dict(zip(LIMITS, reached, strict=True))


def _sliding(signals: Signals, foot: str, ground: Ground) -> np.ndarray:
    """Return when the ground where a foot's TCP is gives all the friction that it has."""
    force = signals["ground_force"][:, GROUND_FORCE.slice(f"F_{foot}")]
    at = ground.surface(signals[f"foot_pose_{foot}"][:, :2])
    pressing = (force * at.normal).sum(axis=1)
    along = np.linalg.norm(force - pressing[:, None] * at.normal, axis=1)
    return (pressing > LOADED) & (along > SLIDING * at.friction * pressing)
