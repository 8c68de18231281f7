"""What a force sensor says about the wrench at the TCP (eq. 13)."""

from collections.abc import Sequence
from typing import NamedTuple

from lola_drake.theory.scalars import cos, sin


class FootSensor(NamedTuple):
    """What the controller knows about one foot below its force sensor.

    Attributes:
        p_TcpSensor: the sensor relative to the TCP, in the foot frame F (m).
        weight: weight of the foot below the sensor (N).
        p_TcpFoot: its CoM relative to the TCP, in F (m).
    """

    p_TcpSensor: Sequence[float]
    weight: float
    p_TcpFoot: Sequence[float]


def wrench_at_tcp(measured, s_x, s_y, yaw, sensor):
    """Return lambda_f = A_TF lambda_f,m (eq. 13), freed of the foot's own weight.

    Args:
        measured: [F, T] of the sensor in its own frame (N, Nm), shape (6,).
        s_x: the foot's sin gamma_x in T.
        s_y: its sin gamma_y.
        yaw: its gamma_z (rad).
        sensor: geometry and weight below the sensor, a `FootSensor`.

    Returns:
        T_x, T_y (Nm), F_z (N) at the TCP in T, shape (3,).
    """
    f_x, f_y, f_z = measured[0], measured[1], measured[2]
    x, y, z = sensor.p_TcpSensor[0], sensor.p_TcpSensor[1], sensor.p_TcpSensor[2]
    t_x = measured[3] + (y * f_z - z * f_y)
    t_y = measured[4] + (z * f_x - x * f_z)
    t_z = measured[5] + (x * f_y - y * f_x)
    # R_TF for independent small rotations: the third row is (-sin gamma_y, sin gamma_x, cos).
    c, s = cos(yaw), sin(yaw)
    lean_x, lean_y = c * s_y + s * s_x, s * s_y - c * s_x
    x, y = sensor.p_TcpFoot[0], sensor.p_TcpFoot[1]
    return (
        c * t_x - s * t_y + lean_x * t_z + sensor.weight * (s * x + c * y),
        s * t_x + c * t_y + lean_y * t_z - sensor.weight * (c * x - s * y),
        -s_y * f_x + s_x * f_y + f_z + sensor.weight,
    )
