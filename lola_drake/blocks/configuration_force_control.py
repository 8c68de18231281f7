"""Hybrid position/force control in configuration space: the predecessor [23] of the paper's law.

The contact is a set of decoupled springs at the pads' centres, behind the servos as in the paper's
law here. The gradient of the forces is taken with respect to the joint angles (eq. 9), so the
inverse kinematics is part of the force control.
The paper describes [23] in words; the equations here are our reading of them.

| paper          | here                                                       |
|----------------|------------------------------------------------------------|
| d lambda / d q | `spring_gradient()` of the pads' heights by the joints     |
| lambda_f       | `contact_wrench_l/r`, eq. 13                               |
| lambda_f,d     | `wrench_l/r` of `desired_wrench`                           |
| delta, K_x     | `time_constant`, `position_gain`                           |
| b_f            | `blend` of `gait_phase`                                    |
| w_mod, w_mod'  | `task_command_l/r`: where the joint command takes the feet |

The force-controlled directions of a foot are ruled by

    (b dlambda/dq + (1 - b) D J) q' = (b dlambda/dw + (1 - b) D) w_id'
                                      + b (lambda_d' + e / delta) + (1 - b) D K_x (w_id - w)

where b goes from 0 (position) to 1 (force), and D, the diagonal of dlambda/dw, gives both kinds of
rows one unit. The other directions are position-controlled. Levelling, grip, the late foot and
limits are those of `HybridForceControl`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from lola_drake.blocks.hybrid_force_control import (
    FORCE_CONTROLLED,
    TOUCHED,
    FootSensor,
    HybridForceControlParams,
    held_time_constant,
    limited_rate,
    overdue_time,
    seeking_rate,
    wrench_at_tcp,
)
from lola_drake.blocks.inverse_kinematics import InverseKinematicsParams, JointResolution
from lola_drake.robot import FOOT_TASK, PADS, Kinematics
from lola_drake.signals import (
    CONTACT,
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    GAIT_PHASE,
    JOINT_COMMAND,
    MEASURED_WRENCH,
    TASK_COMMAND,
    TASK_MODIFICATION,
    TASK_REFERENCE,
    TORSO_ORIENTATION,
)
from lola_drake.theory.contact_model import ServoCompliance

_BLEND, _SUPPORT = GAIT_PHASE.slice("blend").start, GAIT_PHASE.slice("support")
_FEET_RATES = slice(TASK_REFERENCE.slice("w_dot_l").start, TASK_REFERENCE.slice("w_dot_r").stop)
_RIGID_HEIGHT_RATES = np.array([[pad.y, -pad.x, 1.0] for pad in PADS])
"""The heights of the pads' centres by a rigid foot's sin gamma_x, sin gamma_y and z."""


def spring_gradient(
    points: np.ndarray, height_rates: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    """Return the gradient of T_x, T_y, F_z of decoupled springs under a foot.

    A spring gives dF = -c dz at its point, and with it dT_x = y dF and dT_y = -x dF; what the
    points' motion in the plane does to the torques is left out.

    Args:
        points: x and y of the springs relative to the TCP (m), shape (k, 2).
        height_rates: their heights by whatever moves them, shape (k, n).
        stiffness: c of each spring (N/m), shape (k,).

    Returns:
        The gradient by whatever moves the springs, shape (3, n).
    """
    x, y = points.T
    return -(np.array([y, -x, np.ones(len(x))]) * stiffness).dot(height_rates)


def share_of_contact(force_by_task: np.ndarray, compliance: np.ndarray) -> np.ndarray:
    """Return what a contact's gradients are multiplied with where servos give way behind it.

    S = (I - U C)^-1; S U is `command_gradient`.

    Args:
        force_by_task: U of the contact, d lambda / d w, shape (3, 3).
        compliance: C, the motion of the foot by its wrench, shape (3, 3).
    """
    return np.linalg.inv(np.eye(3) - force_by_task.dot(compliance))


@dataclass(frozen=True)
class FootLaw:
    """The law of one foot's force-controlled directions, divided by D.

    Attributes:
        rows: by the joint rates, shape (3, n).
        task_rows: the same by the rates of the foot's task, shape (3, 3).
        drive: the right-hand side without w_id', shape (3,).
    """

    rows: np.ndarray
    task_rows: np.ndarray
    drive: np.ndarray

    def modification_rate(self) -> np.ndarray:
        """Return Delta w', what the law adds to w_id'."""
        return np.linalg.solve(self.task_rows, self.drive)


def foot_law(
    force_by_joints: np.ndarray,
    force_by_task: np.ndarray,
    task_by_joints: np.ndarray,
    force_rate: np.ndarray,
    deviation: np.ndarray,
    blend: np.ndarray,
    position_gain: float,
) -> FootLaw:
    """Return the law of one foot.

    Args:
        force_by_joints: d lambda / d q, shape (3, n).
        force_by_task: d lambda / d w, shape (3, 3).
        task_by_joints: J, the task by the joints, shape (3, n).
        force_rate: lambda_d' + e / delta, shape (3,).
        deviation: w - w_id, shape (3,).
        blend: b per direction, shape (3,).
        position_gain: K_x (1/s).
    """
    force, position = blend / np.diag(force_by_task), 1 - blend
    return FootLaw(
        rows=force[:, None] * force_by_joints + position[:, None] * task_by_joints,
        task_rows=force[:, None] * force_by_task + np.diag(position),
        drive=force * force_rate - position * position_gain * deviation,
    )


class ConfigurationForceControl(LeafSystem):
    """Turns both feet's force errors into joint commands.

    The state is the commanded joint angles, and how long each foot has been overdue. The numeric
    parameter 0 holds delta and K_x.

    .. pydrake_system::

        name: ConfigurationForceControl
        input_ports:
        - task_reference
        - gait_phase
        - desired_wrench
        - measured_wrench
        - torso_orientation
        - contact
        output_ports:
        - joint_command
        - task_command_l
        - task_command_r
        - contact_wrench_l
        - contact_wrench_r
        - task_modification_l
        - task_modification_r
    """

    def __init__(
        self,
        params: HybridForceControlParams,
        ik_params: InverseKinematicsParams,
        kinematics: Kinematics,
        sensor: FootSensor,
        stiffness: float,
        compliances: Sequence[ServoCompliance],
        initial: np.ndarray,
        period: float,
    ):
        """Create the block.

        Args:
            params: gains and limits of the force control.
            ik_params: those of the inverse kinematics.
            kinematics: the controller's model; the block uses it alone.
            sensor: a foot below its force sensor.
            stiffness: vertical, of a foot's pads (N/m).
            compliances: of the servos that hold each foot.
            initial: joint angles at the start (rad), shape (24,); also the comfort pose.
            period: the control period (s).
        """
        super().__init__()
        self._params, self._sensor, self._period = params, sensor, period
        self._kinematics, self._known = kinematics, None
        self._resolution = JointResolution(ik_params, kinematics.position_limits, initial, period)
        areas = np.array([pad.area for pad in PADS])
        self._stiffness = stiffness * areas / areas.sum()
        self._compliances = compliances
        self._gains = self.DeclareNumericParameter(
            BasicVector([params.time_constant, params.position_gain])
        )
        state = self._state = self.DeclareDiscreteState(initial)
        self._overdue = self.DeclareDiscreteState(np.full(2, TOUCHED))
        self._reference = self.DeclareVectorInputPort("task_reference", TASK_REFERENCE.size)
        self._phase = self.DeclareVectorInputPort("gait_phase", GAIT_PHASE.size)
        self._desired = self.DeclareVectorInputPort("desired_wrench", DESIRED_WRENCH.size)
        self._measured = self.DeclareVectorInputPort("measured_wrench", MEASURED_WRENCH.size)
        self._orientation = self.DeclareVectorInputPort("torso_orientation", TORSO_ORIENTATION.size)
        self._switches = self.DeclareVectorInputPort("contact", CONTACT.size)
        own = {self.discrete_state_ticket(state)}
        sensing = own | {self._measured.ticket()}
        modifying = own | {self._reference.ticket()}
        everything = own | {
            port.ticket() for port in (self._reference, self._phase, self._desired, self._measured)
        }
        everything |= {self._orientation.ticket(), self.all_parameters_ticket()}
        everything |= {self.discrete_state_ticket(self._overdue)}
        self._command = self._declare(
            JOINT_COMMAND.name, JOINT_COMMAND.size, self._calc_joint_command, everything
        )
        for foot in FEET:
            self._declare(
                f"task_command_{foot}", TASK_COMMAND.size, self._task_command(foot), everything
            )
        self._contacts = [
            self._declare(
                f"contact_wrench_{foot}", CONTACT_WRENCH.size, self._contact_wrench(foot), sensing
            )
            for foot in FEET
        ]
        self._modifications = [
            self._declare(
                f"task_modification_{foot}",
                TASK_MODIFICATION.size,
                self._task_modification(foot),
                modifying,
            )
            for foot in FEET
        ]
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _declare(self, name: str, size: int, calc, prerequisites: set):
        return self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=prerequisites)

    def _joints(self, context) -> np.ndarray:
        return context.get_discrete_state(self._state).value()

    def _look(self, context) -> Kinematics:
        """Return the kinematics at the commanded joint angles."""
        q = self._joints(context)
        if self._known is None or not np.array_equal(q, self._known):
            self._kinematics.update(q)
            self._known = q.copy()
        return self._kinematics

    def _task_command(self, foot: str):
        own = _task(foot)

        def calc(context, output):
            q_dot = self._command.Eval(context)[JOINT_COMMAND.slice("q_dot")]
            kinematics = self._look(context)
            output.set_value([*kinematics.w[own], *kinematics.jacobian[own].dot(q_dot)])

        return calc

    def _contact_wrench(self, foot: str):
        first = MEASURED_WRENCH.slice(f"F_{foot}").start
        own = _task(foot)

        def calc(context, output):
            measured = self._measured.Eval(context)[first : first + 6].tolist()
            angles = self._look(context).w[own][3:].tolist()
            output.set_value(wrench_at_tcp(measured, angles, self._sensor))

        return calc

    def _task_modification(self, foot: str):
        own, planned = _task(foot), TASK_REFERENCE.slice(f"w_{foot}")

        def calc(context, output):
            deviation = self._look(context).w[own] - self._reference.Eval(context)[planned]
            output.set_value(deviation[FORCE_CONTROLLED])

        return calc

    def _calc_joint_command(self, context, output):
        reference, desired = self._reference.Eval(context), self._desired.Eval(context)
        kinematics, resolution = self._look(context), self._resolution
        rows, rates = kinematics.jacobian.copy(), reference[_FEET_RATES].copy()
        for foot, name in enumerate(FEET):
            controlled = FOOT_TASK * foot + FORCE_CONTROLLED
            law = self._foot_law(context, foot, kinematics, desired)
            task_rate = rates[controlled] + self._limited(context, foot, law)
            rates[_task(name)] += resolution.correction * (
                reference[TASK_REFERENCE.slice(f"w_{name}")] - kinematics.w[_task(name)]
            )
            rows[controlled], rates[controlled] = law.rows, law.task_rows.dot(task_rate)
        torque = resolution.holding_torque(kinematics.jacobian, desired)
        q = self._joints(context)
        output.set_value(resolution.command(q, rows, rates, reference, torque))

    def _foot_law(self, context, foot: int, kinematics: Kinematics, desired) -> FootLaw:
        time_constant, position_gain = context.get_numeric_parameter(self._gains).value().tolist()
        contact = self._contacts[foot].Eval(context)
        error = desired[DESIRED_WRENCH.slice(f"wrench_{FEET[foot]}")] - contact
        phi_x, phi_y = self._orientation.Eval(context)[:2].tolist()
        level = -self._params.leveling * np.array([phi_x, phi_y, 0.0])
        blend = self._phase.Eval(context).item(_BLEND + foot)
        grip = min(max(contact.item(2) / self._params.grip_force, 0.0), 1.0)
        points, height_rates = kinematics.pads(foot)
        by_task = spring_gradient(points, _RIGID_HEIGHT_RATES, self._stiffness)
        share = share_of_contact(by_task, self._compliances[foot].within(time_constant))
        return foot_law(
            force_by_joints=share.dot(spring_gradient(points, height_rates, self._stiffness)),
            force_by_task=share.dot(by_task),
            task_by_joints=kinematics.jacobian[FOOT_TASK * foot + FORCE_CONTROLLED],
            force_rate=desired[DESIRED_WRENCH.slice(f"rate_{FEET[foot]}")]
            + error / held_time_constant(time_constant, self._period),
            deviation=self._modifications[foot].Eval(context) - level,
            blend=np.array([blend * grip, blend * grip, blend]),
            position_gain=position_gain,
        )

    def _limited(self, context, foot: int, law: FootLaw) -> list[float]:
        rates = law.modification_rate().tolist()
        overdue = context.get_discrete_state(self._overdue).value().item(foot)
        params = self._params
        rates[2] = seeking_rate(
            rates[2], overdue, params.search_onset, params.search_ramp, params.search_speed
        )
        directions = zip(
            rates,
            self._modifications[foot].Eval(context).tolist(),
            self._params.limits().tolist(),
            self._params.rate_limits().tolist(),
            strict=True,
        )
        return [limited_rate(*direction, self._period) for direction in directions]

    def _update(self, context, state):
        state.set_value(self._state, self._command.Eval(context)[JOINT_COMMAND.slice("q")])
        overdue = context.get_discrete_state(self._overdue).value().tolist()
        planned = self._phase.Eval(context)[_SUPPORT].tolist()
        pads = self._switches.Eval(context).tolist()
        closed = sum(pads[:4]), sum(pads[4:])
        state.set_value(
            self._overdue,
            [
                overdue_time(late, support, switches, self._period)
                for late, support, switches in zip(overdue, planned, closed, strict=True)
            ],
        )


def _task(foot: str) -> slice:
    """Return where one foot's task lies in that of both."""
    first = FOOT_TASK * FEET.index(foot)
    return slice(first, first + FOOT_TASK)
