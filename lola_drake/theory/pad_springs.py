"""Contact as decoupled springs at the pads' centres, behind servos that give way ([23])."""

import numpy as np


def spring_gradient(points, height_rates, stiffness):
    """Return the gradient of T_x, T_y, F_z of decoupled springs under a foot.

    A spring gives dF = -c dz at its point, and with it dT_x = y dF and dT_y = -x dF; what the
    points' motion in the plane does to the torques is left out.

    Args:
        points: x and y of the springs relative to the TCP (m), shape (k, 2).
        height_rates: their heights by whatever moves them, shape (k, n).
        stiffness: c of each spring (N/m), shape (k,).

    Returns:
        The gradient by whatever moves the springs, shape (3, n).
    """
    n = len(height_rates[0])
    gradient = np.zeros((3, n))
    for spring in range(len(stiffness)):
        x, y = points[spring][0], points[spring][1]
        for k in range(n):
            force = -stiffness[spring] * height_rates[spring][k]
            gradient[0, k] += y * force
            gradient[1, k] -= x * force
            gradient[2, k] += force
    return gradient


def solved(matrix, right):
    """Return x of a linear equation matrix x = right, both of size 3, by Cramer's rule."""
    (a, b, c), (d, e, f), (g, h, i) = matrix[0], matrix[1], matrix[2]
    p, q, r = right[0], right[1], right[2]
    first, second, third = e * i - f * h, f * g - d * i, d * h - e * g
    determinant = a * first + b * second + c * third
    return (
        (p * first + b * (f * r - q * i) + c * (q * h - e * r)) / determinant,
        (a * (q * i - f * r) + p * second + c * (d * r - q * g)) / determinant,
        (a * (e * r - q * h) + b * (q * g - d * r) + p * third) / determinant,
    )


def opened_by_servos(force_by_task, compliance, met):
    """Return E - U C, by which servos that give way behind a contact lessen its gradients.

    Args:
        force_by_task: U of the contact, d lambda / d w, shape (3, 3).
        compliance: C, the motion of the foot by its wrench, shape (3, 3).
        met: the part of C that a wrench meets which changes within delta.
    """
    loop = np.zeros((3, 3))
    for i in range(3):
        loop[i, i] = 1.0
        for j in range(3):
            for k in range(3):
                loop[i, j] -= force_by_task[i, k] * met * compliance[k][j]
    return loop


def behind_servos(loop, gradient):
    """Return (E - U C)^-1 times a gradient of a contact, shape (3, n); see `command_gradient`."""
    n = len(gradient[0])
    series = np.zeros((3, n))
    for k in range(n):
        a, b, c = solved(loop, (gradient[0, k], gradient[1, k], gradient[2, k]))
        series[0, k], series[1, k], series[2, k] = a, b, c
    return series
