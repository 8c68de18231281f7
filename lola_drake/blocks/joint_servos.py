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

    position_gain: float = parameter(70.0, "of the position loop (estimate)", "1/s", above=0)
    velocity_bandwidth: float = parameter(
        800.0, "of the velocity loop with the bare rotor (estimate)", "rad/s", above=0
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


def limit_command(
    command: np.ndarray,
    sent: np.ndarray,
    speed_limit: np.ndarray,
    torque_limit: np.ndarray,
    period: float,
) -> np.ndarray:
    """Return the joint command within the joints' speeds and torques.

    Args:
        command: q, q', torque (rad, rad/s, Nm), shape (72,).
        sent: the command sent before, shape (72,).
        speed_limit: greatest speeds (rad/s), shape (24,).
        torque_limit: greatest torques (Nm), shape (24,).
        period: time since the command before (s).
    """
    q, q_dot, torque = command[:_N], command[_N : 2 * _N], command[2 * _N :]
    reach = period * speed_limit
    return np.concatenate(
        [
            np.minimum(np.maximum(q, sent[:_N] - reach), sent[:_N] + reach),
            np.minimum(np.maximum(q_dot, -speed_limit), speed_limit),
            np.minimum(np.maximum(torque, -torque_limit), torque_limit),
        ]
    )


class JointServos(LeafSystem):
    """Sends joint commands over the bus to the servos in the plant.

    The state is the line of commands on the bus, the newest first.

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
        self._speed_limit, self._torque_limit, self._period = speed_limit, torque_limit, period
        self._command = self.DeclareVectorInputPort("joint_command", JOINT_COMMAND.size)
        at_rest = np.concatenate([initial, np.zeros(2 * _N)])
        state = self.DeclareDiscreteState(np.tile(at_rest, params.delay_ticks))
        on = {self.discrete_state_ticket(state)}
        self.DeclareVectorOutputPort(
            "joint_desired_state", 2 * _N, self._calc_desired, prerequisites_of_calc=on
        )
        self.DeclareVectorOutputPort(
            "joint_feedforward", _N, self._calc_feedforward, prerequisites_of_calc=on
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_desired(self, context, output):
        output.set_value(context.get_discrete_state_vector().value()[-3 * _N : -_N])

    def _calc_feedforward(self, context, output):
        output.set_value(context.get_discrete_state_vector().value()[-_N:])

    def _update(self, context, state):
        line = context.get_discrete_state_vector().value()
        newest = limit_command(
            self._command.Eval(context),
            line[: 3 * _N],
            self._speed_limit,
            self._torque_limit,
            self._period,
        )
        state.set_value(np.concatenate([newest, line[: -3 * _N]]))
