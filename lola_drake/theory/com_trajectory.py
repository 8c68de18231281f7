"""The CoM trajectory that belongs to a given ZMP: cubic-spline collocation of the pendulum.

The horizontal CoM obeys c'' = stiffness(t) (c - p(t)), with the pendulum's stiffness
(g + z'')/z and p the ZMP already corrected for the robot's angular momentum. The CoM is a cubic
spline on equidistant knots that fulfils this equation in every knot. Collocation on splines is
the method of the LOLA group's pattern generator (Buschmann et al. 2007; Seiwald and Rixen 2020);
the boundary conditions and the choice of the free ZMP parameter are our own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgtsv


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
        k = np.minimum((time / self.step).astype(int), len(self.position) - 2)
        s = time - k * self.step
        p, v = self.position.T.take(k, axis=1), self.velocity.T.take(k, axis=1)
        a, a_end = (self.acceleration.T.take(knots, axis=1) for knots in (k, k + 1))
        jerk = (a_end - a) / self.step
        position = p + s * (v + s * (a / 2 + s * jerk / 6))
        velocity = v + s * (a + s * jerk / 2)
        return position.T, velocity.T, (a + s * jerk).T


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
    rate = np.sqrt(stiffness[-1])
    w = step**2 * stiffness / 6
    lower, main, upper = w[:-1] - 1, 2 + 4 * w, w[1:] - 1
    main[0], upper[0] = 1.0, 0.0
    # Last row: end velocity of the spline equals -rate (c - p).
    main[-1] = 1 + 2 * w[-1] + rate * step
    forcing = np.vstack([zmp.T, shape])
    wp = w * forcing
    right = np.empty_like(forcing)
    right[:-1, 0], right[-1, 0] = position, 0.0
    right[:, 1:-1] = wp[:, :-2] + 4 * wp[:, 1:-1] + wp[:, 2:]
    right[:, -1] = wp[:, -2] + 2 * wp[:, -1] + rate * step * forcing[:, -1]
    solution = dgtsv(lower, main, upper, right.T, 1, 1, 1, 1)[3].T
    acceleration = stiffness * (solution - forcing)
    start = _start_velocity(step, solution, acceleration)
    amplitude = (velocity - start[:-1]) / start[-1]
    c = solution[:-1] + amplitude[:, None] * solution[-1]
    a = acceleration[:-1] + amplitude[:, None] * acceleration[-1]
    v = np.empty_like(c)
    v[:, 0] = 0.0
    np.cumsum((a[:, :-1] + a[:, 1:]) * (step / 2), axis=1, out=v[:, 1:])
    v += velocity[:, None]
    return KnotSpline(step, c.T, v.T, a.T), amplitude


def _start_velocity(step: float, c: np.ndarray, a: np.ndarray) -> np.ndarray:
    return (c[:, 1] - c[:, 0]) / step - step / 6 * (2 * a[:, 0] + a[:, 1])
