"""Angular momentum of the swinging legs: the pattern generator's model of the whole robot.

The pendulum alone knows one point mass. LOLA's pattern generator uses three (body and two feet);
with heavy thighs five describe the robot better, so here the body, both thighs and both shanks
with the feet move as a two-link leg between hip and ankle demands. The torso stays upright and
turns with the heading; what the model gives is the CoM's angular momentum and, from its rate, the
shift of the ZMP against the plain pendulum.
"""

from dataclasses import dataclass

import numpy as np

PASSES = 4
"""Rounds in which the torso's place and the legs' posture meet: each leaves a quarter or so."""


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


class LegMotion:
    """How the feet and the heading move, and the angular momentum that the CoM adds to it.

    Inside, arrays have one row per component, then perhaps the left and the right leg, and one
    column per sample.
    """

    def __init__(self, legs: LegModel, step: float, heading: np.ndarray, feet: np.ndarray):
        """Prepare what does not depend on the CoM.

        Args:
            legs: the lumped robot.
            step: distance of the samples (s).
            heading: the torso's yaw (rad), shape (n,).
            feet: poses x, y, z (m), yaw (rad) of the left and the right TCP, shape (4, 2, n).
        """
        self._legs, self._step = legs, step
        turn, turns = _direction(heading), _direction(feet[3])
        self._forward = turn[:, None]
        self._body = _turn(turn, legs.p_TBody)
        self._hips = np.stack([_turn(turn, legs.p_THip * [1, side, 1]) for side in (1, -1)], axis=1)
        self._feet = feet[:3] + _turn(turns, legs.p_TcpFoot)
        self._reach = feet[:3] + _turn(turns, legs.p_TcpAnkle) - self._hips

    def angular_momentum(self, com: np.ndarray) -> np.ndarray:
        """Return the angular momentum about the CoM (Nms) for a CoM (m), both of shape (3, n)."""
        legs, arms = self._legs, self._arms(com)
        masses = [legs.thigh_mass, legs.shank_mass, legs.foot_mass]
        inertias = [legs.thigh_inertia, legs.shank_inertia]
        weights = np.array([legs.body_mass, *np.repeat([*masses, *inertias], 2)])
        x, y, z = arms
        u, v, w = derivative(arms, self._step)
        spins = y * w - z * v, z * u - x * w, x * v - y * u
        return np.array([weights @ spin for spin in spins])

    def _arms(self, com: np.ndarray) -> np.ndarray:
        """Return what turns about the CoM, shape (3, 11, n).

        That is where the body, the thighs, the shanks and the feet are relative to it (m), and the
        directions of the thighs and the shanks.
        """
        legs = self._legs
        torso, line, thighs = self._posture(com)
        hips, shanks = self._hips + torso[:, None], line - thighs
        arms = np.empty((3, 11, com.shape[1]))
        arms[:, 0] = torso + self._body
        arms[:, 1:3] = hips + legs.thigh_com / legs.thigh_length * thighs
        arms[:, 3:5] = hips + thighs + legs.shank_com / legs.shank_length * shanks
        arms[:, 5:7] = self._feet
        arms[:, :7] -= com[:, None]
        arms[:, 7:9] = thighs / legs.thigh_length
        arms[:, 9:11] = shanks / legs.shank_length
        return arms

    def _posture(self, com: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where the torso is, shape (3, n), and what `_legs_from` says of the legs (m)."""
        legs = self._legs
        # The links' masses, seen as points in the joints.
        thigh, shank = legs.thigh_com / legs.thigh_length, legs.shank_com / legs.shank_length
        at_knee = legs.thigh_mass * thigh + legs.shank_mass * (1 - shank)
        at_ankle = legs.shank_mass * shank
        above = legs.mass - 2 * (at_ankle + legs.foot_mass)
        ends = (above - legs.body_mass) / 2 * self._hips + legs.foot_mass * self._feet
        ends += at_ankle * (self._hips + self._reach)
        rest = ends[:, 0] + ends[:, 1] + legs.body_mass * self._body
        torso = com - self._body
        line, thighs = self._legs_from(torso)
        # The torso's place follows from the CoM, which depends on the legs: a quick contraction.
        for _ in range(PASSES - 1):
            moment = above * torso + at_knee * (thighs[:, 0] + thighs[:, 1]) + rest
            torso = torso + com - moment / legs.mass
            line, thighs = self._legs_from(torso)
        return torso, line, thighs

    def _legs_from(self, torso: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the lines from hip to ankle and from hip to knee (m), both of shape (3, 2, n).

        Legs bend forward, over-stretched ones are straight: a knee is some way along the line to
        the ankle, and some way out in the forward direction.
        """
        thigh, shank = self._legs.thigh_length, self._legs.shank_length
        line = self._reach - torso[:, None]
        squared = np.einsum("ikn,ikn->kn", line, line)
        ahead = self._forward[0] * line[0] + self._forward[1] * line[1]
        projected = (squared + (thigh**2 - shank**2)) / 2
        bend = np.maximum(thigh**2 * squared - projected**2, 0.0)
        out = np.sqrt(bend / (squared - ahead**2))
        thighs = (projected - out * ahead) / squared * line
        thighs[:2] += out * self._forward
        return line, thighs


def derivative(values: np.ndarray, step: float) -> np.ndarray:
    """Return derivatives along the last axis: central differences, one-sided at the ends."""
    rates = np.empty_like(values)
    np.subtract(values[..., 2:], values[..., :-2], out=rates[..., 1:-1])
    rates[..., 0] = 2 * (values[..., 1] - values[..., 0])
    rates[..., -1] = 2 * (values[..., -1] - values[..., -2])
    rates /= 2 * step
    return rates


def _direction(yaw: np.ndarray) -> np.ndarray:
    """Return x and y of the forward direction."""
    return np.array([np.cos(yaw), np.sin(yaw)])


def _turn(forward: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the vector p turned about z until x points forward, shape (3, ...)."""
    c, s = forward
    return np.array([c * p[0] - s * p[1], s * p[0] + c * p[1], np.full_like(c, p[2])])
