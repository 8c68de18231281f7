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
the task is the feet's motion relative to the CoM. The planned horizontal forces, which no foot
wrench of the paper has, belong to it by the parameter `horizontal_feedforward` (own choice).
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from lola_drake.block import Block, Part, State, law
from lola_drake.parameters import parameter, validate
from lola_drake.robot import JOINT_INDEX, Kinematics
from lola_drake.signals import GAIT_PHASE, JOINT_ANGLES, JOINTS, PERIOD, TASK_REFERENCE
from lola_drake.theory.kinematics import FOOT_TASK, foot_task

_PRESCRIBED = tuple(JOINT_INDEX[name] for name in ("tzfl", "tzfr", "tvp", "tvt"))
"""Joints of the toes and the head: they have no part in the feet's task."""


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
        0.2, "distance from a joint limit where the retreat begins", "rad", minimum=0.001, maximum=1
    )
    feedforward: float = parameter(
        1.0, "part of the static torque that is fed forward", "-", minimum=0, maximum=1
    )
    horizontal_feedforward: float = parameter(
        0.0,
        "part of the planned horizontal forces that the fed-forward torque holds, too",
        "-",
        minimum=0,
        maximum=1,
    )

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Redundancy:
    """What the joints that the task leaves free do; all angles in rad.

    Attributes:
        comfort: the pose to which they return, shape (24,).
        lower, upper: angles beyond which they retreat from their limits, shape (24,).
        mobility: the diagonal of W^-1, 0 for the joints that are prescribed, shape (24,).
    """

    comfort: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    mobility: np.ndarray


RESOLUTION = (
    "drift_correction",
    "damping",
    "comfort_gain",
    "limit_gain",
    "feedforward",
    "horizontal_feedforward",
)
"""The parameters that a law needs to resolve the joint rates."""


def redundancy(params: InverseKinematicsParams, kinematics: Kinematics, comfort: np.ndarray):
    """Return what the free joints do in a robot with a comfort pose (rad), shape (24,)."""
    lower, upper = kinematics.position_limits
    mobility = np.ones(len(JOINTS))
    mobility[list(_PRESCRIBED)] = 0.0
    return Redundancy(
        comfort=comfort.copy(),
        lower=lower + params.limit_margin,
        upper=upper - params.limit_margin,
        mobility=mobility,
    )


def wished_rates(q, comfort, lower, upper, comfort_gain, limit_gain, toes, toe_rates, correction):
    """Return the joint rates wanted in the null space, z (rad/s), shape (24,).

    They descend the cost (comfort pose, joint limits); the toes and the head are prescribed.

    Args:
        q: joint angles (rad), shape (24,).
        comfort: the comfort pose (rad), shape (24,).
        lower: the angles below which a joint retreats from its limit (rad), shape (24,).
        upper: the angles above which it does, shape (24,).
        comfort_gain: return to the comfort pose (1/s).
        limit_gain: retreat from the limits (1/s).
        toes: lift of the left and the right toe (rad), shape (2,).
        toe_rates: their rates (rad/s), shape (2,).
        correction: part of a deviation that is removed per second (1/s).
    """
    rates = np.zeros(len(q))
    for k in range(len(q)):
        beyond = q[k] - min(max(q[k], lower[k]), upper[k])
        rates[k] = comfort_gain * (comfort[k] - q[k]) - limit_gain * beyond
    left, right, pan, tilt = _PRESCRIBED
    rates[left] = toe_rates[0] + correction * (toes[0] - q[left])
    rates[right] = -toe_rates[1] + correction * (-toes[1] - q[right])
    rates[pan], rates[tilt] = -correction * q[pan], -correction * q[tilt]
    return rates


def resolved_rates(jacobian, rates, mobility, wish, damping):
    """Return joint rates that follow the task rates and come near the wish otherwise.

    Args:
        jacobian: task rates per joint rate, shape (m, n).
        rates: wanted task rates, shape (m,).
        mobility: diagonal of the inverse weights W^-1, shape (n,); a joint with 0 keeps its wish.
        wish: z, joint rates wanted in the null space (rad/s), shape (n,).
        damping: of the pseudo-inverse, d.

    Returns:
        q' = z + W^-1 J^T (J W^-1 J^T + d E)^-1 (w' - J z), shape (n,).
    """
    m, n = len(rates), len(wish)
    lower, y = np.zeros((m, m)), np.zeros(m)
    for i in range(m):
        y[i] = rates[i]
        for k in range(n):
            y[i] -= jacobian[i, k] * wish[k]
        for j in range(i + 1):
            for k in range(n):
                lower[i, j] += jacobian[i, k] * mobility[k] * jacobian[j, k]
        lower[i, i] += damping
    solve_positive(lower, y)
    joint_rates = np.zeros(n)
    for k in range(n):
        along = 0.0
        for i in range(m):
            along += jacobian[i, k] * y[i]
        joint_rates[k] = wish[k] + mobility[k] * along
    return joint_rates


