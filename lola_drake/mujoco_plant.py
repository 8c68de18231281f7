"""LOLA on its ground in MuJoCo, as a system that takes the place of Drake's plant.

In each tick it says what Drake's plant says: the state at the begin, and what holds soles, pads and
drives during the step that begins there.
"""

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import Multiplexer

from lola_drake.mujoco_model import mujoco, mujoco_model, to_drake, to_qpos
from lola_drake.scenario import Scenario
from lola_drake.servos import DriveGuard
from lola_drake.signals import JOINTS, PERIOD, PLANT_STATE

_N = len(JOINTS)
_PADS = 8

ROUNDS = 10
"""How often it is tried, at most, which drives are at their limits."""


class MujocoPlant(LeafSystem):
    """The robot, its servos and its ground. Its state is MuJoCo's, with what the solver begins at.

    Attributes:
        model: MuJoCo's.
        torque_limit: of the drives (Nm), shape (24,).
    """

    def __init__(
        self, scenario: Scenario, q: np.ndarray, soles: tuple[int, ...], pads: tuple[int, ...]
    ):
        """Put the robot somewhere, at rest.

        Args:
            scenario: gives servos and ground.
            q: Drake's positions, shape (31,).
            soles: where what holds the soles stands in the list of reaction forces.
            pads: the same of the pads.
        """
        super().__init__()
        self.model = model = mujoco_model(
            scenario.real_servos(), scenario.terrain, errors=scenario.model_errors
        )
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
        self._kp, self._kd = -model.actuator_biasprm[:, 1:3].T
        self._damping = self._kd + PERIOD * self._kp
        self.torque_limit = model.jnt_actfrcrange[1:, 1].copy()
        self._armature = model.dof_armature[6:].copy()
        self._data, self._joints = mujoco.MjData(model), [*soles, *pads]
        self._pushes = [(push, model.body(push.body).id) for push in scenario.pushes]
        start = np.concatenate([to_qpos(q), np.zeros(2 * model.nv)])
        self._stays, speeds = len(start), model.nq + model.nv
        self._qpos, self._qvel = slice(0, model.nq), slice(model.nq, speeds)
        self._warmstart = slice(speeds, None)
        state = self.DeclareDiscreteState(start)
        self._command = self.DeclareVectorInputPort("command", 3 * _N)
        size = len(start) + _N + model.nsensordata
        self._step = self.DeclareVectorOutputPort("step", size, self._calculate_step)
        reads_state = {self.discrete_state_ticket(state)}
        self.DeclareVectorOutputPort(
            "state", PLANT_STATE.size, self._calculate_state, prerequisites_of_calc=reads_state
        )
        self.DeclareVectorOutputPort("net_actuation", _N, self._calculate_torque)
        model_value = Value[list[SpatialForce]]
        self.DeclareAbstractOutputPort("reaction_forces", model_value, self._calculate_reactions)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def get_state_output_port(self) -> OutputPort:
        """Return the port of positions and velocities, in Drake's order."""
        return self.GetOutputPort("state")

    def get_reaction_forces_output_port(self) -> OutputPort:
        """Return the port of what the welds of soles and pads hold."""
        return self.GetOutputPort("reaction_forces")

    def get_net_actuation_output_port(self) -> OutputPort:
        """Return the port of the drives' torques (Nm)."""
        return self.GetOutputPort("net_actuation")

    def _calculate_step(self, context, output) -> None:
        state = context.get_discrete_state_vector().value()
        q, v = state[self._qpos][7:], state[self._qvel][6:]
        command = self._command.Eval(context)
        torque = self._kp * (command[:_N] - q) + self._kd * command[_N : 2 * _N]
        torque += command[2 * _N :]
        pushed = self._pushed(state, round(context.get_time() / PERIOD))
        at_limit = np.zeros(_N)
        for _ in range(ROUNDS):
            damping = np.where(at_limit, 0.0, self._damping)
            given = np.where(at_limit, at_limit * self.torque_limit, torque - damping * v)
            change = self._advance(state, given, damping, pushed)
            wanted = torque - self._damping * (v + change[6:])
            drives = np.where(at_limit, given, wanted)
            tried = at_limit
            at_limit = np.where(np.abs(wanted) > self.torque_limit, np.sign(wanted), 0.0)
            if (at_limit == tried).all():
                break
        data = self._data
        after = data.qvel + change
        # The forces that hold soles and pads belong to the motion that came out.
        data.qacc = change / PERIOD
        mujoco.mj_rnePostConstraint(self.model, data)
        mujoco.mj_sensorAcc(self.model, data)
        output.SetFromVector(
            np.concatenate([self._data.qpos, after, data.qacc_warmstart, drives, data.sensordata])
        )

    def _pushed(self, state: np.ndarray, tick: int) -> np.ndarray:
        """Return the generalized forces of the pushes in a tick, shape (30,)."""
        model, data, pushed = self.model, self._data, np.zeros(self.model.nv)
        acting = [(push, body) for push, body in self._pushes if push.force(tick).any()]
        if acting:
            data.qpos = state[self._qpos]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
        for push, body in acting:
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ push.point
            mujoco.mj_applyFT(model, data, push.force(tick), np.zeros(3), point, body, pushed)
        return pushed

    def _advance(
        self, state: np.ndarray, torque: np.ndarray, damping: np.ndarray, pushed: np.ndarray
    ) -> np.ndarray:
        """Take MuJoCo's step from a state, and return by how much the velocities change.

        Args:
            state: of this system.
            torque: of the drives, as they are with the velocities at its begin (Nm), shape (24,).
            damping: by how much less they give for a velocity at its end (Nms/rad), shape (24,).
            pushed: generalized forces from outside, shape (30,).
        """
        model, data = self.model, self._data
        before = state[self._qvel]
        data.qpos, data.qvel = state[self._qpos], before
        data.qacc_warmstart = state[self._warmstart]
        data.qfrc_applied = pushed
        data.qfrc_applied[6:] += torque
        # (M + PERIOD damping) a = what acts at the begin: so contacts know of it, too.
        model.dof_armature[6:] = self._armature + PERIOD * (damping + model.dof_damping[6:])
        mujoco.mj_step(model, data)
        change = data.qvel - before
        data.qvel = before
        return change

    def _calculate_state(self, context, output) -> None:
        state = context.get_discrete_state_vector().value()
        output.SetFromVector(to_drake(state[self._qpos], state[self._qvel]))

    def _calculate_torque(self, context, output) -> None:
        output.SetFromVector(self._step.Eval(context)[self._stays : self._stays + _N])

    def _calculate_reactions(self, context, output) -> None:
        readings = self._step.Eval(context)[self._stays + _N :].reshape(-1, 3)
        soles, pads = readings[:-_PADS], readings[-_PADS:]
        forces = [SpatialForce(tau=soles[i + 1], f=soles[i]) for i in range(0, len(soles), 2)]
        forces += [SpatialForce(tau=np.zeros(3), f=force) for force in pads]
        listed = [SpatialForce.Zero()] * (max(self._joints) + 1)
        for joint, force in zip(self._joints, forces, strict=True):
            listed[joint] = force
        output.set_value(listed)

    def _update(self, context, state) -> None:
        state.set_value(self._step.Eval(context)[: self._stays])


class MujocoServos:
    """The servos of a `MujocoPlant`: the law of `lola_drake.servos`, within limits of torque."""

    def __init__(self, plant: MujocoPlant):
        self._plant = plant

    def connect(
        self, builder: DiagramBuilder, desired: OutputPort, feedforward: OutputPort
    ) -> OutputPort:
        """Connect what the servos follow, and return what `guard` reads: their torques."""
        command = builder.AddSystem(Multiplexer([2 * _N, _N]))
        builder.Connect(desired, command.get_input_port(0))
        builder.Connect(feedforward, command.get_input_port(1))
        builder.Connect(command.get_output_port(), self._plant.GetInputPort("command"))
        return self._plant.get_net_actuation_output_port()

    def guard(self) -> DriveGuard:
        """Return the block that watches the drives."""
        return DriveGuard(torque_limit=self._plant.torque_limit)
