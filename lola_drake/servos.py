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
from pydrake.systems.primitives import MatrixGain, Multiplexer

from lola_drake.block import Block, State, law
from lola_drake.blocks.joint_servos import JointServosParams, servo_gains, set_servo_gains
from lola_drake.signals import JOINTS, PERIOD, PLANT_STATE, Field, Signal

_N = len(JOINTS)
_Q, _V = PLANT_STATE.slice("q"), PLANT_STATE.slice("q_dot")


class ImplicitServos:
    """The plant's own implicit PD control, within the torque limits of its drives."""

    def __init__(self, plant: MultibodyPlant, params: JointServosParams):
        """Give every actuator of a plant its gains; the plant may be finalized or not."""
        self._plant = plant
        set_servo_gains(plant, params)

    def connect(
        self, builder: DiagramBuilder, desired: OutputPort, feedforward: OutputPort
    ) -> OutputPort:
        """Connect what the servos follow, and return the torques at the joints."""
        plant = self._plant
        robot = plant.GetModelInstanceByName("lola")
        builder.Connect(desired, plant.get_desired_state_input_port(robot))
        builder.Connect(feedforward, plant.get_actuation_input_port())
        return plant.get_net_actuation_output_port()


class DampingServos:
    """The same servos as a force and a damping of the joints, without limits of torque."""

    def __init__(self, plant: MultibodyPlant, params: JointServosParams):
        """Damp the joints of a plant that is not finalized yet."""
        self._plant = plant
        self._kp, self._kd = servo_gains(plant, params)
        self._damping = self._kd + PERIOD * self._kp
        for index, damping in zip(plant.GetJointActuatorIndices(), self._damping, strict=True):
            joint = plant.get_joint_actuator(index).joint()
            joint.set_default_damping(joint.default_damping() + damping)

    def connect(
        self, builder: DiagramBuilder, desired: OutputPort, feedforward: OutputPort
    ) -> OutputPort:
        """Connect what the servos follow, and return the torques at the joints."""
        plant = self._plant
        known = self._stacked(builder, plant.get_state_output_port(), desired, feedforward)
        first = PLANT_STATE.size
        by_state = np.zeros((_N, known.size()))
        by_state[:, _Q] = -np.diag(self._kp)
        by_state[:, first : first + _N] = np.diag(self._kp)
        by_state[:, first + _N : first + 2 * _N] = np.diag(self._kd)
        by_state[:, first + 2 * _N :] = np.eye(_N)
        force = np.zeros((plant.num_velocities(), known.size()))
        force[-_N:] = by_state
        builder.Connect(
            self._product(builder, force, known), plant.get_applied_generalized_force_input_port()
        )
        # The torque of the step: its velocity at the end is v + PERIOD times the acceleration.
        robot = plant.GetModelInstanceByName("lola")
        acceleration = plant.get_generalized_acceleration_output_port(robot)
        stepped = self._stacked(builder, known, acceleration)
        torque = np.zeros((_N, stepped.size()))
        torque[:, : known.size()] = by_state
        torque[:, _V] -= np.diag(self._damping)
        torque[:, -_N:] -= PERIOD * np.diag(self._damping)
        return self._product(builder, torque, stepped)

    @staticmethod
    def _stacked(builder: DiagramBuilder, *ports: OutputPort) -> OutputPort:
        stack = builder.AddSystem(Multiplexer([port.size() for port in ports]))
        for i, port in enumerate(ports):
            builder.Connect(port, stack.get_input_port(i))
        return stack.get_output_port()

    @staticmethod
    def _product(builder: DiagramBuilder, matrix: np.ndarray, port: OutputPort) -> OutputPort:
        product = builder.AddSystem(MatrixGain(matrix))
        builder.Connect(port, product.get_input_port())
        return product.get_output_port()


OVERLOADED = Signal(
    "overloaded", "Whether a drive has reached its limit.", (Field("overloaded", ("",), "0/1"),)
)


class DriveGuard(Block):
    """Watches whether a drive reaches its limit of torque, as `DampingServos` cannot."""

    kind = "sensor"
    state = (State(OVERLOADED, hidden=True),)
    switching = True

    @law
    def next_overloaded(overloaded, joint_torque, torque_limit):
        """Return 1 from the first tick on in which a torque is not below its limit."""
        reached = overloaded[0]
        for i in range(len(torque_limit)):
            if abs(joint_torque[i]) >= torque_limit[i]:
                reached = 1.0
        return (reached,)
