"""A torso that is not rigid: one lightly damped mode between the pelvis and the IMU.

On the robot the controller gains had to be reduced because "structural vibrations" reached the
IMU (the paper's V.B). Here the upper body is carried by a spring and shaken by the pelvis: the IMU
sees the rigid motion through the transmissibility

    T(s) = (2 d w s + w^2) / (s^2 + 2 d w s + w^2),

for inclination and rate, about both axes; where the mode's shape reaches the IMU in part only, it
sees 1 + share (T - 1). What the vibration does to the legs is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import control
import numpy as np
from scipy.linalg import block_diag

from lola_drake.linear.interconnection import Matrices
from lola_drake.linear.studies.workpoint import Workpoint
from lola_drake.linear.wiring import Selection
from lola_drake.signals import PERIOD, TORSO_ORIENTATION


@dataclass(frozen=True)
class FlexibleTorso:
    """The mode.

    Attributes:
        frequency: undamped (Hz).
        damping: ratio.
        share: part of the mode that reaches the IMU.
    """

    frequency: float = 12.0
    damping: float = 0.05
    share: float = 1.0

    def path(self, period: float) -> control.StateSpace:
        """Return what the IMU sees of the rigid motion, sampled with a hold."""
        w = 2 * np.pi * self.frequency
        numerator, denominator = [2 * self.damping * w, w * w], [1, 2 * self.damping * w, w * w]
        T = control.ss(control.c2d(control.tf(numerator, denominator), period, "zoh"))
        return control.ss(T.A, T.B, self.share * T.C, self.share * T.D + 1 - self.share, period)


def with_torso(
    workpoint: Workpoint, torso: FlexibleTorso | None, opened: Sequence[Selection] = ()
) -> Matrices:
    """Return the whole loop with a rigid (None) or flexible torso.

    Args:
        workpoint: with `torso_orientation` among its inputs and outputs.
        torso: the mode.
        opened: other signals that are cut, as inputs and outputs of the result.
    """
    if torso is None:
        return workpoint.blocks.interconnect(opened, opened, opened)
    imu = workpoint.select(["torso_orientation"])
    cut = [*opened, *imu]
    rigid = workpoint.blocks.interconnect(cut, cut, cut)
    # The IMU holds its output for a tick, so nothing acts on it at once.
    n = rigid.B.shape[1] - TORSO_ORIENTATION.size
    B, B_imu, C, C_imu = rigid.B[:, :n], rigid.B[:, n:], rigid.C[:n], rigid.C[n:]
    D, D_imu = rigid.D[:n, :n], rigid.D[:n, n:]
    path = torso.path(PERIOD)
    Ap, Bp, Cp, Dp = (
        block_diag(*[M] * TORSO_ORIENTATION.size) for M in (path.A, path.B, path.C, path.D)
    )
    return Matrices(
        np.block([[rigid.A + B_imu @ Dp @ C_imu, B_imu @ Cp], [Bp @ C_imu, Ap]]),
        np.vstack([B, np.zeros((len(Ap), n))]),
        np.hstack([C + D_imu @ Dp @ C_imu, D_imu @ Cp]),
        D,
    )
