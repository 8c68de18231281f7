"""The contact switches of the foot pads: closed by force, opened by its absence.

Each pad of LOLA carries a binary switch; the thresholds are estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce

from lola_drake.block import Block, Part, Reading, State, law
from lola_drake.bus import MissedCycles, gaps_of, is_missed
from lola_drake.parameters import ParameterError, listing, parameter, validate
from lola_drake.signals import CONTACT, FEET, GROUND_FORCE, PLANT_STATE
from lola_drake.theory.kinematics import KinematicTree, body_poses, turned

PAD_NAMES = ("rear_left", "rear_right", "front_left", "front_right")
"""Of a foot, in the order of its switches."""


@dataclass(frozen=True)
class DeadSwitch:
    """A switch that says the same for ever."""

    foot: str = parameter("l", "left or right", choices=FEET)
    pad: str = parameter("front_left", "of that foot", choices=PAD_NAMES)
    reads: str = parameter("open", "what it says", choices=("open", "closed"))

    def __post_init__(self):
        validate(self)

    @property
    def number(self) -> int:
        """Return which of the eight switches it is."""
        return 4 * FEET.index(self.foot) + PAD_NAMES.index(self.pad)

    @property
    def threshold(self) -> float:
        """Return the force (N) from which on it is closed: never, or always."""
        return inf if self.reads == "open" else -inf


@dataclass(frozen=True)
class ContactSwitchesParams:
    """Thresholds of the switches, and those that are dead."""

    close_force: float = parameter(15.0, "closes the switch (estimate)", "N", above=0, maximum=500)
    open_force: float = parameter(8.0, "opens the switch (estimate)", "N", above=0, maximum=500)
    dead: tuple[DeadSwitch, ...] = listing("faults: switches that are dead", 8)

    def __post_init__(self):
        validate(self)
        dead = [switch.number for switch in self.dead]
        if len(set(dead)) < len(dead):
            twice = [f"{switch.pad} of {switch.foot}" for switch in self.dead]
            raise ParameterError("dead", twice, "every switch once")
        if self.open_force > self.close_force:
            raise ParameterError(
                "open_force", self.open_force, f"<= close_force {self.close_force}"
            )

    def ideal(self) -> "ContactSwitchesParams":
        """Return switches that close at the lightest touch, without hysteresis; or are dead."""
        return replace(self, close_force=1.0, open_force=1.0)


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

    def __init__(
        self,
        params: ContactSwitchesParams,
        joints: Sequence[int],
        tree: KinematicTree,
        missed: Sequence[MissedCycles] = (),
    ):
        """Create the switches of the pads, all closed but those that are dead.

        Args:
            params: thresholds.
            joints: indices of the pads' weld joints in the plant, in the order of the switches.
            tree: of the robot's joints.
            missed: cycles of the bus.
        """
        self._joints = joints
        close, opened = np.full(8, params.close_force), np.full(8, params.open_force)
        start = np.ones(8)
        for switch in params.dead:
            close[switch.number] = opened[switch.number] = switch.threshold
            start[switch.number] = switch.reads == "closed"
        super().__init__(
            params,
            initial={CONTACT.name: start},
            tree=tree,
            closes_at=close,
            opens_at=opened,
            gaps=gaps_of(missed),
        )

    def read_pad_reactions(self, forces: list[SpatialForce]) -> np.ndarray:
        """Return the plant's torque and force on every pad, in its frame (Nm, N)."""
        return np.concatenate([forces[joint].get_coeffs() for joint in self._joints])

    @law
    def next_contact(contact, quaternion, q, pad_reactions, tree, closes_at, opens_at, gaps, time):
        """Return the new state of the switches, 1 for closed: they have a hysteresis."""
        if is_missed(time, gaps):
            return contact
        forces = forces_in_world(quaternion, q, pad_reactions, tree)
        closed = np.zeros(len(contact))
        for pad in range(len(contact)):
            threshold = opens_at[pad] if contact[pad] > 0.5 else closes_at[pad]
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
