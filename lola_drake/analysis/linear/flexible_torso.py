"""A torso that is not rigid: one lightly damped mode between the pelvis and the IMU.

On the robot the controller gains had to be reduced because "structural vibrations" reached the
IMU (the paper's V.B). Here the upper body is carried by a spring and shaken by the pelvis: the IMU
sees the rigid motion through the transmissibility

    T(s) = (2 d w s + w^2) / (s^2 + 2 d w s + w^2),

for inclination and rate, about both axes; where the mode's shape reaches the IMU in part only, it
sees 1 + share (T - 1). What the vibration does to the legs is left out.
"""

from dataclasses import dataclass

import control
import numpy as np
from scipy.linalg import block_diag

from lola_drake.analysis.linear.bench import Bench
from lola_drake.signals import TORSO_ORIENTATION


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


def with_torso(bench: Bench, torso: FlexibleTorso | None) -> np.ndarray:
    """Return A of the whole loop with a rigid (None) or flexible torso.

    Args:
        bench: with `torso_orientation` among its inputs and outputs.
        torso: the mode.
    """
    if torso is None:
        return bench.blocks.interconnect([], []).A
    imu = bench.select(["torso_orientation"])
    rigid = bench.blocks.interconnect(imu, imu, imu)
    path = torso.path(bench.blocks.period)
    A, B, C, D = (
        block_diag(*[M] * TORSO_ORIENTATION.size) for M in (path.A, path.B, path.C, path.D)
    )
    return np.block([[rigid.A + rigid.B @ D @ rigid.C, rigid.B @ C], [B @ rigid.C, A]])
