"""The robot in a mirror beside it: left and right exchanged, for the tests of symmetry."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from lola_drake.signals import JOINTS


def _other_side(name: str) -> str:
    return name[:-1] + {"r": "l", "l": "r"}[name[-1]] if len(name) == 4 else name


MIRRORED_JOINTS = [JOINTS.index(_other_side(name)) for name in JOINTS]
"""Which joint each joint becomes."""


def mirror_signs(plant: MultibodyPlant) -> np.ndarray:
    """Return what mirroring does to each joint's angle, 1 or -1: axes mirror as pseudovectors."""
    axes = np.array([plant.GetJointByName(name).revolute_axis() for name in JOINTS])
    return np.sum(axes * [-1.0, 1.0, -1.0] * axes[MIRRORED_JOINTS], axis=1)
