"""Hybrid position/force control of one foot (the paper's section IV.B).

| paper          | here                               |
|----------------|------------------------------------|
| lambda_f,d     | `desired_wrench`                   |
| U^-1           | `inverse_gradient()`               |
| delta          | `time_constant`                    |
| w_f'           | `force_rate`, eq. 15               |

U is the gradient that the controller acts through: the pads in series with the servos. What is
around it (eq. 10, 11, 12, 13, 16 and 21) is in `FootForceControl`.
"""

from dataclasses import dataclass

from lola_drake.block import law
from lola_drake.blocks.foot_force_control import FootForceControl, FootForceControlParams
from lola_drake.parameters import parameter
from lola_drake.signals import PERIOD
from lola_drake.theory.scalars import exp


@dataclass(frozen=True)
class HybridForceControlParams(FootForceControlParams):
    """The error dynamics, and what is the same for all force laws."""

    time_constant: float = parameter(
        0.02,
        "delta, of the force error (paper)",
        "s",
        minimum=0.001,
        maximum=1,
        symbol="δ",
        slider=(0.005, 0.08, 0.001),
    )
    sensed_area: bool = parameter(
        False, "U of the pads whose switches are closed, instead of all (the paper's outlook)"
    )
    exact_angles: bool = parameter(
        False, "no small angles in eq. 6 and 13, and turned feet about their own axes"
    )

    @property
    def senses(self) -> bool:
        """Return whether the law follows the contact as it is, see `SensedForceControl`."""
        return self.sensed_area or self.exact_angles


def inverse_gradient(inverse_contact_matrix, compliance, relaxation, time_constant):
    """Return the inverse of the gradient that the controller acts through, shape (3, 3).

    Pads and servos in series: U_pads^-1 - C / (1 + T / delta). A servo is a spring with a damper
    beside it; what changes as quickly as delta meets both (own choice: with C alone 63 % of a step
    of the torques would come in 0.77 delta).

    Args:
        inverse_contact_matrix: U_pads^-1 of eq. 8.
        compliance: C, the motion of the foot by its wrench, its command held.
        relaxation: T, the time constant with which the servos give way (s).
        time_constant: delta (s).
    """
    u, c = inverse_contact_matrix, compliance
    met = time_constant / (time_constant + relaxation)
    return (
        (u[0][0] - met * c[0][0], u[0][1] - met * c[0][1], u[0][2] - met * c[0][2]),
        (u[1][0] - met * c[1][0], u[1][1] - met * c[1][1], u[1][2] - met * c[1][2]),
        (u[2][0] - met * c[2][0], u[2][1] - met * c[2][1], u[2][2] - met * c[2][2]),
    )


def motion(inverse, wrench_rate):
    """Return the rates (sin gamma_x, sin gamma_y, z) that give a wrench's rate, shape (3,).

    Args:
        inverse: U^-1, shape (3, 3).
        wrench_rate: of T_x, T_y (Nm/s) and F_z (N/s), shape (3,).
    """
    u, (t_x, t_y, f_z) = inverse, wrench_rate
    return (
        u[0][0] * t_x + u[0][1] * t_y + u[0][2] * f_z,
        u[1][0] * t_x + u[1][1] * t_y + u[1][2] * f_z,
        u[2][0] * t_x + u[2][1] * t_y + u[2][2] * f_z,
    )


def force_control_rate(inverse, error, desired_rate, time_constant):
    """Return w_f' of eq. 15 (sin gamma_x, sin gamma_y, z per second), shape (3,).

    Args:
        inverse: U^-1, shape (3, 3).
        error: lambda_d - lambda, T_x, T_y (Nm) and F_z (N).
        desired_rate: lambda_d' (Nm/s, N/s).
        time_constant: what to divide the error by (s), see `held_time_constant`.
    """
    t_x = desired_rate[0] + error[0] / time_constant
    t_y = desired_rate[1] + error[1] / time_constant
    f_z = desired_rate[2] + error[2] / time_constant
    return motion(inverse, (t_x, t_y, f_z))


def held_time_constant(time_constant):
    """Return what to divide the error by (s) when the rate is held for a period.

    The error of an ideal contact is then exp(-PERIOD/delta) of itself in the next tick.
    """
    return PERIOD / (1 - exp(-PERIOD / time_constant))


def wrench_error(wanted, contact_wrench):
    """Return e = wanted - lambda: T_x, T_y (Nm), F_z (N)."""
    return (
        wanted[0] - contact_wrench[0],
        wanted[1] - contact_wrench[1],
        wanted[2] - contact_wrench[2],
    )


class HybridForceControl(FootForceControl):
    """Lets the force error die out as delta e' + e = 0 (eq. 14)."""

    Params = HybridForceControlParams

    @law
    def force_rate(
        wrench,
        wrench_rate,
        contact_wrench,
        time_constant,
        inverse_contact_matrix,
        compliance,
        relaxation,
    ):
        """Return w_f' of eq. 15."""
        inverse = inverse_gradient(inverse_contact_matrix, compliance, relaxation, time_constant)
        held = held_time_constant(time_constant)
        error = wrench_error(wrench, contact_wrench)
        return force_control_rate(inverse, error, wrench_rate, held)
