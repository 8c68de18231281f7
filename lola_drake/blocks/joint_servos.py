"""The distributed joint controllers, as far as they are not part of the plant.

LOLA's servos cascade a P position loop over a PI velocity loop at 100 us. In the plant they are
its implicit PD gains; this block adds what lies between the central controller and them: the bus
delay, the limits of speed and torque, and the feed-forward. Bandwidths are estimates.
"""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains

from lola_drake.block import Block, State, law
from lola_drake.bus import MissedCycles, gaps_of, is_missed
from lola_drake.parameters import listing, parameter, validate
from lola_drake.signals import (
    JOINT_COMMAND,
    JOINT_DESIRED_STATE,
    JOINT_FEEDFORWARD,
    JOINTS,
    PERIOD,
)
from lola_drake.theory.delay_line import arriving, delayed

_N = len(JOINTS)


@dataclass(frozen=True)
class JointServosParams:
    """Bandwidths of the joint controllers and the delay of the bus."""

    position_gain: float = parameter(
        70.0, "of the position loop (estimate)", "1/s", minimum=1, maximum=500
    )
    velocity_bandwidth: float = parameter(
        800.0,
        "of the velocity loop with the bare rotor (estimate)",
        "rad/s",
        minimum=10,
        maximum=5e3,
    )
    delay_ticks: int = parameter(1, "bus delay in control periods", "", minimum=1, maximum=20)
    missed: tuple[MissedCycles, ...] = listing("faults: bus cycles without a command", 1000)

    def __post_init__(self):
        validate(self)


def servo_gains(plant: MultibodyPlant, params: JointServosParams) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness (Nm/rad) and damping (Nms/rad) of the servos, each of shape (24,)."""
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    inertia = np.array([actuator.default_reflected_inertia() for actuator in actuators])
    damping = params.velocity_bandwidth * inertia
    return params.position_gain * damping, damping


def set_servo_gains(plant: MultibodyPlant, params: JointServosParams) -> None:
    """Give every actuator of the plant the implicit PD gains of its servo."""
    for index, p, d in zip(
        plant.GetJointActuatorIndices(), *servo_gains(plant, params), strict=True
    ):
        plant.get_joint_actuator(index).set_controller_gains(PdControllerGains(p=p, d=d))


def limited_command(command, sent, speed_limit, torque_limit):
    """Return the joint command within the joints' speeds and torques, shape (72,).

    Args:
        command: q, q', torque (rad, rad/s, Nm), shape (72,).
        sent: q of the command before, shape (24,) or more.
        speed_limit: greatest speeds (rad/s), shape (24,).
        torque_limit: greatest torques (Nm), shape (24,).
    """
    n = len(speed_limit)
    limited = np.zeros(3 * n)
    for i in range(n):
        reach = PERIOD * speed_limit[i]
        limited[i] = min(max(command[i], sent[i] - reach), sent[i] + reach)
        limited[n + i] = min(max(command[n + i], -speed_limit[i]), speed_limit[i])
        limited[2 * n + i] = min(max(command[2 * n + i], -torque_limit[i]), torque_limit[i])
    return limited


def newest_command(command, under_way, arrived, speed_limit, torque_limit):
    """Return the joint command within its limits, after what was sent before it, shape (72,).

    Args:
        command: as for `limited_command`.
        under_way: commands on the bus, the newest first; none without a delay.
        arrived: q and q' of the last command that has left the bus, shape (48,).
        speed_limit: as for `limited_command`.
        torque_limit: as for `limited_command`.
    """
    sent = under_way if len(under_way) else arrived
    return limited_command(command, sent, speed_limit, torque_limit)


UNDER_WAY = replace(JOINT_COMMAND, name="commands_under_way", doc="Commands on the bus.")


class JointServos(Block):
    """Sends joint commands over the bus to the servos in the plant."""

    Params = JointServosParams
    kind = "actuation"
    acts_outside = ("position_gain", "velocity_bandwidth")
    state = (State(UNDER_WAY, hidden=True), JOINT_DESIRED_STATE, JOINT_FEEDFORWARD)
    differentiable = False

    def __init__(
        self,
        params: JointServosParams,
        speed_limit: np.ndarray,
        torque_limit: np.ndarray,
        initial: np.ndarray,
    ):
        """Create the block, holding the joint angles `initial` (rad), shape (24,)."""
        standing = np.concatenate([initial, np.zeros(2 * _N)])
        super().__init__(
            params,
            initial={
                UNDER_WAY.name: np.tile(standing, params.delay_ticks - 1),
                JOINT_DESIRED_STATE.name: standing[: 2 * _N],
            },
            speed_limit=speed_limit,
            torque_limit=torque_limit,
            gaps=gaps_of(params.missed),
        )

    @law
    def next_commands_under_way(
        commands_under_way, joint_desired_state, joint_command, speed_limit, torque_limit
    ):
        """Put the newest command on the bus."""
        command = newest_command(
            joint_command, commands_under_way, joint_desired_state, speed_limit, torque_limit
        )
        return delayed(commands_under_way, command)

    @law
    def next_joint_desired_state(
        commands_under_way,
        joint_desired_state,
        joint_command,
        speed_limit,
        torque_limit,
        gaps,
        time,
    ):
        """Return q and q' of the command that arrives, or that was there."""
        if is_missed(time, gaps):
            return joint_desired_state
        command = newest_command(
            joint_command, commands_under_way, joint_desired_state, speed_limit, torque_limit
        )
        return arriving(commands_under_way, command)[: 2 * len(speed_limit)]

    @law
    def next_joint_feedforward(
        commands_under_way,
        joint_desired_state,
        joint_feedforward,
        joint_command,
        speed_limit,
        torque_limit,
        gaps,
        time,
    ):
        """Return the torque of the command that arrives, or that was there."""
        if is_missed(time, gaps):
            return joint_feedforward
        command = newest_command(
            joint_command, commands_under_way, joint_desired_state, speed_limit, torque_limit
        )
        return arriving(commands_under_way, command)[2 * len(speed_limit) :]
