"""The paper's force law with its outlook built: the sensed contact area, and no small angles.

Two switches, each for itself, make of eq. 15

    C (U(t) - ...) w' = lambda_d' + (lambda_d - lambda) / delta

* `sensed_area`: U(t) is that of the pads whose switches are closed. In directions that keep little
  of a foot's stiffness a loaded foot goes on as by U of all pads, and so turns until the open ones
  find the ground; one without load is position-controlled there. The servos in series do not yield
  less where pads are open.
* `exact_angles`: eq. 13 with the foot's whole rotation, eq. 6 with the cosines, the torso's
  inclination within the foot's, and torques and angles of a turned foot about the same axes.

The paper names both as its outlook; the equations are ours, see `lola_drake.theory.sensed_contact`.
"""

import numpy as np

from lola_drake.block import State, law
from lola_drake.blocks.foot_force_control import grip_of
from lola_drake.blocks.hybrid_force_control import (
    HybridForceControl,
    force_control_rate,
    held_time_constant,
    inverse_gradient,
    wrench_error,
)
from lola_drake.signals import CONTACT, PERIOD, Field, Signal
from lola_drake.theory.foot_wrench import wrench_at_tcp
from lola_drake.theory.sensed_contact import (
    RAMP,
    behind_servos,
    foot_axes,
    inclined,
    safe_motion,
    sensed_gradient,
    turned,
)

PAD_SHARE = Signal(
    "pad_share",
    "How far each pad of the foot counts as in contact.",
    (Field("share", CONTACT.fields[0].entries, "-"),),
)


def exact_wrench_at_tcp(measured, axes, sensor):
    """Return lambda_f = A_TF lambda_f,m (eq. 13) for any rotation of the foot.

    Args:
        measured: [F, T] of the sensor in its own frame (N, Nm), shape (6,).
        axes: x and y axes of the foot in T, shape (2, 3).
        sensor: geometry and weight below the sensor, a `FootSensor`.
    """
    e_x, e_y = axes
    e_z = (
        e_x[1] * e_y[2] - e_x[2] * e_y[1],
        e_x[2] * e_y[0] - e_x[0] * e_y[2],
        e_x[0] * e_y[1] - e_x[1] * e_y[0],
    )
    f_x, f_y, f_z = measured[0], measured[1], measured[2]
    x, y, z = sensor.p_TcpSensor[0], sensor.p_TcpSensor[1], sensor.p_TcpSensor[2]
    t_x = measured[3] + (y * f_z - z * f_y)
    t_y = measured[4] + (z * f_x - x * f_z)
    t_z = measured[5] + (x * f_y - y * f_x)
    x, y, z = sensor.p_TcpFoot[0], sensor.p_TcpFoot[1], sensor.p_TcpFoot[2]
    p_x = x * e_x[0] + y * e_y[0] + z * e_z[0]
    p_y = x * e_x[1] + y * e_y[1] + z * e_z[1]
    return (
        t_x * e_x[0] + t_y * e_y[0] + t_z * e_z[0] + sensor.weight * p_y,
        t_x * e_x[1] + t_y * e_y[1] + t_z * e_z[1] - sensor.weight * p_x,
        f_x * e_x[2] + f_y * e_y[2] + f_z * e_z[2] + sensor.weight,
    )


class SensedForceControl(HybridForceControl):
    """Lets the force error die out as delta e' + e = 0 (eq. 14), for the contact as it is sensed.

    Its state has, besides, how far each pad counts as in contact.
    """

    signals = (PAD_SHARE,)
    state = (*HybridForceControl.state, State(PAD_SHARE, hidden=True, start=1.0))
    differentiable = False

    @law
    def force_rate(
        wrench,
        wrench_rate,
        contact_wrench,
        w_id,
        phi,
        task_modification,
        pad_share,
        time_constant,
        position_gain,
        leveling,
        grip_force,
        inverse_contact_matrix,
        compliance,
        relaxation,
        sensed_area,
        exact_angles,
        sole,
    ):
        """Return w_f' of eq. 15 with the gradient of the contact as it is."""
        delta, yaw, tilt, lean = task_modification, 0.0, (0.0, 0.0), (phi[0], phi[1])
        if exact_angles:
            yaw = w_id[5]
            tilt = inclined(foot_axes(w_id[3] + delta[0], w_id[4] + delta[1], yaw), phi)
            about_x, about_y, _ = turned((phi[0], phi[1], 0.0), yaw)
            lean = (about_x, about_y)
        felt, wanted = turned(contact_wrench, yaw), turned(wrench, yaw)
        rates, held = turned(wrench_rate, yaw), held_time_constant(time_constant)
        whole = inverse_gradient(inverse_contact_matrix, compliance, relaxation, time_constant)
        seeking = force_control_rate(whole, wrench_error(wanted, felt), rates, held)
        grip = grip_of(felt[2], grip_force)
        drive, free = np.zeros(3), np.zeros(3)
        for i in range(3):
            drive[i] = rates[i] + (wanted[i] - felt[i]) / held
            if i < 2:
                drive[i] /= np.sqrt(max(1 - tilt[i] * tilt[i], 1e-6))
            level = -position_gain * (delta[i] + (leveling * lean[i] if i < 2 else 0.0))
            free[i] = level + grip * (seeking[i] - level)
        met = np.zeros((3, 3))
        for i in range(3):
            for j in range(3):
                met[i, j] = compliance[i][j] * time_constant / (time_constant + relaxation)
        gradient = behind_servos(sensed_gradient(pad_share, sole, tilt, felt), met)
        return safe_motion(gradient, drive, free, sole)

    @law
    def grip(contact_wrench, grip_force, sensed_area):
        """Return how far the foot's torques are controlled; the sensed area says it by itself."""
        return (1.0 if sensed_area else grip_of(contact_wrench[2], grip_force),)

    @law
    def contact_wrench(measured, w_id, task_modification, exact_angles, sensor):
        """Return lambda_f at the TCP, the foot being as it is commanded."""
        s_x, s_y = w_id[3] + task_modification[0], w_id[4] + task_modification[1]
        if exact_angles:
            return exact_wrench_at_tcp(measured, foot_axes(s_x, s_y, w_id[5]), sensor)
        return wrench_at_tcp(measured, s_x, s_y, w_id[5], sensor)

    @law
    def next_pad_share(pad_share, pads, sensed_area):
        """Let each pad count more while its switch is closed, and less while it is open."""
        following = np.ones(4)
        if sensed_area:
            for pad in range(4):
                step = PERIOD / RAMP if pads[pad] > 0.5 else -PERIOD / RAMP
                following[pad] = min(max(pad_share[pad] + step, 0.0), 1.0)
        return following
