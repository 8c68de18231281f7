"""Step adaptation: where the swing foot has to come down after a push.

The divergent component of motion xi = c + c'/omega leaves its plan by e, and goes on to

    e(T) = d + (e - d) exp(omega (T - t)),

d being how far the pressure in the stance foot gets from where it is planned (the capture point of
Pratt et al. 2006; Englsberger et al. 2011). In the double support that follows, the ZMP goes from
the foot that stayed to the one that was moved: of a move Delta p only the part

    kappa = (1 - exp(-omega T_d)) / (omega T_d)

is ahead of the planned motion, so that Delta p = e(T) / kappa.

The horizontal task stays at its plan and the stance foot does not slip, so that the CoM leaves its
plan by the torso's inclination alone: c - c_plan = h (phi_y, -phi_x). The feet lean with the torso:
one that is ahead of a robot that falls forward is too low by phi_y times its distance. These laws,
and all numbers here, are our own choice.
"""

import numpy as np

from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import GREATEST, LEFT, SIDEWAYS, SOLE, advance, room_needed

MOST = 0.7
"""Greatest move of a foothold (m); the legs' reach is mostly less."""

DEAD = 0.02
"""What stays to the stance foot (m): a foothold moves by what is beyond."""

DECIDED = 0.7
"""Part of the swing after which the foothold stays where it is."""

LEAST_TIME = 0.02
"""In which a foot goes on to its foothold, at least (s)."""

PRESSURE = np.array([0.1, 0.08])
"""How far from the TCP the pressure in a foot gets, forward or back, and to the sides (m)."""

EDGE = 0.1
"""How far ahead of and behind the TCP the foot's edge is, over which the robot tips (m)."""

UPRIGHT = np.deg2rad(1.0)
"""Inclination up to which the feet's heights stay as planned (rad)."""

LEVELLING = 0.03
"""Time constant with which the swing foot follows the inclination (s)."""

FADING = 0.3
"""Time constant with which a foot that has landed gives back the height (s)."""


def capture_shift(
    phi: np.ndarray,
    phi_dot: np.ndarray,
    zmp: np.ndarray,
    height: float,
    time_left: float,
    support: float,
) -> np.ndarray:
    """Return Delta p in T (m), shape (2,).

    Args:
        phi: inclination of the torso (rad), shape (2,).
        phi_dot: its rate (rad/s).
        zmp: where it is planned, against the stance foot's TCP in T (m), shape (2,).
        height: of the CoM above the stance foot (m).
        time_left: until the planned touchdown (s).
        support: duration of the double support after it (s).
    """
    omega = np.sqrt(GRAVITY / height)
    lean_x, lean_y = phi + phi_dot / omega
    deviation = height * np.array([lean_y, -lean_x])
    way = np.sign(deviation)
    held = PRESSURE - way * zmp
    growth = np.exp(omega * time_left)
    landing = np.maximum(held + (np.abs(deviation) - held) * growth, 0.0)
    shift = way * landing / part_ahead(height, support)
    size = float(np.linalg.norm(shift))
    return shift * (min(max(size - DEAD, 0.0), MOST) / size if size > 0 else 0.0)


def part_ahead(height: float, support: float) -> float:
    """Return kappa, the part of a foothold's move that is ahead of the planned motion.

    Args:
        height: of the CoM above the stance foot (m).
        support: duration of the double support after the touchdown (s).
    """
    time = np.sqrt(GRAVITY / height) * support
    return float((1 - np.exp(-time)) / time)


def too_low(phi: np.ndarray, place: np.ndarray) -> float:
    """Return by how much a foot of a leaning robot is lower than planned (m).

    Args:
        phi: inclination of the torso (rad), shape (2,).
        place: of the foot against the one that stands, in T (m), shape (2,).
    """
    lean_x, lean_y = np.sign(phi) * np.maximum(np.abs(phi) - UPRIGHT, 0.0)
    return float(lean_y * place[0] - lean_x * place[1] - abs(lean_y) * EDGE)


def allowed_shift(
    shift: np.ndarray, place: np.ndarray, foot: int, standing: np.ndarray
) -> np.ndarray:
    """Return the part of a shift that legs and the other foot allow (m), shape (2,).

    Args:
        shift: wanted, shape (2,).
        place: the planned foothold x, y, yaw.
        foot: that comes down there.
        standing: x, y, yaw of the other one.
    """
    yaw, side = standing[2], 1.0 if foot == LEFT else -1.0
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, s], [-s, c]])
    planned = turn @ (place[:2] - standing[:2])
    wanted = planned + turn @ shift
    # A plan that is at the edge itself stays as it is; feet do not cross.
    longest = max(GREATEST[0], abs(planned[0]))
    widest = max(SOLE[1] + GREATEST[SIDEWAYS], side * planned[1])
    wanted[0] = min(max(wanted[0], -longest), longest)
    narrowest = min(SOLE[1], side * planned[1])
    wanted[1] = side * min(max(side * wanted[1], narrowest), widest)
    moved = np.append(standing[:2] + turn.T @ wanted, place[2])
    room = room_needed(moved, foot, standing)
    return advance(moved, np.array([0.0, side * room, 0.0]))[:2] - place[:2]


def approach(
    shift: np.ndarray, rate: np.ndarray, target: np.ndarray, time_left: float
) -> np.ndarray:
    """Return with which acceleration a foot comes to rest at a target, in time (m/s^2), shape (2,).

    It is that of the cubic from here to there.
    """
    time = max(time_left, LEAST_TIME)
    return 6 * (target - shift) / time**2 - 4 * rate / time
