"""What the sensed contact of a foot says of its wrench: the paper's outlook (section VI), built.

The contact model of one foot (eq. 2-8) with the pads that touch alone, and without small angles.
With C = diag(cos alpha_x, cos alpha_y, 1) and U of eq. 8, eq. 6 is lambda = C U x, and so

    lambda' = C (U - diag(T_x sin alpha_x / cos^3 alpha_x, T_y sin alpha_y / cos^3 alpha_y, 0)) x'

C^-1 lambda is what does work on x = (sin alpha_x, sin alpha_y, z): for it the gradient stays
symmetric, and so it does with the servos in series. Where pads are open the gradient is singular:
in directions that lose their stiffness something else moves the foot (`safe_motion()`).

That U varies with the sensed area, and is made singular-safe, is the idea of Sygulla and Rixen
(2020); equations and thresholds here are our own. All functions are for machine code.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lola_drake.theory.contact_model import Pad, contact_matrix
from lola_drake.theory.scalars import cos, sin

RAMP = 0.02
"""How long a pad takes to count wholly once it has closed (s)."""

LOST, KEPT = 0.05, 0.25
"""Parts of the least stiffness of a whole foot: above the second one a direction is controlled by
the force that it has, below the first not at all."""

SWEEPS = 8
"""Of Jacobi's method; a matrix of size 3 needs five to the last bit."""


class PadModel(NamedTuple):
    """The pads of a foot, as laws take them.

    Attributes:
        matrices: U of each pad alone (eq. 8), shape (k, 3, 3).
        radius: of gyration of the whole sole; by it angles are made lengths (m).
        stiffness: the least one of a whole foot, over all directions (N/m).
    """

    matrices: np.ndarray
    radius: float
    stiffness: float


def pad_model(pads: Sequence[Pad], area_stiffness: float) -> PadModel:
    """Return the pads as laws take them, on ground of this c_A,z (N/m^3)."""
    whole = contact_matrix(pads, area_stiffness)
    radius = float(np.sqrt(0.5 * (whole[0, 0] + whole[1, 1]) / whole[2, 2]))
    scale = np.array([1 / radius, 1 / radius, 1.0])
    return PadModel(
        matrices=np.array([contact_matrix([pad], area_stiffness) for pad in pads]),
        radius=radius,
        stiffness=float(np.linalg.eigvalsh(-whole * np.outer(scale, scale)).min()),
    )


def foot_axes(s_x, s_y, yaw):
    """Return the x and y axes of the foot in T, two of three entries each: exactly R_TF's columns.

    Args:
        s_x: sin gamma_x, the height of the y axis.
        s_y: sin gamma_y, less the height of the x axis.
        yaw: gamma_z, the heading of the x axis (rad).
    """
    c, s = cos(yaw), sin(yaw)
    along = np.sqrt(max(1 - s_y * s_y, 1e-6))
    lean = s_x * s_y / along
    across = np.sqrt(max(1 - s_x * s_x - lean * lean, 1e-6))
    x_axis = (along * c, along * s, -s_y)
    y_axis = (lean * c - across * s, lean * s + across * c, s_x)
    return x_axis, y_axis


def inclined(axes, phi):
    """Return sin alpha_x and sin alpha_y: the foot's inclination in I, the torso's included.

    Args:
        axes: of the foot in T, see `foot_axes`.
        phi: inclination of the torso (rad), shape (2,).
    """
    up = (-sin(phi[1]), sin(phi[0]) * cos(phi[1]), cos(phi[0]) * cos(phi[1]))
    x_axis, y_axis = axes
    s_x = up[0] * y_axis[0] + up[1] * y_axis[1] + up[2] * y_axis[2]
    s_y = up[0] * x_axis[0] + up[1] * x_axis[1] + up[2] * x_axis[2]
    return s_x, -s_y


def turned(wrench, yaw):
    """Return T_x, T_y, F_z of T about the axes of a foot that is turned by a yaw (rad)."""
    c, s = cos(yaw), sin(yaw)
    return c * wrench[0] + s * wrench[1], c * wrench[1] - s * wrench[0], wrench[2]