def solve_positive(matrix, y):
    """Solve matrix x = y in place for a positive definite matrix, given by its lower triangle.

    Afterwards y is x, and the triangle is the Cholesky factor; ArithmeticError if there is none.
    """
    m = len(y)
    for i in range(m):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= matrix[i, k] * matrix[j, k]
            if i > j:
                matrix[i, j] = rest / matrix[j, j]
            elif rest > 0.0:
                matrix[i, i] = sqrt(rest)
            else:
                raise ArithmeticError("the task's Gram matrix is not positive definite")
    for i in range(m):
        for k in range(i):
            y[i] -= matrix[i, k] * y[k]
        y[i] /= matrix[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            y[i] -= matrix[k, i] * y[k]
        y[i] /= matrix[i, i]


def holding_torque(jacobian, desired_wrench, ideal_wrench, load, feedforward, horizontal):
    """Return a part of the static torque (Nm) that holds the feet's wrenches, shape (24,).

    Args:
        jacobian: of both feet's tasks, shape (12, 24).
        desired_wrench: T_x, T_y, F_z of the left and then the right foot, shape (6,) or more.
        ideal_wrench: Lambda_id, of which the feet share F_x and F_y by their loads, (2,) or more.
        load: shares of the left and right foot, shape (2,).
        feedforward: the part.
        horizontal: the part of F_x and F_y.
    """
    n = jacobian.shape[1]
    torque = np.zeros(n)
    for k in range(n):
        held = 0.0
        for foot in range(2):
            first = FOOT_TASK * foot
            held += jacobian[first + 3, k] * desired_wrench[3 * foot]
            held += jacobian[first + 4, k] * desired_wrench[3 * foot + 1]
            held += jacobian[first + 2, k] * desired_wrench[3 * foot + 2]
            share = horizontal * load[foot]
            held += share * jacobian[first, k] * ideal_wrench[0]
            held += share * jacobian[first + 1, k] * ideal_wrench[1]
        torque[k] = -feedforward * held
    return torque


def command_of(q, joint_rates, torque):
    """Return the joint command that moves the joints from q for one period, shape (72,)."""
    n = len(q)
    command = np.zeros(3 * n)
    for k in range(n):
        command[k] = q[k] + PERIOD * joint_rates[k]
        command[n + k], command[2 * n + k] = joint_rates[k], torque[k]
    return command


class InverseKinematics(Block):
    """Turns the feet's commands into joint commands.

    Its state is the commanded joint angles, so that it needs no measured ones.
    """

    Params = InverseKinematicsParams
    state = (State(JOINT_ANGLES, hidden=True),)
    parts = {
        "toes": Part(TASK_REFERENCE, "toes"),
        "toe_rates": Part(TASK_REFERENCE, "toe_rates"),
        "load": Part(GAIT_PHASE, "load"),
    }
    differentiable = False

    def __init__(
        self, params: InverseKinematicsParams, kinematics: Kinematics, initial: np.ndarray
    ):
        """Create the block.

        Args:
            params: gains.
            kinematics: the controller's model.
            initial: joint angles at the start (rad), shape (24,); also the comfort pose.
        """
        super().__init__(
            params,
            initial={JOINT_ANGLES.name: initial},
            tree=kinematics.tree,
            **vars(redundancy(params, kinematics, initial)),
        )

    @law
    def joint_command(
        joint_angles,
        task_command_l,
        task_command_r,
        desired_wrench,
        ideal_wrench,
        load,
        toes,
        toe_rates,
        tree,
        comfort,
        lower,
        upper,
        mobility,
        drift_correction,
        damping,
        comfort_gain,
        limit_gain,
        feedforward,
        horizontal_feedforward,
    ):
        """Return q, q' and the torque that is fed forward."""
        q, correction = joint_angles, drift_correction / PERIOD
        w, jacobian = foot_task(q, tree)
        rates = np.zeros(2 * FOOT_TASK)
        for i in range(FOOT_TASK):
            j = FOOT_TASK + i
            rates[i] = task_command_l[j] + correction * (task_command_l[i] - w[i])
            rates[j] = task_command_r[j] + correction * (task_command_r[i] - w[j])
        wish = wished_rates(
            *(q, comfort, lower, upper, comfort_gain, limit_gain, toes, toe_rates, correction)
        )
        joint_rates = resolved_rates(jacobian, rates, mobility, wish, damping)
        torque = holding_torque(
            *(jacobian, desired_wrench, ideal_wrench, load, feedforward, horizontal_feedforward)
        )
        return command_of(q, joint_rates, torque)

    @law
    def next_joint_angles(joint_command):
        """Return the commanded joint angles."""
        return joint_command[: len(joint_command) // 3]
