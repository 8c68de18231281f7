"""Velocity-level inverse kinematics with automatic supervisory control (Liegeois).

The paper names the method [26]. The law is the one of the LOLA group's publications: weighted
pseudo-inverse, drift correction, and the gradient of a cost in the null space (joint limits and
comfort pose). Damping, weights and margins are our own choice.

| paper         | here                         |
|---------------|------------------------------|
| w_mod, w_mod' | `task_command_l/r`           |
| q, q'         | `q` and `q_dot` of `joint_command` |

With it goes a feed-forward torque for the joint controllers, as LOLA's joint command carries one:
the static torque that holds the desired foot wrenches, -J^T lambda_d. Gravity is part of it, since
the task is the feet's motion relative to the CoM.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import LeafSystem
from scipy.linalg.lapack import dposv

from lola_drake.blocks.hybrid_force_control import FORCE_CONTROLLED
from lola_drake.parameters import parameter, validate
from lola_drake.robot import FOOT_TASK, JOINT_INDEX, Kinematics
from lola_drake.signals import DESIRED_WRENCH, JOINT_COMMAND, JOINTS, TASK_COMMAND, TASK_REFERENCE

_N = len(JOINTS)
_PRESCRIBED = [JOINT_INDEX[name] for name in ("tzfl", "tzfr", "tvp", "tvt")]
_TOES, _TOE_RATES = TASK_REFERENCE.slice("toes"), TASK_REFERENCE.slice("toe_rates")
_WRENCH_ROWS = np.concatenate([FORCE_CONTROLLED, FOOT_TASK + FORCE_CONTROLLED])


@dataclass(frozen=True)
class InverseKinematicsParams:
    """Drift correction, damping and the null space."""

    drift_correction: float = parameter(
        0.1, "part of the task error that is removed in one tick", "-", minimum=0, maximum=1
    )
    damping: float = parameter(1e-4, "damping of the pseudo-inverse", "-", minimum=1e-9, maximum=1)
    comfort_gain: float = parameter(
        2.0, "return to the comfort pose", "1/s", minimum=0, maximum=100
    )
    limit_gain: float = parameter(
        5.0, "retreat from the joint limits", "1/s", minimum=0, maximum=100
    )
    limit_margin: float = parameter(
        0.2, "distance from a joint limit where the retreat begins", "rad", above=0, maximum=1
    )
    feedforward: float = parameter(
        1.0, "part of the static torque that is fed forward", "-", minimum=0, maximum=1
    )

    def __post_init__(self):
        validate(self)


def null_space_motion(
    q: np.ndarray,
    comfort: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    comfort_gain: float,
    limit_gain: float,
) -> np.ndarray:
    """Return the joint rates that descend the cost (rad/s).

    Args:
        q: joint angles (rad), shape (n,).
        comfort: the comfort pose, shape (n,).
        lower: the angles below which a joint retreats from its limit, shape (n,).
        upper: the angles above which it does, shape (n,).
        comfort_gain: return to the comfort pose (1/s).
        limit_gain: retreat from the limits (1/s).
    """
    beyond = q - np.minimum(np.maximum(q, lower), upper)
    return comfort_gain * (comfort - q) - limit_gain * beyond


def resolve_rates(
    jacobian: np.ndarray,
    rates: np.ndarray,
    mobility: np.ndarray,
    wish: np.ndarray,
    damping: np.ndarray,
) -> np.ndarray:
    """Return joint rates that follow the task rates and come near the wish otherwise.

    Args:
        jacobian: task rates per joint rate, shape (m, n).
        rates: wanted task rates, shape (m,).
        mobility: diagonal of the inverse weights W^-1, shape (n,), or once per row of the Jacobian,
            (m, n), which is faster; a joint with 0 keeps its wish.
        wish: z, joint rates wanted in the null space (rad/s), shape (n,).
        damping: D of the pseudo-inverse, shape (m, m).

    Returns:
        q' = z + W^-1 J^T (J W^-1 J^T + D)^-1 (w' - J z), shape (n,).
    """
    weighted = jacobian * mobility
    gram = weighted.dot(jacobian.T) + damping
    # The transpose is the same matrix, in the order that LAPACK needs; positions spare f2py time.
    _, multipliers, failed = dposv(gram.T, rates - jacobian.dot(wish), 1, 1)
    if failed:
        raise ArithmeticError("inverse kinematics: the task's Gram matrix is not positive definite")
    return wish + weighted.T.dot(multipliers)


class JointResolution:
    """From wanted rates of a task to a joint command; the redundant joints follow their wishes.

    The toes and the head are prescribed, the other joints stay near the comfort pose and away
    from their limits.
    """

    def __init__(
        self,
        params: InverseKinematicsParams,
        position_limits: tuple[np.ndarray, np.ndarray],
        comfort: np.ndarray,
        period: float,
    ):
        """Create it for joints with the given limits and comfort pose (rad), shape (24,)."""
        self._params, self._comfort, self._period = params, comfort.copy(), period
        lower, upper = position_limits
        self._lower, self._upper = lower + params.limit_margin, upper - params.limit_margin
        self._damping = params.damping * np.eye(2 * FOOT_TASK)
        # From the feet's force-controlled directions to their tasks, and to what holds against it.
        self._reaction = -params.feedforward * np.eye(2 * FOOT_TASK)[:, _WRENCH_ROWS]
        self._mobility = np.ones((2 * FOOT_TASK, _N))
        self._mobility[:, _PRESCRIBED] = 0.0
        self.correction = params.drift_correction / period

    def command(
        self,
        q: np.ndarray,
        task: np.ndarray,
        rates: np.ndarray,
        reference: np.ndarray,
        torque: np.ndarray,
    ) -> np.ndarray:
        """Return the joint command that moves the joints from q for one period.

        Args:
            q: joint angles (rad), shape (24,).
            task: task rates per joint rate, shape (12, 24).
            rates: wanted task rates, shape (12,).
            reference: `task_reference`, for the toes.
            torque: to feed forward (Nm), shape (24,).
        """
        params = self._params
        wish = null_space_motion(
            q, self._comfort, self._lower, self._upper, params.comfort_gain, params.limit_gain
        )
        for joint, rate in self._prescribed_rates(q, reference):
            wish[joint] = rate
        q_dot = resolve_rates(task, rates, self._mobility, wish, self._damping)
        return np.concatenate([q + self._period * q_dot, q_dot, torque])

    def _prescribed_rates(
        self, q: np.ndarray, reference: np.ndarray
    ) -> Iterator[tuple[int, float]]:
        """Yield the joints of the toes and the head with their rates."""
        (left, right), (rate_left, rate_right) = (
            reference[_TOES].tolist(),
            reference[_TOE_RATES].tolist(),
        )
        angles, rates = (left, -right, 0.0, 0.0), (rate_left, -rate_right, 0.0, 0.0)
        for joint, angle, rate in zip(_PRESCRIBED, angles, rates, strict=True):
            yield joint, rate + self.correction * (angle - q.item(joint))

    def holding_torque(self, jacobian: np.ndarray, desired_wrench: np.ndarray) -> np.ndarray:
        """Return the static torque (Nm) that holds both feet's desired wrenches, shape (24,).

        Args:
            jacobian: of both feet's tasks, shape (12, 24).
            desired_wrench: the signal of that name.
        """
        return jacobian.T.dot(self._reaction.dot(desired_wrench[:6]))


class InverseKinematics(LeafSystem):
    """Turns the feet's commands into joint commands.

    The state is the commanded joint angles, so that the block needs no measured ones.

    .. pydrake_system::

        name: InverseKinematics
        input_ports:
        - task_command_l
        - task_command_r
        - task_reference
        - desired_wrench
        output_ports:
        - joint_command
    """

    def __init__(
        self,
        params: InverseKinematicsParams,
        kinematics: Kinematics,
        initial: np.ndarray,
        period: float,
    ):
        """Create the block.

        Args:
            params: gains.
            kinematics: the controller's model; the block uses it alone.
            initial: joint angles at the start (rad), shape (24,); also the comfort pose.
            period: the control period (s).
        """
        super().__init__()
        self._kinematics = kinematics
        self._resolution = JointResolution(params, kinematics.position_limits, initial, period)
        state = self.DeclareDiscreteState(initial)
        self._commands = [
            self.DeclareVectorInputPort(f"task_command_{foot}", TASK_COMMAND.size) for foot in "lr"
        ]
        self._reference = self.DeclareVectorInputPort("task_reference", TASK_REFERENCE.size)
        self._desired = self.DeclareVectorInputPort("desired_wrench", DESIRED_WRENCH.size)
        inputs = {p.ticket() for p in (*self._commands, self._reference, self._desired)}
        self._output = self.DeclareVectorOutputPort(
            JOINT_COMMAND.name,
            JOINT_COMMAND.size,
            self._calc,
            prerequisites_of_calc=inputs | {self.discrete_state_ticket(state)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc(self, context, output):
        q = context.get_discrete_state_vector().value()
        left, right = (port.Eval(context).tolist() for port in self._commands)
        kinematics, resolution = self._kinematics, self._resolution
        kinematics.update(q)
        w, w_dot = left[:6] + right[:6], left[6:] + right[6:]
        rates = [
            rate + resolution.correction * (wanted - actual)
            for rate, wanted, actual in zip(w_dot, w, kinematics.w.tolist(), strict=True)
        ]
        output.set_value(
            resolution.command(
                q,
                kinematics.jacobian,
                np.array(rates),
                self._reference.Eval(context),
                resolution.holding_torque(kinematics.jacobian, self._desired.Eval(context)),
            )
        )

    def _update(self, context, state):
        state.set_value(self._output.Eval(context)[:_N])