def sensed_gradient(share, pads, tilt, wrench):
    """Return the gradient of C^-1 lambda by x for the pads in contact, shape (3, 3).

    Args:
        share: how far each pad counts, 0 to 1, shape (k,).
        pads: the `PadModel`.
        tilt: sin alpha_x and sin alpha_y.
        wrench: T_x, T_y, F_z about the foot's axes.
    """
    gradient = np.zeros((3, 3))
    for pad in range(len(share)):
        for i in range(3):
            for j in range(3):
                gradient[i, j] += share[pad] * pads.matrices[pad][i][j]
    for i in range(2):
        square = max(1 - tilt[i] * tilt[i], 1e-6)
        gradient[i, i] -= wrench[i] * tilt[i] / (square * np.sqrt(square))
    return gradient


def behind_servos(gradient, compliance):
    """Return a contact's gradient by the foot's command: (E - G C)^-1 G, which may be singular.

    Args:
        gradient: G of the contact, shape (3, 3).
        compliance: C of the servos, as what changes as quickly as the controller meets it.
    """
    loop, series = np.zeros((3, 3)), np.zeros((3, 3))
    for i in range(3):
        loop[i, i] = 1.0
        for j in range(3):
            for k in range(3):
                loop[i, j] -= gradient[i][k] * compliance[k][j]
    (a, b, c), (d, e, f), (g, h, i) = loop[0], loop[1], loop[2]
    first, second, third = e * i - f * h, f * g - d * i, d * h - e * g
    determinant = a * first + b * second + c * third
    for k in range(3):
        p, q, r = gradient[0][k], gradient[1][k], gradient[2][k]
        series[0, k] = p * first + b * (f * r - q * i) + c * (q * h - e * r)
        series[1, k] = a * (q * i - f * r) + p * second + c * (d * r - q * g)
        series[2, k] = a * (e * r - q * h) + b * (q * g - d * r) + p * third
    return series / determinant


def symmetric_eigen(matrix):
    """Return eigenvalues, shape (3,), and eigenvectors as columns, shape (3, 3) (Jacobi)."""
    a, v = np.zeros((3, 3)), np.eye(3)
    for i in range(3):
        for j in range(3):
            a[i, j] = 0.5 * (matrix[i][j] + matrix[j][i])
    for _ in range(SWEEPS):
        for p in range(2):
            for q in range(p + 1, 3):
                if abs(a[p, q]) <= 1e-18 * (abs(a[p, p]) + abs(a[q, q])):
                    continue
                theta = (a[q, q] - a[p, p]) / (2 * a[p, q])
                t = 1 / (abs(theta) + np.sqrt(theta * theta + 1))
                t = t if theta >= 0 else -t
                c = 1 / np.sqrt(t * t + 1)
                s = t * c
                for k in range(3):
                    a[k, p], a[k, q] = c * a[k, p] - s * a[k, q], s * a[k, p] + c * a[k, q]
                for k in range(3):
                    a[p, k], a[q, k] = c * a[p, k] - s * a[q, k], s * a[p, k] + c * a[q, k]
                    v[k, p], v[k, q] = c * v[k, p] - s * v[k, q], s * v[k, p] + c * v[k, q]
    return np.array([a[0, 0], a[1, 1], a[2, 2]]), v


def kept(stiffness):
    """Return how far a direction is force-controlled, by its part of a whole foot's stiffness."""
    t = min(max((stiffness - LOST) / (KEPT - LOST), 0.0), 1.0)
    return t * t * (3 - 2 * t)


def safe_motion(gradient, wrench_rate, free_rate, pads):
    """Return the foot's rates by a gradient that may be singular, shape (3,).

    With -D U D = V S V^T, where D makes lengths of angles, a direction of stiffness s is
    force-controlled to the part b = `kept(s)`, and free else:

        w' = -D V (b / S) V^T D lambda' + D V (1 - b) V^T D^-1 w'_free

    Args:
        gradient: U, symmetric, shape (3, 3).
        wrench_rate: what the contact is to do.
        free_rate: what the foot is to do where it has no contact.
        pads: the `PadModel`.
    """
    d = (1 / pads.radius, 1 / pads.radius, 1.0)
    scaled = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            scaled[i, j] = -d[i] * gradient[i][j] * d[j]
    stiffness, v = symmetric_eigen(scaled)
    rate = np.zeros(3)
    for k in range(3):
        degree = kept(stiffness[k] / pads.stiffness)
        push = free = 0.0
        for i in range(3):
            push += v[i, k] * d[i] * wrench_rate[i]
            free += v[i, k] / d[i] * free_rate[i]
        force = degree / stiffness[k] * push if degree > 0 else 0.0
        for i in range(3):
            rate[i] += d[i] * v[i, k] * ((1 - degree) * free - force)
    return rate
