"""The CoM trajectory that belongs to a given ZMP: cubic-spline collocation of the pendulum.

The horizontal CoM obeys c'' = stiffness(t) (c - p(t)), with the pendulum's stiffness
(g + z'')/z and p the ZMP already corrected for the robot's angular momentum. The CoM is a cubic
spline on equidistant knots that fulfils this equation in every knot. Collocation on splines is
the method of the LOLA group's pattern generator (Buschmann et al. 2007; Seiwald and Rixen 2020);
the boundary conditions and the choice of the free ZMP parameter are our own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded


@dataclass(frozen=True)
class KnotSpline:
    """A C2 cubic spline: position, velocity and acceleration in equidistant knots.

    Attributes:
        step: distance of the knots (s).
        position, velocity, acceleration: shape (n, d).
    """

    step: float
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    def __call__(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration, shape (len(time), d)."""
        k = np.clip((time / self.step).astype(int), 0, len(self.position) - 2)
        s = (time - k * self.step)[:, None]
        a = self.acceleration[k]
        jerk = (self.acceleration[k + 1] - a) / self.step
        velocity = self.velocity[k] + s * (a + s * jerk / 2)
        position = self.position[k] + s * (self.velocity[k] + s * (a / 2 + s * jerk / 6))
        return position, velocity, a + s * jerk


def solve_com(
    step: float,
    stiffness: np.ndarray,
    zmp: np.ndarray,
    shape: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
) -> tuple[KnotSpline, np.ndarray]:
    """Solve the pendulum's boundary-value problem for all horizontal axes at once.

    The initial position and velocity are given, and at the end only the stable motion
    c' = -sqrt(stiffness) (c - p) is allowed: one condition too many for a second-order
    equation. The ZMP therefore gets one free parameter per axis, the amplitude of `shape`.

    Args:
        step: distance of the knots (s).
        stiffness: (g + z'')/z in the knots (1/s^2), shape (n,).
        zmp: wanted ZMP in the knots (m), shape (n, d).
        shape: the form of the ZMP's correction in the knots, shape (n,).
        position: initial position (m), shape (d,).
        velocity: initial velocity (m/s), shape (d,).

    Returns:
        The CoM spline, and the amplitude of the ZMP's correction (m), shape (d,).
    """
    axes = zmp.shape[1]
    rate = np.sqrt(stiffness[-1])
    w = step**2 * stiffness / 6
    bands = np.zeros((3, len(stiffness)))
    bands[1, 0] = 1.0
    bands[1, 1:-1] = -2 - 4 * w[1:-1]
    bands[0, 2:] = 1 - w[2:]
    bands[2, :-2] = 1 - w[:-2]
    # Last row: end velocity of the spline equals -rate (c - p).
    bands[2, -2] = -1 + w[-2]
    bands[1, -1] = 1 + 2 * w[-1] + rate * step
    forcing = np.column_stack([zmp, shape])
    wp = w[:, None] * forcing
    right = np.empty_like(forcing)
    right[0, :axes], right[0, axes] = position, 0.0
    right[1:-1] = -(wp[:-2] + 4 * wp[1:-1] + wp[2:])
    right[-1] = wp[-2] + 2 * wp[-1] + rate * step * forcing[-1]
    solution = solve_banded((1, 1), bands, right)
    acceleration = stiffness[:, None] * (solution - forcing)
    start = _start_velocity(step, solution, acceleration)
    amplitude = (velocity - start[:axes]) / start[axes]
    c = solution[:, :axes] + solution[:, axes:] * amplitude
    a = acceleration[:, :axes] + acceleration[:, axes:] * amplitude
    v = np.empty_like(c)
    v[0] = velocity
    v[1:] = velocity + np.cumsum((a[:-1] + a[1:]) * (step / 2), axis=0)
    return KnotSpline(step, c, v, a), amplitude


def _start_velocity(step: float, c: np.ndarray, a: np.ndarray) -> np.ndarray:
    return (c[1] - c[0]) / step - step / 6 * (2 * a[0] + a[1])
