"""The explicit contact model of one foot (the paper's section IV.A).

Every element of the sole is a vertical spring of stiffness c_A,z per area. Integrated over the
area in contact this gives the linear relation lambda_f = U x_f between the foot's pose and its
wrench at the TCP, with lambda_f = (T_x, T_y, F_z) and x_f = (sin alpha_x, sin alpha_y,
z_TCP - z_0).

| paper        | here               |
|--------------|--------------------|
| c_A,z        | `area_stiffness`   |
| U            | `contact_matrix()` |
| r = [Fx, Fy] | pad positions      |

The force control moves the foot's command, and not the foot: between them are the servos, which
give way. The gradient that it acts through is that of both in series, `command_gradient()`.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pad:
    """A rectangular part of the sole, in the foot frame F with the TCP as origin.

    Attributes:
        x: position of the pad's centre, forward (m).
        y: position of the pad's centre, to the left (m).
        length: extent along x (m).
        width: extent along y (m).
    """

    x: float
    y: float
    length: float
    width: float

    @property
    def area(self) -> float:
        """Return the pad's area (m^2)."""
        return self.length * self.width


def contact_matrix(pads: Iterable[Pad], area_stiffness: float) -> np.ndarray:
    """Return U of eq. 8 for the pads in contact.

    Args:
        pads: the pads that touch the ground.
        area_stiffness: c_A,z (N/m^3).

    Returns:
        U, shape (3, 3): the gradient of (T_x, T_y, F_z) with respect to
        (sin alpha_x, sin alpha_y, z_TCP).
    """
    area = first_x = first_y = second_xx = second_yy = second_xy = 0.0
    for pad in pads:
        area += pad.area
        first_x += pad.x * pad.area
        first_y += pad.y * pad.area
        second_xx += pad.area * (pad.y**2 + pad.width**2 / 12)
        second_yy += pad.area * (pad.x**2 + pad.length**2 / 12)
        second_xy += pad.area * pad.x * pad.y
    return area_stiffness * np.array(
        [
            [-second_xx, second_xy, -first_y],
            [second_xy, -second_yy, first_x],
            [-first_y, first_x, -area],
        ]
    )


@dataclass(frozen=True)
class ServoCompliance:
    """How a foot gives way to its own wrench, its command held.

    Each servo is a spring with a damper beside it, of one time constant for all.

    Attributes:
        matrix: C, the motion (sin gamma_x, sin gamma_y, z) by T_x, T_y, F_z in the end, shape
            (3, 3).
        relaxation: the time constant with which it gives way (s).
    """

    matrix: np.ndarray
    relaxation: float

    def within(self, time: float) -> np.ndarray:
        """Return C as a wrench meets it that changes with a time constant (s): C / (1 + T/time)."""
        return self.matrix * (time / (time + self.relaxation))


def command_gradient(gradient: np.ndarray, compliance: np.ndarray) -> np.ndarray:
    """Return the gradient of a foot's wrench by its command: contact and servos in series.

    The foot is where the command has it, moved by its wrench: x = w + C lambda. With
    lambda = U x that is lambda = (U^-1 - C)^-1 w; U is negative, so both compliances add up.

    Args:
        gradient: U of the contact, shape (3, 3).
        compliance: C of the servos, shape (3, 3).
    """
    return np.linalg.inv(np.linalg.inv(gradient) - compliance)
