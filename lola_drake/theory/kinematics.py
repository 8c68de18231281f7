"""Kinematics of the robot as seen from its torso: the feet relative to the CoM, and their rates.

The torso is taken as upright and at rest, so positions are those of the torso frame T. The tree of
joints is plain data (`robot.kinematic_tree` takes it out of the model), and the functions here are
laws: pure, and fit for machine code.
"""

from math import atan2
from math import cos as cosine
from math import sin as sine
from typing import NamedTuple

import numpy as np

FOOT_TASK = 6
"""Size of one foot's task: x, y, z, sin gamma_x, sin gamma_y, gamma_z."""


class KinematicTree(NamedTuple):
    """Revolute joints that move bodies; body 0 is the torso, joint k moves body k + 1.

    In the zero pose the axes of all bodies are those of T.

    Attributes:
        order: the joints, each after that of its parent body, shape (n,).
        parent: the body that carries the joint, shape (n,).
        offset: the joint's origin relative to its parent's, in the zero pose (m), shape (n, 3).
        axis: its axis in the zero pose, shape (n, 3).
        mass: of the bodies (kg), shape (n + 1,).
        moment: mass times CoM relative to the body's origin, in the zero pose (kg m), (n + 1, 3).
        tcp_body: the body that carries each foot's TCP, shape (2,).
        p_BTcp: the TCP in that body (m), shape (2, 3).
        R_BTcp: its orientation there, shape (2, 3, 3).
        moves: whether a joint moves a body, 0 or 1, shape (n, n + 1).
        pad_body: the bodies that carry the pads of each foot, shape (2, 4).
        p_BPad: the pads' centres there (m), shape (2, 4, 3).
    """

    order: np.ndarray
    parent: np.ndarray
    offset: np.ndarray
    axis: np.ndarray
    mass: np.ndarray
    moment: np.ndarray
    tcp_body: np.ndarray
    p_BTcp: np.ndarray
    R_BTcp: np.ndarray
    moves: np.ndarray
    pad_body: np.ndarray
    p_BPad: np.ndarray


def body_poses(q, tree):
    """Return where all bodies are at the joint angles q (rad).

    Returns:
        Orientations in T, shape (n + 1, 3, 3), origins (m), shape (n + 1, 3), and the joints' axes
        in T, shape (n, 3).
    """
    n = len(tree.order)
    R, p, axes = np.zeros((n + 1, 3, 3)), np.zeros((n + 1, 3)), np.zeros((n, 3))
    for i in range(3):
        R[0, i, i] = 1.0
    for k in tree.order:
        b, carrier = k + 1, tree.parent[k]
        x, y, z = tree.axis[k][0], tree.axis[k][1], tree.axis[k][2]
        d_x, d_y, d_z = tree.offset[k][0], tree.offset[k][1], tree.offset[k][2]
        s, c = sine(q[k]), cosine(q[k])
        v = 1 - c
        for i in range(3):
            r_x, r_y, r_z = R[carrier, i, 0], R[carrier, i, 1], R[carrier, i, 2]
            along = r_x * x + r_y * y + r_z * z
            axes[k, i] = along
            p[b, i] = p[carrier, i] + r_x * d_x + r_y * d_y + r_z * d_z
            R[b, i, 0] = c * r_x + v * along * x + s * (r_y * z - r_z * y)
            R[b, i, 1] = c * r_y + v * along * y + s * (r_z * x - r_x * z)
            R[b, i, 2] = c * r_z + v * along * z + s * (r_x * y - r_y * x)
    return R, p, axes


def turned(R, body, point, i):
    """Return entry i of a vector of a body, turned into T."""
    return R[body, i, 0] * point[0] + R[body, i, 1] * point[1] + R[body, i, 2] * point[2]


