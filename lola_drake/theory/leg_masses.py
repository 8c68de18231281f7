"""Angular momentum of the swinging legs: the pattern generator's model of the whole robot.

The pendulum alone knows one point mass. LOLA's pattern generator uses three (body and two feet);
with heavy thighs five describe the robot better, so here the body, both thighs and both shanks
with the feet move as a two-link leg between hip and ankle demands. The torso stays upright and
turns with the heading; what the model gives is the CoM's angular momentum and, from its rate, the
shift of the ZMP against the plain pendulum.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LegModel:
    """Lumped masses and lengths of the robot; computed from the full model by `robot.py`.

    Attributes:
        body_mass: everything above the hip-flexion joints (kg).
        p_TBody: its CoM in the torso frame (m), shape (3,).
        p_THip: the left hip's centre in the torso frame (m), shape (3,); mirrored for the right.
        thigh_mass, shank_mass, foot_mass: per leg (kg).
        thigh_length, shank_length: hip to knee, knee to ankle (m).
        thigh_com, shank_com: distance of the CoM below the upper joint (m).
        thigh_inertia, shank_inertia: transverse inertia about the own CoM (kg m^2).
        p_TcpAnkle: ankle relative to the TCP, in the foot frame (m), shape (3,).
        p_TcpFoot: the foot's CoM relative to the TCP, in the foot frame (m), shape (3,).
    """

    body_mass: float
    p_TBody: np.ndarray
    p_THip: np.ndarray
    thigh_mass: float
    shank_mass: float
    foot_mass: float
    thigh_length: float
    shank_length: float
    thigh_com: float
    shank_com: float
    thigh_inertia: float
    shank_inertia: float
    p_TcpAnkle: np.ndarray
    p_TcpFoot: np.ndarray

    @property
    def mass(self) -> float:
        """Return the robot's total mass (kg)."""
        return self.body_mass + 2 * (self.thigh_mass + self.shank_mass + self.foot_mass)


def angular_momentum(
    legs: LegModel,
    step: float,
    com: np.ndarray,
    heading: np.ndarray,
    p_PTcp: tuple[np.ndarray, np.ndarray],
    yaw: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Return the angular momentum about the CoM along a motion.

    Args:
        legs: the lumped robot.
        step: distance of the samples (s).
        com: CoM (m), shape (n, 3).
        heading: the torso's yaw (rad), shape (n,).
        p_PTcp: TCP of the left and right foot (m), each of shape (n, 3).
        yaw: yaw of the left and right foot (rad), each of shape (n,).

    Returns:
        Angular momentum (Nms), shape (n, 3).
    """
    ankles = [p + _turn(a, legs.p_TcpAnkle) for p, a in zip(p_PTcp, yaw, strict=True)]
    feet = [p + _turn(a, legs.p_TcpFoot) for p, a in zip(p_PTcp, yaw, strict=True)]
    masses, bodies, links = _posture(legs, com, heading, ankles, feet)
    momentum = np.zeros_like(com)
    v_com = np.gradient(com, step, axis=0)
    for mass, p in zip(masses, bodies, strict=True):
        momentum += mass * np.cross(p - com, np.gradient(p, step, axis=0) - v_com)
    for inertia, direction in links:
        momentum += inertia * np.cross(direction, np.gradient(direction, step, axis=0))
    return momentum


def _posture(legs, com, heading, ankles, feet):
    """Return masses, their positions, and the links' inertias with their directions."""
    hips_T = (legs.p_THip, legs.p_THip * [1, -1, 1])
    forward = _turn(heading, np.array([1.0, 0.0, 0.0]))
    torso = com - _turn(heading, legs.p_TBody)
    masses = [legs.body_mass, *2 * [legs.thigh_mass, legs.shank_mass, legs.foot_mass]]
    # The torso's place follows from the CoM, which depends on the legs: a quick contraction.
    for _ in range(4):
        bodies, links = [torso + _turn(heading, legs.p_TBody)], []
        for p_THip, ankle, foot in zip(hips_T, ankles, feet, strict=True):
            hip = torso + _turn(heading, p_THip)
            knee = _knee(legs, hip, ankle, forward)
            thigh, shank = (knee - hip) / legs.thigh_length, (ankle - knee) / legs.shank_length
            bodies += [hip + legs.thigh_com * thigh, knee + legs.shank_com * shank, foot]
            links += [(legs.thigh_inertia, thigh), (legs.shank_inertia, shank)]
        error = com - sum(m * p for m, p in zip(masses, bodies, strict=True)) / legs.mass
        torso = torso + error
    return masses, bodies, links


def _knee(legs: LegModel, hip: np.ndarray, ankle: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Return the knee of a two-link leg that bends forward; an over-stretched leg is straight."""
    line = ankle - hip
    distance = np.sqrt(np.einsum("ij,ij->i", line, line))[:, None]
    along = line / distance
    normal = forward - np.einsum("ij,ij->i", forward, along)[:, None] * along
    normal /= np.sqrt(np.einsum("ij,ij->i", normal, normal))[:, None]
    upper = (distance**2 + legs.thigh_length**2 - legs.shank_length**2) / (2 * distance)
    bend = np.sqrt(np.maximum(legs.thigh_length**2 - upper**2, 0.0))
    return hip + upper * along + bend * normal


def _turn(yaw: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the vector p turned by each yaw about z, shape (n, 3)."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack([c * p[0] - s * p[1], s * p[0] + c * p[1], np.full_like(c, p[2])])
