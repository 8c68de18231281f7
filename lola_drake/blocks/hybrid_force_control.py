"""Hybrid position/force control of one foot (the paper's section IV.B).

| paper          | here                                     |
|----------------|------------------------------------------|
| lambda_f,m     | `measured_wrench`                        |
| A_TF           | `wrench_at_tcp()`, eq. 13                |
| lambda_f       | `contact_wrench`                         |
| lambda_f,d     | `desired_wrench`                         |
| U              | `contact_matrix`                         |
| delta          | `time_constant`                          |
| K_x            | `position_gain`                          |
| b_f            | `blend` of `gait_phase`                  |
| Delta w_a,f'   | `com_dynamics_rate`                      |
| Delta w'       | `modification_rate()`, eq. 15, 16 and 21 |
| w_mod, w_mod'  | `task_command`, eq. 10 and 11            |

The model's stiffness is an estimate: LOLA's is not published.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.blocks.scalars import AlgebraicSystem, convertible, cos, exp, sin
from lola_drake.parameters import parameter, validate
from lola_drake.robot import Rows
from lola_drake.signals import (
    COM_DYNAMICS_RATE,
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    GAIT_PHASE,
    MEASURED_WRENCH,
    TASK_COMMAND,
    TASK_MODIFICATION,
    TASK_REFERENCE,
    TORSO_ORIENTATION,
)

FORCE_CONTROLLED = np.array([3, 4, 2])
"""S_c,f of eq. 12: sin gamma_x, sin gamma_y and z within a foot's task."""

_CONTROLLED = FORCE_CONTROLLED.tolist()


@dataclass(frozen=True)
class HybridForceControlParams:
    """The contact model, the error dynamics and the limits of the modification."""

    time_constant: float = parameter(
        0.02, "delta, of the force error (paper)", "s", minimum=0.001, maximum=1
    )
    position_gain: float = parameter(
        6.0, "K_x, return of the swing foot to the plan", "1/s", minimum=0, maximum=500
    )
    model_stiffness: float = parameter(
        1.05e5,
        "vertical stiffness of a whole foot in U; softer than the pads, see the README",
        "N/m",
        minimum=1e4,
        maximum=1e7,
    )
    grip_force: float = parameter(
        50.0,
        "vertical force from which on a foot's torques are controlled",
        "N",
        above=0,
        maximum=300,
    )
    leveling: float = parameter(
        1.0,
        "part of the inclination by which an unloaded foot is turned back",
        "-",
        minimum=0,
        maximum=1,
    )
    max_height: float = parameter(
        0.08, "limit of the foot's height modification", "m", above=0, maximum=0.3
    )
    max_height_rate: float = parameter(0.5, "limit of its rate", "m/s", above=0, maximum=5)
    max_angle: float = parameter(
        0.25, "limit of the foot's angle modification", "rad", above=0, maximum=0.8
    )
    max_angle_rate: float = parameter(2.0, "limit of its rate", "rad/s", above=0, maximum=20)

    def __post_init__(self):
        validate(self)

    def limits(self) -> np.ndarray:
        """Return the limits of Delta w (sin gamma_x, sin gamma_y, z), shape (3,)."""
        return np.array([self.max_angle, self.max_angle, self.max_height])

    def rate_limits(self) -> np.ndarray:
        """Return the limits of its rate, shape (3,)."""
        return np.array([self.max_angle_rate, self.max_angle_rate, self.max_height_rate])


@dataclass(frozen=True)
class FootSensor:
    """What the controller knows about one foot below its force sensor.

    Attributes:
        p_TcpSensor: the sensor relative to the TCP, in the foot frame F (m).
        weight: weight of the foot below the sensor (N).
        p_TcpFoot: its CoM relative to the TCP, in F (m).
    """

    p_TcpSensor: tuple[float, float, float]
    weight: float
    p_TcpFoot: tuple[float, float, float]


