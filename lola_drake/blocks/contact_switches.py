"""The contact switches of the foot pads: closed by force, opened by its absence.

Each pad of LOLA carries a binary switch; the thresholds are estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce

from lola_drake.block import Block, Part, Reading, State, law
from lola_drake.parameters import ParameterError, parameter, validate
from lola_drake.signals import CONTACT, GROUND_FORCE, PLANT_STATE
from lola_drake.theory.kinematics import KinematicTree, body_poses, turned


@dataclass(frozen=True)
class ContactSwitchesParams:
    """Thresholds of the switches."""

    close_force: float = parameter(15.0, "closes the switch (estimate)", "N", above=0, maximum=500)
    open_force: float = parameter(8.0, "opens the switch (estimate)", "N", above=0, maximum=500)

    def __post_init__(self):
        validate(self)
        if self.open_force > self.close_force:
            raise ParameterError(
                "open_force", self.open_force, f"<= close_force {self.close_force}"
            )

    def ideal(self) -> "ContactSwitchesParams":
        """Return switches that close at the lightest touch and have no hysteresis."""
        return ContactSwitchesParams(close_force=1.0, open_force=1.0)


def forces_in_world(quaternion, q, pad_reactions, tree):
    """Return what the pads bear, turned from their own frames to W; pad by pad, shape (24,).

    Args:
        quaternion: w, x, y, z of the torso in W.
        q: joint angles (rad), shape (24,).
        pad_reactions: torque and force (Nm, N) that hold every pad, in its frame, shape (48,); the
            ground puts the opposite force on it, since it weighs nothing.
        tree: of the robot's joints; a pad's frame is that of the body that carries it.
    """
    orientation, _, _ = body_poses(q, tree)
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    load, in_torso, forces = np.zeros(3), np.zeros(3), np.zeros(24)
    for pad in range(8):
        body = tree.pad_body[pad // 4][pad % 4]
        for i in range(3):
            load[i] = -pad_reactions[6 * pad + 3 + i]
        for i in range(3):
            in_torso[i] = turned(orientation, body, load, i)
        a, b, c = in_torso[0], in_torso[1], in_torso[2]
        # v + 2 w (u x v) + 2 u x (u x v), with the quaternion's vector part u.
        d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
        forces[3 * pad] = a + w * d + y * f - z * e
        forces[3 * pad + 1] = b + w * e + z * d - x * f
        forces[3 * pad + 2] = c + w * f + x * e - y * d
    return forces


class ContactSwitches(Block):
    """Watches the normal force of every pad of both feet.

    The ground's force on each foot is the truth of the simulation, for logs and tests; no block of
    the controller reads it.
    """

    Params = ContactSwitchesParams
    kind = "sensor"
    state = (State(CONTACT, start=1.0), GROUND_FORCE)
    parts = {"quaternion": Part(PLANT_STATE, "quaternion"), "q": Part(PLANT_STATE, "q")}
    objects = {"pad_reactions": Reading("reaction_forces", Value[list[SpatialForce]], 48)}
    switching = True

    def __init__(self, params: ContactSwitchesParams, joints: Sequence[int], tree: KinematicTree):
        """Create the switches of the pads, all closed.

        Args:
            params: thresholds.
            joints: indices of the pads' weld joints in the plant, in the order of the switches.
            tree: of the robot's joints.
        """
        self._joints = joints
        super().__init__(params, tree=tree)

    def read_pad_reactions(self, forces: list[SpatialForce]) -> np.ndarray:
        """Return the plant's torque and force on every pad, in its frame (Nm, N)."""
        return np.concatenate([forces[joint].get_coeffs() for joint in self._joints])

    @law
    def next_contact(contact, quaternion, q, pad_reactions, tree, close_force, open_force):
        """Return the new state of the switches, 1 for closed: they have a hysteresis."""
        forces = forces_in_world(quaternion, q, pad_reactions, tree)
        closed = np.zeros(len(contact))
        for pad in range(len(contact)):
            threshold = open_force if contact[pad] > 0.5 else close_force
            closed[pad] = 1.0 if forces[3 * pad + 2] > threshold else 0.0
        return closed

    @law
    def next_ground_force(quaternion, q, pad_reactions, tree):
        """Return the sum of each foot's pads in W (N)."""
        forces = forces_in_world(quaternion, q, pad_reactions, tree)
        total = np.zeros(6)
        for pad in range(8):
            for axis in range(3):
                total[3 * (pad // 4) + axis] += forces[3 * pad + axis]
        return total
