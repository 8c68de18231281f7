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
