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
                                      + b (lambda_d' + e / delta + dlambda/dw Delta w_a')
                                      + (1 - b) D K_x (w_id - w)

where b goes from 0 (position) to 1 (force), and D, the diagonal of dlambda/dw, gives both kinds of
rows one unit. The other directions are position-controlled. Levelling, grip, the late foot and
limits are those of `FootForceControl`. That the CoM's dynamics may be added, as to the paper's law
(eq. 21), is ours: the predecessor had none.
"""

from collections.abc import Sequence

import numpy as np

from lola_drake.block import Block, Part, State, law
from lola_drake.blocks.foot_force_control import grip_of, limited_rate
from lola_drake.blocks.hybrid_force_control import HybridForceControlParams, held_time_constant
from lola_drake.blocks.inverse_kinematics import (
    RESOLUTION,
    InverseKinematicsParams,
    command_of,
    holding_torque,
    redundancy,
    resolved_rates,
    wished_rates,
)
from lola_drake.robot import PADS, Kinematics
from lola_drake.signals import (
    FEET,
    GAIT_PHASE,
    JOINT_ANGLES,
    PERIOD,
    TASK_REFERENCE,
    TORSO_ORIENTATION,
    Field,
    Signal,
)
from lola_drake.theory.contact_model import ServoCompliance
from lola_drake.theory.foot_wrench import FootSensor, wrench_at_tcp
from lola_drake.theory.kinematics import (
    FOOT_TASK,
    body_poses,
    com_motion,
    feet_motion,
    foot_task,
    pads_motion,
)
from lola_drake.theory.late_foot import TOUCHED, overdue_time, seeking_rate
from lola_drake.theory.pad_springs import (
    behind_servos,
    opened_by_servos,
    solved,
    spring_gradient,
)

OVERDUE = Signal(
    "overdue_feet",
    "How long each foot has been overdue on the ground; -1 once it has touched.",
    (Field("overdue", FEET, "s"),),
)
RIGID_HEIGHT_RATES = np.array([[pad.y, -pad.x, 1.0] for pad in PADS])
"""The heights of the pads' centres by a rigid foot's sin gamma_x, sin gamma_y and z."""


def foot_law(
    force_by_joints, force_by_task, task_by_joints, force_rate, deviation, blend, position_gain
):
    """Return the law of one foot's force-controlled directions, divided by D.

    Args:
        force_by_joints: d lambda / d q, shape (3, n).
        force_by_task: d lambda / d w, shape (3, 3).
        task_by_joints: the rows of J that belong to them, shape (3, n).
        force_rate: lambda_d' + e / delta, shape (3,).
        deviation: w - w_id, shape (3,).
        blend: b per direction, shape (3,).
        position_gain: K_x (1/s).

    Returns:
        Rows by the joint rates, shape (3, n), the same by the rates of the foot's task, shape
        (3, 3), and the right-hand side without w_id', shape (3,).
    """
    n = len(force_by_joints[0])
    rows, task_rows, drive = np.zeros((3, n)), np.zeros((3, 3)), np.zeros(3)
    for i in range(3):
        force, position = blend[i] / force_by_task[i][i], 1 - blend[i]
        for k in range(n):
            rows[i, k] = force * force_by_joints[i][k] + position * task_by_joints[i][k]
        for j in range(3):
            task_rows[i, j] = force * force_by_task[i][j]
        task_rows[i, i] += position
        drive[i] = force * force_rate[i] - position * position_gain * deviation[i]
    return rows, task_rows, drive


def commanded_foot(foot, joint_angles, tree):
    """Return w of one foot at the commanded joint angles, shape (6,), and its Jacobian (6, n)."""
    w, jacobian = foot_task(joint_angles, tree)
    first = FOOT_TASK * foot
    return w[first : first + FOOT_TASK], jacobian[first : first + FOOT_TASK]


def task_command(foot, joint_angles, joint_command, tree):
    """Return where the joint command takes one foot: w and its rate, shape (12,)."""
    w, jacobian = commanded_foot(foot, joint_angles, tree)
    n, command = len(joint_angles), np.zeros(2 * FOOT_TASK)
    for i in range(FOOT_TASK):
        command[i] = w[i]
        for k in range(n):
            command[FOOT_TASK + i] += jacobian[i, k] * joint_command[n + k]
    return command


def foot_wrench(foot, joint_angles, measured_wrench, tree, sensor):
    """Return lambda_f at the TCP, the foot being as it is commanded, shape (3,)."""
    w, _ = commanded_foot(foot, joint_angles, tree)
    measured = measured_wrench[6 * foot : 6 * foot + 6]
    return wrench_at_tcp(measured, w[3], w[4], w[5], sensor)


def foot_modification(foot, joint_angles, task_reference, tree):
    """Return Delta w of one foot (sin gamma_x, sin gamma_y, z), shape (3,)."""
    w, _ = commanded_foot(foot, joint_angles, tree)
    planned = task_reference[6 * foot : 6 * foot + 6]
    return w[3] - planned[3], w[4] - planned[4], w[2] - planned[2]


class ConfigurationForceControl(Block):
    """Turns both feet's force errors into joint commands.

    Its state is the commanded joint angles, and how long each foot has been overdue.
    """

    Params = HybridForceControlParams
    state = (State(JOINT_ANGLES, hidden=True), State(OVERDUE, hidden=True, start=TOUCHED))
    parts = {
        "support": Part(GAIT_PHASE, "support"),
        "blend": Part(GAIT_PHASE, "blend"),
        "load": Part(GAIT_PHASE, "load"),
        "phi": Part(TORSO_ORIENTATION, "phi"),
        "toes": Part(TASK_REFERENCE, "toes"),
        "toe_rates": Part(TASK_REFERENCE, "toe_rates"),
    }
    differentiable = False

    def __init__(
        self,
        params: HybridForceControlParams,
        ik_params: InverseKinematicsParams,
        kinematics: Kinematics,
        sensor: FootSensor,
        initial: np.ndarray,
        stiffness: float,
        compliances: Sequence[ServoCompliance],
    ):
        """Create the block.

        Args:
            params: gains and limits of the force control.
            ik_params: those of the inverse kinematics.
            kinematics: the controller's model.
            sensor: a foot below its force sensor.
            initial: joint angles at the start (rad), shape (24,); also the comfort pose.
            stiffness: vertical, of a foot's pads (N/m).
            compliances: of the servos that hold each foot.
        """
        areas = np.array([pad.area for pad in PADS])
        super().__init__(
            params,
            initial={JOINT_ANGLES.name: initial},
            tree=kinematics.tree,
            sensor=sensor,
            stiffness=stiffness * areas / areas.sum(),
            compliance=np.array([servos.matrix for servos in compliances]),
            relaxation=compliances[0].relaxation,
            **{name: getattr(ik_params, name) for name in RESOLUTION},
            **vars(redundancy(ik_params, kinematics, initial)),
        )

    @law
    def task_modification_l(joint_angles, task_reference, tree):
        """Return Delta w of the left foot."""
        return foot_modification(0, joint_angles, task_reference, tree)

    @law
    def task_modification_r(joint_angles, task_reference, tree):
        """Return Delta w of the right foot."""
        return foot_modification(1, joint_angles, task_reference, tree)

    @law
    def contact_wrench_l(joint_angles, measured_wrench, tree, sensor):
        """Return lambda_f of the left foot."""
        return foot_wrench(0, joint_angles, measured_wrench, tree, sensor)

    @law
    def contact_wrench_r(joint_angles, measured_wrench, tree, sensor):
        """Return lambda_f of the right foot."""
        return foot_wrench(1, joint_angles, measured_wrench, tree, sensor)

    @law
    def joint_command(
        joint_angles,
        overdue_feet,
        task_reference,
        desired_wrench,
        ideal_wrench,
        contact_wrench_l,
        contact_wrench_r,
        task_modification_l,
        task_modification_r,
        com_dynamics_rate_l,
        com_dynamics_rate_r,
        blend,
        load,
        phi,
        toes,
        toe_rates,
        time_constant,
        position_gain,
        grip_force,
        leveling,
        search_onset,
        search_ramp,
        search_speed,
        limits,
        rate_limits,
        stiffness,
        compliance,
        relaxation,
        tree,
        drift_correction,
        damping,
        comfort_gain,
        limit_gain,
        feedforward,
        horizontal_feedforward,
        comfort,
        lower,
        upper,
        mobility,
    ):
        """Return q, q' and the torque that is fed forward."""
        q, correction = joint_angles, drift_correction / PERIOD
        R, p, axes = body_poses(q, tree)
        com, com_rates = com_motion(R, p, axes, tree)
        w, jacobian = feet_motion(R, p, axes, com, com_rates, tree)
        rows, rates = jacobian.copy(), np.zeros(2 * FOOT_TASK)
        held = held_time_constant(time_constant)
        met = time_constant / (time_constant + relaxation)
        force_rate, deviation, degree = np.zeros(3), np.zeros(3), np.zeros(3)
        for foot in range(2):
            first = FOOT_TASK * foot
            wrench = contact_wrench_l if foot == 0 else contact_wrench_r
            delta = task_modification_l if foot == 0 else task_modification_r
            com_rate = com_dynamics_rate_l if foot == 0 else com_dynamics_rate_r
            grip = grip_of(wrench[2], grip_force)
            for i in range(3):
                error = desired_wrench[3 * foot + i] - wrench[i]
                force_rate[i] = desired_wrench[6 + 3 * foot + i] + error / held
                deviation[i] = delta[i] + (leveling * phi[i] if i < 2 else 0.0)
                degree[i] = blend[foot] * (grip if i < 2 else 1.0)
            points, height_rates = pads_motion(foot, R, p, axes, com, com_rates, tree)
            for pad in range(4):
                points[pad, 0] -= w[first]
                points[pad, 1] -= w[first + 1]
            controlled = (first + 3, first + 4, first + 2)
            task_by_joints = np.zeros((3, len(q)))
            for i in range(3):
                task_by_joints[i] = jacobian[controlled[i]]
            by_joints = spring_gradient(points, height_rates, stiffness)
            by_task = spring_gradient(points, RIGID_HEIGHT_RATES, stiffness)
            loop = opened_by_servos(by_task, compliance[foot], met)
            series = behind_servos(loop, by_task)
            for i in range(3):
                for j in range(3):
                    force_rate[i] += series[i, j] * com_rate[j]
            law_rows, task_rows, drive = foot_law(
                behind_servos(loop, by_joints),
                series,
                task_by_joints,
                force_rate,
                deviation,
                degree,
                position_gain,
            )
            change = solved(task_rows, drive)
            for i in range(FOOT_TASK):
                drift = task_reference[first + i] - w[first + i]
                rates[first + i] = task_reference[14 + first + i] + correction * drift
            task_rate = np.zeros(3)
            for i in range(3):
                rate = change[i]
                if i == 2:
                    rate = seeking_rate(
                        rate, overdue_feet[foot], search_onset, search_ramp, search_speed
                    )
                limited = limited_rate(rate, delta[i], limits[i], rate_limits[i])
                task_rate[i] = task_reference[14 + controlled[i]] + limited
            for i in range(3):
                rates[controlled[i]] = 0.0
                for j in range(3):
                    rates[controlled[i]] += task_rows[i, j] * task_rate[j]
                rows[controlled[i]] = law_rows[i]
        wish = wished_rates(
            *(q, comfort, lower, upper, comfort_gain, limit_gain, toes, toe_rates, correction)
        )
        joint_rates = resolved_rates(rows, rates, mobility, wish, damping)
        torque = holding_torque(
            *(jacobian, desired_wrench, ideal_wrench, load, feedforward, horizontal_feedforward)
        )
        return command_of(q, joint_rates, torque)

    @law
    def task_command_l(joint_angles, joint_command, tree):
        """Return w_mod of the left foot and its rate."""
        return task_command(0, joint_angles, joint_command, tree)

    @law
    def task_command_r(joint_angles, joint_command, tree):
        """Return w_mod of the right foot and its rate."""
        return task_command(1, joint_angles, joint_command, tree)

    @law
    def next_joint_angles(joint_command):
        """Return the commanded joint angles."""
        return joint_command[: len(joint_command) // 3]

    @law
    def next_overdue_feet(overdue_feet, support, contact):
        """Count how long the feet have been overdue."""
        left = contact[0] + contact[1] + contact[2] + contact[3]
        right = contact[4] + contact[5] + contact[6] + contact[7]
        return (
            overdue_time(overdue_feet[0], support[0], left),
            overdue_time(overdue_feet[1], support[1], right),
        )
