"""The joint servos in the plant, in two ways that obey the same law.

A servo gives kp (q_d - q) + kd (v_d - v) + feed-forward, with q and v at the end of the step. As
the plant's implicit PD control it costs the contact solver a constraint per joint. The same torque
is a force out of what is known at the beginning of the step, and a damping of the joint: q at the
end is q + PERIOD v, so

    torque = [kp (q_d - q) + kd v_d + feed-forward] - (kd + PERIOD kp) v .

That is a third cheaper and knows no limit of torque; a run goes on with the implicit servos from
where a drive would reach its limit (`DriveGuard`).
"""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Demultiplexer, MatrixGain, Multiplexer

from lola_drake.block import Block, Part, State, law
from lola_drake.blocks.joint_servos import JointServosParams, servo_gains, set_servo_gains
from lola_drake.signals import JOINTS, PERIOD, PLANT_STATE, Field, Signal

_N = len(JOINTS)
_Q = PLANT_STATE.slice("q")


class ImplicitServos:
    """The plant's own implicit PD control, within the torque limits of its drives."""

    def __init__(self, plant: MultibodyPlant, params: JointServosParams):
        """Give every actuator of a plant its gains; the plant may be finalized or not."""
        self._plant = plant
        set_servo_gains(plant, params)

    def connect(
        self, builder: DiagramBuilder, desired: OutputPort, feedforward: OutputPort
    ) -> OutputPort:
        """Connect what the servos follow, and return what `guard` reads: their torques."""
        plant = self._plant
        robot = plant.GetModelInstanceByName("lola")
        builder.Connect(desired, plant.get_desired_state_input_port(robot))
        builder.Connect(feedforward, plant.get_actuation_input_port())
        return plant.get_net_actuation_output_port()

    def guard(self) -> "DriveGuard":
        """Return the block that watches the drives."""
        return DriveGuard(torque_limit=self._plant.GetEffortUpperLimits())


class DampingServos:
    """The same servos as a force and a damping of the joints, without limits of torque."""

    def __init__(self, plant: MultibodyPlant, params: JointServosParams):
        """Damp the joints of a plant that is not finalized yet."""
        self._plant = plant
        self._kp, self._kd = servo_gains(plant, params)
        dampings = self._kd + PERIOD * self._kp
        for index, damping in zip(plant.GetJointActuatorIndices(), dampings, strict=True):
            joint = plant.get_joint_actuator(index).joint()
            joint.set_default_damping(joint.default_damping() + damping)

    def connect(
        self, builder: DiagramBuilder, desired: OutputPort, feedforward: OutputPort
    ) -> OutputPort:
        """Connect what the servos follow, and return what `guard` reads: the accelerations."""
        plant = self._plant
        known = builder.AddSystem(Multiplexer([PLANT_STATE.size, 2 * _N, _N]))
        for i, port in enumerate((plant.get_state_output_port(), desired, feedforward)):
            builder.Connect(port, known.get_input_port(i))
        first = PLANT_STATE.size
        matrix = np.zeros((plant.num_velocities(), first + 3 * _N))
        force = matrix[-_N:]
        force[:, _Q] = -np.diag(self._kp)
        force[:, first : first + _N] = np.diag(self._kp)
        force[:, first + _N : first + 2 * _N] = np.diag(self._kd)
        force[:, first + 2 * _N :] = np.eye(_N)
        forces = builder.AddSystem(MatrixGain(matrix))
        builder.Connect(known.get_output_port(), forces.get_input_port())
        builder.Connect(forces.get_output_port(), plant.get_applied_generalized_force_input_port())
        robot = plant.GetModelInstanceByName("lola")
        acceleration = plant.get_generalized_acceleration_output_port(robot)
        joints = builder.AddSystem(Demultiplexer([acceleration.size() - _N, _N]))
        builder.Connect(acceleration, joints.get_input_port())
        return joints.get_output_port(1)

    def guard(self) -> "DriveGuard":
        """Return the block that watches the drives."""
        limit = self._plant.GetEffortUpperLimits()
        return DampedDriveGuard(torque_limit=limit, stiffness=self._kp, damping=self._kd)


DRIVE_FEEDBACK = Signal(
    "drive_feedback",
    "What the plant says of its drives: their torques, or how the joints accelerate.",
    (Field("feedback", JOINTS, "Nm or rad/s^2"),),
)

OVERLOADED = Signal(
    "overloaded", "Whether a drive has reached its limit.", (Field("overloaded", ("",), "0/1"),)
)


class DriveGuard(Block):
    """Watches whether a drive reaches its limit of torque, as `DampingServos` cannot."""

    kind = "sensor"
    state = (State(OVERLOADED, hidden=True),)
    signals = (DRIVE_FEEDBACK,)
    switching = True

    @law
    def joint_torque(drive_feedback):
        """Return the torques of the drives, which the plant knows."""
        return drive_feedback

    @law
    def next_overloaded(overloaded, joint_torque, torque_limit):
        """Return 1 from the first tick on in which a torque is not below its limit."""
        reached = overloaded[0]
        for i in range(len(torque_limit)):
            if abs(joint_torque[i]) >= torque_limit[i]:
                reached = 1.0
        return (reached,)


class DampedDriveGuard(DriveGuard):
    """The same for `DampingServos`, whose torques follow from how the joints accelerate."""

    parts = {"q": Part(PLANT_STATE, "q"), "q_dot": Part(PLANT_STATE, "q_dot")}

    @law
    def joint_torque(
        q, q_dot, drive_feedback, joint_desired_state, joint_feedforward, stiffness, damping
    ):
        """Return what the servos give, with q and v at the end of the step."""
        n = len(stiffness)
        torque = np.zeros(n)
        for i in range(n):
            v = q_dot[i] + PERIOD * drive_feedback[i]
            to_go = joint_desired_state[i] - (q[i] + PERIOD * v)
            faster = joint_desired_state[n + i] - v
            torque[i] = stiffness[i] * to_go + damping[i] * faster + joint_feedforward[i]
        return torque
