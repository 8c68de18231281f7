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
    tcps, yaws = np.array(p_PTcp), np.array(yaw)
    ankles, feet = tcps + _turn(yaws, legs.p_TcpAnkle), tcps + _turn(yaws, legs.p_TcpFoot)
    bodies, links = _posture(legs, com, heading, ankles, feet)
    inertias = np.repeat([legs.thigh_inertia, legs.shank_inertia], 2)
    velocity = np.gradient(bodies, step, axis=1) - np.gradient(com, step, axis=0)
    orbital = np.cross(bodies - com, velocity)
    spin = np.cross(links, np.gradient(links, step, axis=1))
    return np.tensordot(_masses(legs), orbital, 1) + np.tensordot(inertias, spin, 1)


def _masses(legs: LegModel) -> np.ndarray:
    """Return the masses of the body, the thighs, the shanks and the feet (kg), shape (7,)."""
    return np.array(
        [legs.body_mass, *np.repeat([legs.thigh_mass, legs.shank_mass, legs.foot_mass], 2)]
    )


def _posture(
    legs: LegModel, com: np.ndarray, heading: np.ndarray, ankles: np.ndarray, feet: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the posture in which the given CoM, ankles and feet belong together.

    Args:
        legs: the lumped robot.
        com: CoM (m), shape (n, 3).
        heading: the torso's yaw (rad), shape (n,).
        ankles: of the left and right leg (m), shape (2, n, 3).
        feet: CoM of the left and right foot (m), shape (2, n, 3).

    Returns:
        Where the masses are (m), in the order of `_masses`, shape (7, n, 3), and the directions of
        the thighs and shanks, shape (4, n, 3).
    """
    masses, forward = _masses(legs), _turn(heading, np.array([1.0, 0.0, 0.0]))
    body = _turn(heading, legs.p_TBody)
    hip_left, hip_right = (_turn(heading, legs.p_THip * [1, side, 1]) for side in (1, -1))
    torso = com - body
    # The torso's place follows from the CoM, which depends on the legs: a quick contraction.
    for _ in range(4):
        hips = torso + np.array([hip_left, hip_right])
        knees = _knees(legs, hips, ankles, forward)
        thighs, shanks = (knees - hips) / legs.thigh_length, (ankles - knees) / legs.shank_length
        bodies = np.concatenate(
            [
                [torso + body],
                hips + legs.thigh_com * thighs,
                knees + legs.shank_com * shanks,
                feet,
            ]
        )
        torso = torso + com - np.tensordot(masses, bodies, 1) / legs.mass
    return bodies, np.concatenate([thighs, shanks])


def _knees(legs: LegModel, hips: np.ndarray, ankles: np.ndarray, forward: np.ndarray) -> np.ndarray:
    """Return the knees of two-link legs that bend forward; an over-stretched leg is straight."""
    line = ankles - hips
    distance = np.sqrt(_dot(line, line))
    along = line / distance
    normal = forward - _dot(forward, along) * along
    normal /= np.sqrt(_dot(normal, normal))
    upper = (distance**2 + legs.thigh_length**2 - legs.shank_length**2) / (2 * distance)
    bend = np.sqrt(np.maximum(legs.thigh_length**2 - upper**2, 0.0))
    return hips + upper * along + bend * normal


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the scalar products of vectors, shape (..., 1)."""
    return np.einsum("...i,...i->...", a, b)[..., None]


def _turn(yaw: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the vector p turned by each yaw about z, shape (..., 3)."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * p[0] - s * p[1], s * p[0] + c * p[1], np.full_like(c, p[2])], axis=-1)
