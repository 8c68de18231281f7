"""The distributed joint controllers, as far as they are not part of the plant.

LOLA's servos cascade a P position loop over a PI velocity loop at 100 us. In the plant they are
its implicit PD gains; this block adds what lies between the central controller and them: the bus
delay, the limits of speed and torque, and the feed-forward. Bandwidths are estimates.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.framework import LeafSystem

from lola_drake.parameters import parameter, validate
from lola_drake.signals import JOINT_COMMAND, JOINTS

_N = len(JOINTS)


@dataclass(frozen=True)
class JointServosParams:
    """Bandwidths of the joint controllers and the delay of the bus."""

    position_gain: float = parameter(
        70.0, "of the position loop (estimate)", "1/s", above=0, maximum=500
    )
    velocity_bandwidth: float = parameter(
        800.0, "of the velocity loop with the bare rotor (estimate)", "rad/s", above=0, maximum=5e3
    )
    delay_ticks: int = parameter(1, "bus delay in control periods", "", minimum=1, maximum=20)

    def __post_init__(self):
        validate(self)


def set_servo_gains(plant: MultibodyPlant, params: JointServosParams) -> None:
    """Give every actuator of the plant the implicit PD gains of its servo."""
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        damping = params.velocity_bandwidth * actuator.default_reflected_inertia()
        actuator.set_controller_gains(
            PdControllerGains(p=params.position_gain * damping, d=damping)
        )


def limit_command(command: np.ndarray, sent: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return the joint command within the joints' speeds and torques.

    Args:
        command: q, q', torque (rad, rad/s, Nm), shape (72,).
        sent: q of the command before, shape (24,).
        limits: how far q may be from there (rad), and the greatest speeds (rad/s) and torques (Nm),
            shape (72,).
    """
    middle = np.zeros(len(command))
    middle[: len(sent)] = sent
    return np.minimum(np.maximum(command, middle - limits), middle + limits)


class JointServos(LeafSystem):
    """Sends joint commands over the bus to the servos in the plant.

    The state is the commands on the bus, the newest first; the oldest one arrives at the servos.

    .. pydrake_system::

        name: JointServos
        input_ports:
        - joint_command
        output_ports:
        - joint_desired_state
        - joint_feedforward
    """

    def __init__(
        self,
        params: JointServosParams,
        speed_limit: np.ndarray,
        torque_limit: np.ndarray,
        initial: np.ndarray,
        period: float,
    ):
        """Create the block, holding the joint angles `initial` (rad), shape (24,)."""
        super().__init__()
        self._limits = np.concatenate([period * speed_limit, speed_limit, torque_limit])
        self._command = self.DeclareVectorInputPort("joint_command", JOINT_COMMAND.size)
        self._bus = [
            (
                self.DeclareDiscreteState(np.concatenate([initial, np.zeros(_N)])),
                self.DeclareDiscreteState(_N),
            )
            for _ in range(params.delay_ticks)
        ]
        desired_state, feedforward = self._bus[-1]
        self.DeclareStateOutputPort("joint_desired_state", desired_state)
        self.DeclareStateOutputPort("joint_feedforward", feedforward)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        for older, newer in zip(self._bus[1:], self._bus[:-1], strict=True):
            for to, group in zip(older, newer, strict=True):
                state.set_value(to, context.get_discrete_state(group).value())
        desired_state, feedforward = self._bus[0]
        sent = context.get_discrete_state(desired_state).value()[:_N]
        command = limit_command(self._command.Eval(context), sent, self._limits)
        state.set_value(desired_state, command[: 2 * _N])
        state.set_value(feedforward, command[2 * _N :])
