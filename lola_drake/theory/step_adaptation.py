"""Step adaptation: where the swing foot has to come down after a push.

The divergent component of motion xi = c + c'/omega leaves its plan as exp(omega t); a foothold that
is moved by Delta p = (xi - xi_plan) exp(omega (T - t)) stands under it at the touchdown T as the
planned one would have (the capture point of Pratt et al. 2006; Englsberger et al. 2011).

The horizontal task stays at its plan and the stance foot does not slip, so that the CoM leaves its
plan by the torso's inclination alone: c - c_plan = h (phi_y, -phi_x). That, and all numbers here,
are our own choice.
"""

import numpy as np

from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import GREATEST, LEFT, SIDEWAYS, SOLE, advance, room_needed

MOST = 0.1
"""Greatest move of a foothold (m)."""

DEAD = 0.02
"""What the stance foot's pressure takes back by itself (m): a foothold moves by what is beyond."""

DECIDED = 0.7
"""Part of the swing after which the foothold stays where it is."""

LEAST_TIME = 0.02
"""In which a foot goes on to its foothold, at least (s)."""


def capture_shift(
    phi: np.ndarray, phi_dot: np.ndarray, height: float, time_left: float
) -> np.ndarray:
    """Return Delta p in T (m), shape (2,).

    Args:
        phi: inclination of the torso (rad), shape (2,).
        phi_dot: its rate (rad/s).
        height: of the CoM above the stance foot (m).
        time_left: until the planned touchdown (s).
    """
    omega = np.sqrt(GRAVITY / height)
    lean_x, lean_y = phi + phi_dot / omega
    deviation = height * np.array([lean_y, -lean_x])
    shift = deviation * np.exp(omega * time_left)
    size = float(np.linalg.norm(shift))
    return shift * (min(max(size - DEAD, 0.0), MOST) / size if size > 0 else 0.0)


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
    # A plan that is at the edge itself stays as it is.
    longest = max(GREATEST[0], abs(planned[0]))
    widest = max(SOLE[1] + GREATEST[SIDEWAYS], side * planned[1])
    wanted[0] = min(max(wanted[0], -longest), longest)
    wanted[1] = side * min(side * wanted[1], widest)
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
