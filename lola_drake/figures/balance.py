"""How the robot keeps its balance: centre of mass, zero moment point, DCM, centre of pressure."""

from dataclasses import dataclass

import numpy as np

from lola_drake.figures.footprints import to_world, vertical_force, zero_moment_point
from lola_drake.results import Result
from lola_drake.signals import CONTACT_WRENCH, FEET, PERIOD, PLANNED_MOTION
from lola_drake.theory.constants import GRAVITY

LEAST_HEIGHT = 0.2
"""Of the CoM over the feet (m), for the time constant of the pendulum; a fallen robot has none."""


@dataclass(frozen=True)
class Balance:
    """Points on the ground in W over time (m), each of shape (n, 2).

    Attributes:
        com: Centre of mass, of the plant.
        dcm: Divergent component of motion, c + c_dot / omega; omega^2 = g / (height of the CoM).
        zmp: From the sensors of both feet; NaN where nothing is loaded.
        planned_zmp: What the walking pattern wanted.
    """

    com: np.ndarray
    dcm: np.ndarray
    zmp: np.ndarray
    planned_zmp: np.ndarray


def balance(result: Result) -> Balance:
    """Return the points that balance is about."""
    signals = result.signals
    com = signals["com_position"]
    sole = np.minimum(*(signals[f"foot_pose_{foot}"][:, 2] for foot in FEET))
    height = np.maximum(com[:, 2] - sole, LEAST_HEIGHT)
    velocity = np.gradient(com[:, :2], PERIOD, axis=0) if len(com) > 1 else 0 * com[:, :2]
    planned = signals["planned_motion"][:, PLANNED_MOTION.slice("zmp")]
    return Balance(
        com=com[:, :2],
        dcm=com[:, :2] + velocity * np.sqrt(height / GRAVITY)[:, None],
        zmp=zero_moment_point(signals),
        planned_zmp=to_world(result.scenario, planned),
    )


def centre_of_pressure(result: Result, foot: str) -> np.ndarray:
    """Return where the pressure under one foot acts, from its TCP, forward and left (m), (n, 2).

    NaN where the foot is hardly loaded. The axes are those of T, as in eq. 13.
    """
    wrench = result.signals[f"contact_wrench_{foot}"][:, CONTACT_WRENCH.slice("wrench")]
    force = vertical_force(result.signals, foot)
    loaded = np.where(force > 0, force, np.nan)[:, None]
    return np.column_stack([-wrench[:, 1], wrench[:, 0]]) / loaded