def wrench_at_tcp(
    measured: Sequence[float], angles: Sequence[float], foot: FootSensor
) -> np.ndarray:
    """Return lambda_f = A_TF lambda_f,m (eq. 13), freed of the foot's own weight.

    Args:
        measured: [F, T] of the sensor in its own frame (N, Nm), shape (6,).
        angles: the foot's sin gamma_x, sin gamma_y, gamma_z in T.
        foot: geometry and weight below the sensor.

    Returns:
        T_x, T_y, F_z at the TCP in T, shape (3,).
    """
    f_x, f_y, f_z, t_x, t_y, t_z = measured
    x, y, z = foot.p_TcpSensor
    t_x += y * f_z - z * f_y
    t_y += z * f_x - x * f_z
    t_z += x * f_y - y * f_x
    # R_TF for independent small rotations: the third row is (-sin gamma_y, sin gamma_x, cos).
    s_x, s_y, yaw = angles
    c, s = cos(yaw), sin(yaw)
    lean_x, lean_y = c * s_y + s * s_x, s * s_y - c * s_x
    x, y, _ = foot.p_TcpFoot
    return np.array(
        [
            c * t_x - s * t_y + lean_x * t_z + foot.weight * (s * x + c * y),
            s * t_x + c * t_y + lean_y * t_z - foot.weight * (c * x - s * y),
            -s_y * f_x + s_x * f_y + f_z + foot.weight,
        ]
    )


def force_control_rate(
    inverse_contact_matrix: Rows,
    error: Sequence[float],
    desired_rate: Sequence[float],
    time_constant: float,
) -> list[float]:
    """Return w_f' of eq. 15 (sin gamma_x, sin gamma_y, z per second), shape (3,)."""
    rates = zip(desired_rate, error, strict=True)
    t_x, t_y, f_z = (desired + wrong / time_constant for desired, wrong in rates)
    return [a * t_x + b * t_y + c * f_z for a, b, c in inverse_contact_matrix]


def held_time_constant(time_constant: float, period: float) -> float:
    """Return what to divide the error by (s) when the rate is held for a period.

    The error of an ideal contact is then exp(-period/delta) of itself in the next tick.
    """
    return period / (1 - exp(-period / time_constant))


def modification_rate(
    force_rate: float,
    com_dynamics_rate: float,
    deviation: float,
    blend: float,
    position_gain: float,
) -> float:
    """Return one entry of Delta w' (eq. 16 and 21).

    Args:
        force_rate: w_f' of eq. 15.
        com_dynamics_rate: Delta w_a,f' of eq. 20.
        deviation: w - w_id in this direction.
        blend: b_f, 1 for force control and 0 for position control.
        position_gain: K_x (1/s).
    """
    return blend * (force_rate + com_dynamics_rate) - (1 - blend) * position_gain * deviation


def limited_rate(
    rate: float, deviation: float, limit: float, rate_limit: float, period: float
) -> float:
    """Return the rate of one direction of Delta w, which ends where Delta w reaches its limit."""
    rate = min(max(rate, -rate_limit), rate_limit)
    return max(min(rate, (limit - deviation) / period), (-limit - deviation) / period)


