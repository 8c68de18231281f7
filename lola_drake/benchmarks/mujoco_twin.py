"""The robot in MuJoCo without its controller: what its motions need, and commands played to it."""

from copy import copy

import numpy as np

from lola_drake.benchmarks.bare_plant import SOLES, Motion
from lola_drake.mujoco_model import mujoco, servo_control, to_qpos, to_qvel
from lola_drake.plant import has_fallen
from lola_drake.signals import PERIOD


def inverse_dynamics(model: mujoco.MjModel, motion: Motion) -> np.ndarray:
    """Return what the drives must do for a motion under given loads on the soles.

    The joints' damping counts at the end of a step, as in Drake.

    Returns:
        Force (N) on the torso in W, torque (Nm) in its own frame, both zero if the motion is
        possible at all, and the torques of the joints (Nm), shape (n, 30).
    """
    model = copy(model)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_INVDISCRETE
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    soles = [model.body(name).id for name in SOLES]
    needed = np.empty((len(motion.q), model.nv))
    for k, (q, v, v_dot) in enumerate(zip(motion.q, motion.v, motion.v_dot, strict=True)):
        data.qpos, data.qvel, data.qacc = to_qpos(q), to_qvel(q, v), to_qvel(q, v_dot)
        mujoco.mj_inverse(model, data)
        needed[k] = data.qfrc_inverse
        for sole, wrench in zip(soles, motion.sole_wrench[k], strict=True):
            load = np.zeros(model.nv)
            mujoco.mj_applyFT(model, data, wrench[:3], wrench[3:], np.zeros(3), sole, load)
            needed[k] -= load
    return needed


class Twin:
    """The robot in MuJoCo with servos that get the commands of a table, one row per tick."""

    def __init__(self, model: mujoco.MjModel, q: np.ndarray, commands: np.ndarray):
        """Put the robot somewhere, at rest.

        Args:
            model: from `mujoco_model`.
            q: Drake's positions, shape (31,).
            commands: as for `bare_plant`.
        """
        self.model, self.ticks = model, 0
        self._data, self._controls = mujoco.MjData(model), servo_control(model, commands)
        self._data.qpos = to_qpos(q)
        self._torso = model.body("torso").id

    def AdvanceTo(self, time: float) -> None:
        """Simulate until then (s); named as that of Drake's Simulator is, to take turns with it."""
        while self.ticks < round(time / PERIOD):
            self._data.ctrl = self._controls[self.ticks]
            mujoco.mj_step(self.model, self._data)
            self.ticks += 1

    def has_fallen(self) -> bool:
        """Return whether the torso is too low or too inclined to come back."""
        return has_fallen(np.concatenate([self._data.qpos[3:7], self._data.qpos[:3]]))

    def com_height(self) -> float:
        """Return the height of the CoM over the floor (m) at the begin of the last tick."""
        return self._data.subtree_com[self._torso, 2]

    def joint_torques(self) -> np.ndarray:
        """Return the torques of the drives in the last tick (Nm), shape (24,)."""
        return self._data.qfrc_actuator[6:].copy()

    def vertical_forces(self) -> np.ndarray:
        """Return the vertical force on each of `SOLES` in the last tick (N), shape (4,)."""
        forces, load = np.zeros(len(SOLES)), np.zeros(6)
        for i, contact in enumerate(self._data.contact):
            mujoco.mj_contactForce(self.model, self._data, i, load)
            pad = self.model.geom_bodyid[contact.geom[1]]
            sole = self.model.body(self.model.body_parentid[pad]).name
            # The load is along the contact's axes, of which the first one is its normal.
            forces[SOLES.index(sole)] += load[:3] @ contact.frame.reshape(3, 3)[:, 2]
        return forces