def com_motion(R, p, axes, tree):
    """Return the CoM (m), shape (3,), and its rates per joint rate, shape (3, n)."""
    n = len(tree.order)
    mass, moment = np.zeros(n + 1), np.zeros((n + 1, 3))
    for b in range(n + 1):
        mass[b] = tree.mass[b]
        for i in range(3):
            moment[b, i] = mass[b] * p[b, i] + turned(R, b, tree.moment[b], i)
    # From the tips to the torso: what hangs on a joint moves with it.
    for j in range(n - 1, -1, -1):
        k = tree.order[j]
        mass[tree.parent[k]] += mass[k + 1]
        for i in range(3):
            moment[tree.parent[k], i] += moment[k + 1, i]
    com, rates = np.zeros(3), np.zeros((3, n))
    for i in range(3):
        com[i] = moment[0, i] / mass[0]
    for k in range(n):
        part = mass[k + 1]
        x, y, z = (
            moment[k + 1, 0] - part * p[k + 1, 0],
            moment[k + 1, 1] - part * p[k + 1, 1],
            moment[k + 1, 2] - part * p[k + 1, 2],
        )
        rates[0, k] = (axes[k, 1] * z - axes[k, 2] * y) / mass[0]
        rates[1, k] = (axes[k, 2] * x - axes[k, 0] * z) / mass[0]
        rates[2, k] = (axes[k, 0] * y - axes[k, 1] * x) / mass[0]
    return com, rates


def feet_motion(R, p, axes, com, com_rates, tree):
    """Return the task of both feet, shape (12,), and its Jacobian per joint rate, shape (12, n).

    A foot's task is its TCP relative to the CoM in T, sin gamma_x, sin gamma_y (independent
    rotations about T's axes) and gamma_z.
    """
    n = len(tree.order)
    w, jacobian = np.zeros(2 * FOOT_TASK), np.zeros((2 * FOOT_TASK, n))
    tcp, tilt = np.zeros(3), np.zeros((3, 2))
    for foot in range(2):
        first, body = FOOT_TASK * foot, tree.tcp_body[foot]
        for i in range(3):
            tcp[i] = p[body, i] + turned(R, body, tree.p_BTcp[foot], i)
            w[first + i] = tcp[i] - com[i]
            for j in range(2):
                tilt[i, j] = (
                    R[body, i, 0] * tree.R_BTcp[foot][0][j]
                    + R[body, i, 1] * tree.R_BTcp[foot][1][j]
                    + R[body, i, 2] * tree.R_BTcp[foot][2][j]
                )
        r00, r10, r20, r01, r11 = tilt[0, 0], tilt[1, 0], tilt[2, 0], tilt[0, 1], tilt[1, 1]
        w[first + 3], w[first + 4], w[first + 5] = tilt[2, 1], -r20, atan2(r10, r00)
        lean = r20 / (r00 * r00 + r10 * r10)
        for k in range(n):
            for i in range(3):
                jacobian[first + i, k] = -com_rates[i, k]
            if tree.moves[k][body]:
                x, y, z = tcp[0] - p[k + 1, 0], tcp[1] - p[k + 1, 1], tcp[2] - p[k + 1, 2]
                a_x, a_y, a_z = axes[k, 0], axes[k, 1], axes[k, 2]
                jacobian[first, k] += a_y * z - a_z * y
                jacobian[first + 1, k] += a_z * x - a_x * z
                jacobian[first + 2, k] += a_x * y - a_y * x
                jacobian[first + 3, k] = r11 * a_x - r01 * a_y
                jacobian[first + 4, k] = r00 * a_y - r10 * a_x
                jacobian[first + 5, k] = a_z - lean * (r00 * a_x + r10 * a_y)
    return w, jacobian


def pads_motion(foot, R, p, axes, com, com_rates, tree):
    """Return where the pads' centres of one foot are, and how their heights move.

    Returns:
        x and y relative to the CoM in T (m), shape (4, 2), in the order of `PADS`; and the rates
        of their heights over the CoM per joint rate, shape (4, n).
    """
    n = len(tree.order)
    points, rates = np.zeros((4, 2)), np.zeros((4, n))
    for pad in range(4):
        body = tree.pad_body[foot][pad]
        x = p[body, 0] + turned(R, body, tree.p_BPad[foot][pad], 0)
        y = p[body, 1] + turned(R, body, tree.p_BPad[foot][pad], 1)
        points[pad, 0], points[pad, 1] = x - com[0], y - com[1]
        for k in range(n):
            rates[pad, k] = -com_rates[2, k]
            if tree.moves[k][body]:
                rates[pad, k] += axes[k, 0] * (y - p[k + 1, 1]) - axes[k, 1] * (x - p[k + 1, 0])
    return points, rates


def foot_task(q, tree):
    """Return the task of both feet at the joint angles q (rad), and its Jacobian.

    Returns:
        w, shape (12,), and its rates per joint rate, shape (12, n).
    """
    R, p, axes = body_poses(q, tree)
    com, com_rates = com_motion(R, p, axes, tree)
    return feet_motion(R, p, axes, com, com_rates, tree)
