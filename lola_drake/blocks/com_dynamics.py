"""The CoM's dynamics inside the force control, for one foot (the paper's section IV.C).

In single support an error of the contact force is also met by accelerating the CoM.

| paper          | here                                         |
|----------------|----------------------------------------------|
| M              | `inertia`, the diagonal of M in eq. 18       |
| R_f            | written out in `com_acceleration()`          |
| g_a            | `gain`                                       |
| s_a,f          | `single_support()`, from measured contacts   |
| K_a,x          | `decay_gain`                                 |
| Delta w_a,f'   | `com_dynamics_rate`, eq. 20                  |

K_a,x and the limits are our own choice; the paper gives no numbers. With K_a,x = 1/delta the motion
of the CoM ends as fast as an error of the contact force.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.blocks.scalars import AlgebraicSystem, convertible
from lola_drake.parameters import parameter, validate
from lola_drake.signals import (
    COM_DYNAMICS_RATE,
    CONTACT,
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    TASK_MODIFICATION,
    TASK_REFERENCE,
)


@dataclass(frozen=True)
class ComDynamicsParams:
    """Gains and limits of the integrated CoM dynamics."""

    gain: float = parameter(1.0, "g_a, 0 switches it off (paper)", "-", minimum=0, maximum=1)
    decay_gain: float = parameter(
        50.0,
        "K_a,x, decay outside single support (own choice, 1/delta)",
        "1/s",
        minimum=0,
        maximum=500,
    )
    max_height_rate: float = parameter(0.4, "limit of the vertical part", "m/s", above=0, maximum=5)
    max_angle_rate: float = parameter(
        1.5, "limit of the angular parts", "rad/s", above=0, maximum=20
    )

    def __post_init__(self):
        validate(self)


def com_acceleration(
    inertia: Sequence[float], r_x: float, r_y: float, error: Sequence[float]
) -> tuple[float, float, float]:
    """Return Delta a = M^-1 R_f e (eq. 18): phi_x'', phi_y'' (rad/s^2), z_c'' (m/s^2).

    Args:
        inertia: theta_xx, theta_yy (kg m^2) and mass (kg), the diagonal of M.
        r_x: from the CoM to the foot in T (m).
        r_y: the same along y.
        error: e, the missing torques T_x, T_y (Nm) and vertical force (N) of the foot.
    """
    theta_xx, theta_yy, mass = inertia
    e_x, e_y, e_z = error
    return (e_x + r_y * e_z) / theta_xx, (e_y - r_x * e_z) / theta_yy, e_z / mass


def single_support(contact: Sequence[float], foot: int) -> bool:
    """Return s_a,f: whether the foot, and not the other one, has closed contacts.

    Args:
        contact: the switches of the left and then the right foot, 0 or 1, shape (8,).
        foot: 0 for left, 1 for right.
    """
    closed = (sum(contact[:4]) > 0, sum(contact[4:]) > 0)
    return closed[foot] and not closed[1 - foot]


def limited_step(
    rate: float, change: float, limit: float, modification: float, modification_limit: float
) -> float:
    """Return one direction of the integrator's next state.

    It is clamped, and does not grow where it drives the modification beyond its limit: there the
    integrator's output has no effect (anti-windup).

    Args:
        rate: the present state, an entry of Delta w_a,f'.
        change: what the integration would add.
        limit: greatest magnitude of the state.
        modification: the same entry of Delta w.
        modification_limit: its greatest magnitude.
    """
    at_limit = abs(modification) >= modification_limit * (1 - 1e-9)
    if at_limit and change * modification > 0 and rate * modification >= 0:
        return rate
    return min(max(rate + change, -limit), limit)


@convertible
class ComDynamics(AlgebraicSystem):
    """Integrates the force error of the stance foot into a motion of that foot.

    The state is Delta w_a,f' (rates of sin gamma_x, sin gamma_y and z). The numeric parameter 0
    holds g_a and K_a,x.

    .. pydrake_system::

        name: ComDynamics
        input_ports:
        - desired_wrench
        - contact_wrench
        - contact
        - task_reference
        - task_modification
        output_ports:
        - com_dynamics_rate
    """

    def __init__(
        self,
        params: ComDynamicsParams,
        foot: str,
        inertia: np.ndarray,
        modification_limits: np.ndarray,
        period: float,
    ):
        """Create the block of one foot.

        Args:
            params: gains and limits.
            foot: "l" or "r".
            inertia: theta_xx, theta_yy (kg m^2) and mass (kg), shape (3,).
            modification_limits: of the force control's Delta w, shape (3,).
            period: the control period (s).
        """
        super().__init__()
        self._foot, self._inertia, self._period = FEET.index(foot), inertia.tolist(), period
        self._limits = (params.max_angle_rate, params.max_angle_rate, params.max_height_rate)
        self._modification_limits = modification_limits.tolist()
        self._r = TASK_REFERENCE.slice(f"w_{foot}", 2)
        self._desired_wrench = DESIRED_WRENCH.slice(f"wrench_{foot}")
        self._gains = self.DeclareNumericParameter(self.Vector([params.gain, params.decay_gain]))
        state = self.DeclareDiscreteState(COM_DYNAMICS_RATE.size)
        self._desired = self.DeclareVectorInputPort("desired_wrench", DESIRED_WRENCH.size)
        self._actual = self.DeclareVectorInputPort("contact_wrench", CONTACT_WRENCH.size)
        self._contact = self.DeclareVectorInputPort("contact", CONTACT.size)
        self._reference = self.DeclareVectorInputPort("task_reference", TASK_REFERENCE.size)
        self._modification = self.DeclareVectorInputPort(
            "task_modification", TASK_MODIFICATION.size
        )
        self._rate = self.DeclareStateOutputPort(COM_DYNAMICS_RATE.name, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        rate = self._rate.Eval(context).tolist()
        gain, decay_gain = context.get_numeric_parameter(self._gains).CopyToVector().tolist()
        if single_support(self._contact.Eval(context).tolist(), self._foot):
            r_x, r_y = self._reference.Eval(context).tolist()[self._r]
            error = self._desired.Eval(context)[self._desired_wrench] - self._actual.Eval(context)
            acceleration = com_acceleration(self._inertia, r_x, r_y, error.tolist())
            change = [-gain * self._period * a for a in acceleration]
        else:
            change = [-decay_gain * self._period * r for r in rate]
        modification = self._modification.Eval(context).tolist()
        directions = zip(
            rate, change, self._limits, modification, self._modification_limits, strict=True
        )
        state.set_value([limited_step(*direction) for direction in directions])
