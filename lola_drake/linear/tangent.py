"""Coordinates of small motions for states that are not free vectors.

A floating base has a unit quaternion in its state: four numbers for three rotations. A small
motion is described by a rotation vector instead, expressed in W like the angular velocity that
follows it. Two matrices take one to the other: `lift` gives the rate of the state per coordinate,
`project` its left inverse.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import System


@dataclass(frozen=True)
class Tangent:
    """Where the quaternions lie in a state vector.

    Attributes:
        size: of the state.
        quaternions: index of the first entry (w) of each.
    """

    size: int
    quaternions: tuple[int, ...] = ()

    @property
    def dimension(self) -> int:
        """Return the number of coordinates of a small motion."""
        return self.size - len(self.quaternions)

    def lift(self, state: np.ndarray) -> np.ndarray:
        """Return the derivative of the state by the coordinates, shape (size, dimension)."""
        matrix = np.eye(self.size)
        for first in self.quaternions:
            matrix[first : first + 4, first + 1 : first + 4] = _rates(state[first : first + 4])
        return np.delete(matrix, list(self.quaternions), axis=1)

    def project(self, state: np.ndarray) -> np.ndarray:
        """Return the derivative of the coordinates by the state, shape (dimension, size)."""
        matrix = np.eye(self.size)
        for first in self.quaternions:
            rates = _rates(state[first : first + 4])
            matrix[first + 1 : first + 4, first : first + 4] = 4 * rates.T
        return np.delete(matrix, list(self.quaternions), axis=0)

    def move(self, state: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Return the state after a motion; rotations are exact, and the quaternion stays a unit."""
        free = np.delete(np.arange(self.size), list(self.quaternions))
        full = np.zeros(self.size)
        full[free] = motion
        moved = state + full
        for first in self.quaternions:
            where = slice(first, first + 4)
            moved[where] = _product(_exponential(full[first + 1 : first + 4]), state[where])
        return moved

    def difference(self, state: np.ndarray, base: np.ndarray) -> np.ndarray:
        """Return the motion that leads from `base` to `state`, the inverse of `move`."""
        full = state - base
        for first in self.quaternions:
            where = slice(first, first + 4)
            conjugate = base[where] * [1.0, -1.0, -1.0, -1.0]
            full[first + 1 : first + 4] = _logarithm(_product(state[where], conjugate))
        return np.delete(full, list(self.quaternions))


def tangent_of(system: System, size: int) -> Tangent:
    """Return the coordinates of a block's discrete state of the given size."""
    if not isinstance(system, MultibodyPlant):
        return Tangent(size)
    bodies = [system.get_body(index) for index in system.GetFloatingBaseBodies()]
    firsts = (b.floating_positions_start() for b in bodies if b.has_quaternion_dofs())
    return Tangent(size, tuple(sorted(firsts)))


def _rates(quaternion: np.ndarray) -> np.ndarray:
    """Return the quaternion's derivative by a rotation vector in W, shape (4, 3)."""
    w, x, y, z = quaternion
    return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], vector])


def _exponential(rotation: np.ndarray) -> np.ndarray:
    half = 0.5 * np.linalg.norm(rotation)
    return np.concatenate([[np.cos(half)], 0.5 * np.sinc(half / np.pi) * rotation])


def _logarithm(quaternion: np.ndarray) -> np.ndarray:
    quaternion = quaternion * np.copysign(1.0, quaternion[0])
    length = np.linalg.norm(quaternion[1:])
    angle = 2 * np.arctan2(length, quaternion[0])
    return quaternion[1:] * (angle / length if length > 1e-150 else 2.0)