@convertible
class HybridForceControl(AlgebraicSystem):
    """Turns one foot's force error into a modification of its trajectory.

    The state is Delta w, the modification of sin gamma_x, sin gamma_y and z. The numeric
    parameter 0 holds delta and K_x.

    .. pydrake_system::

        name: HybridForceControl
        input_ports:
        - task_reference
        - gait_phase
        - desired_wrench
        - measured_wrench
        - com_dynamics_rate
        - torso_orientation
        output_ports:
        - task_command
        - contact_wrench
        - task_modification
    """

    def __init__(
        self,
        params: HybridForceControlParams,
        foot: str,
        contact_matrix: np.ndarray,
        sensor: FootSensor,
        period: float,
    ):
        """Create the controller of one foot.

        Args:
            params: gains and limits.
            foot: "l" or "r".
            contact_matrix: U of eq. 8, shape (3, 3).
            sensor: the foot below its force sensor.
            period: the control period (s).
        """
        super().__init__()
        self._inverse = np.linalg.inv(contact_matrix).tolist()
        self._sensor, self._period = sensor, period
        self._grip_force, self._leveling = params.grip_force, params.leveling
        self._limits = params.limits().tolist()
        self._rate_limits = params.rate_limits().tolist()
        self._w = TASK_REFERENCE.slice(f"w_{foot}")
        self._w_dot = TASK_REFERENCE.slice(f"w_dot_{foot}")
        self._blend = GAIT_PHASE.slice("blend").start + FEET.index(foot)
        self._desired_wrench = DESIRED_WRENCH.slice(f"wrench_{foot}")
        self._desired_rate = DESIRED_WRENCH.slice(f"rate_{foot}")
        first = MEASURED_WRENCH.slice(f"F_{foot}").start
        self._measured_wrench = slice(first, first + 6)

        self._gains = self.DeclareNumericParameter(
            self.Vector([params.time_constant, params.position_gain])
        )
        state = self.DeclareDiscreteState(TASK_MODIFICATION.size)
        self._reference = self.DeclareVectorInputPort("task_reference", TASK_REFERENCE.size)
        self._phase = self.DeclareVectorInputPort("gait_phase", GAIT_PHASE.size)
        self._desired = self.DeclareVectorInputPort("desired_wrench", DESIRED_WRENCH.size)
        self._measured = self.DeclareVectorInputPort("measured_wrench", MEASURED_WRENCH.size)
        self._com_dynamics = self.DeclareVectorInputPort(
            "com_dynamics_rate", COM_DYNAMICS_RATE.size
        )
        self._orientation = self.DeclareVectorInputPort("torso_orientation", TORSO_ORIENTATION.size)
        own = {self.discrete_state_ticket(state), self.all_parameters_ticket()}
        contact_inputs = {self._reference.ticket(), self._measured.ticket()} | own
        all_inputs = contact_inputs | {
            port.ticket()
            for port in (self._phase, self._desired, self._com_dynamics, self._orientation)
        }
        self._command = self.DeclareVectorOutputPort(
            "task_command", TASK_COMMAND.size, self._calc_command, prerequisites_of_calc=all_inputs
        )
        self._contact = self.DeclareVectorOutputPort(
            "contact_wrench",
            CONTACT_WRENCH.size,
            self._calc_contact,
            prerequisites_of_calc=contact_inputs,
        )
        self._modification = self.DeclareStateOutputPort("task_modification", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_contact(self, context, output):
        _, _, _, s_x, s_y, yaw = self._reference.Eval(context).tolist()[self._w]
        delta_x, delta_y, _ = self._modification.Eval(context).tolist()
        measured = self._measured.Eval(context).tolist()[self._measured_wrench]
        angles = s_x + delta_x, s_y + delta_y, yaw
        output.set_value(wrench_at_tcp(measured, angles, self._sensor))

    def _calc_command(self, context, output):
        reference = self._reference.Eval(context).tolist()
        desired = self._desired.Eval(context).tolist()
        contact = self._contact.Eval(context).tolist()
        com_dynamics_rate = self._com_dynamics.Eval(context).tolist()
        phi_x, phi_y, _, _ = self._orientation.Eval(context).tolist()
        force_controlled = self._phase.Eval(context).item(self._blend)
        delta = self._modification.Eval(context).tolist()
        gains = context.get_numeric_parameter(self._gains).CopyToVector().tolist()
        time_constant, position_gain = gains

        force_rate = force_control_rate(
            self._inverse,
            [
                wanted - actual
                for wanted, actual in zip(desired[self._desired_wrench], contact, strict=True)
            ],
            desired[self._desired_rate],
            held_time_constant(time_constant, self._period),
        )
        level = (-self._leveling * phi_x, -self._leveling * phi_y, 0.0)
        grip = min(max(contact[2] / self._grip_force, 0.0), 1.0)
        blend = (grip * force_controlled, grip * force_controlled, force_controlled)
        w, w_dot = reference[self._w], reference[self._w_dot]
        for k, i in enumerate(_CONTROLLED):
            rate = modification_rate(
                force_rate[k], com_dynamics_rate[k], delta[k] - level[k], blend[k], position_gain
            )
            w[i] += delta[k]
            w_dot[i] += limited_rate(
                rate, delta[k], self._limits[k], self._rate_limits[k], self._period
            )
        output.set_value(w + w_dot)

    def _update(self, context, state):
        w_dot = self._command.Eval(context).tolist()[6:]
        ideal = self._reference.Eval(context).tolist()[self._w_dot]
        delta = self._modification.Eval(context).tolist()
        state.set_value(
            [delta[k] + self._period * (w_dot[i] - ideal[i]) for k, i in enumerate(_CONTROLLED)]
        )
