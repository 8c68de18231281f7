"""Damping control of one foot: a rival of the paper's law that knows no contact model.

    Delta gamma' = -(T_d - T) / D - Delta gamma / T_s
    Delta z'     = -/+ (1/2) ((F_l,d - F_r,d) - (F_l - F_r)) / D_z - Delta z / T_s

Source: Kajita et al., "Biped walking stabilization based on linear inverted pendulum tracking"
(IROS 2010), from memory: the feet's torques by their ankles, and the difference of their forces by
the difference of their heights, as long as both are to carry. In single support nothing controls
the vertical force there. Ours: signs and frames, that each foot's height returns by itself (of
both, the source's difference returns alike), and all
numbers, which `lola tune --law damping` chose.
"""

from dataclasses import dataclass

from lola_drake.block import law
from lola_drake.blocks.foot_force_control import FootForceControl
from lola_drake.parameters import parameter, validate
from lola_drake.signals import DESIRED_WRENCH, GAIT_PHASE, MEASURED_WRENCH

SUPPORT = GAIT_PHASE.slice("support").start
WANTED = tuple(DESIRED_WRENCH.slice(f"wrench_{foot}").start + 2 for foot in "lr")
FELT = tuple(MEASURED_WRENCH.slice(f"F_{foot}").start + 2 for foot in "lr")


@dataclass(frozen=True)
class DampingForceControlParams:
    """The dampers between a foot's plan and its wrench."""

    torque_damping: float = parameter(
        18.6,
        "D, torque error per angular velocity of a foot",
        "Nms/rad",
        minimum=0.1,
        maximum=1e4,
        symbol="D",
        slider=(5, 200, 1),
    )
    force_damping: float = parameter(
        2560.0,
        "D_z, difference of the force errors per velocity that parts the feet",
        "Ns/m",
        minimum=10,
        maximum=1e6,
        symbol="D_z",
        slider=(500, 20000, 100),
    )
    decay_time: float = parameter(
        1.6,
        "T_s, return of a foot to its plan",
        "s",
        minimum=0.01,
        maximum=100,
        symbol="T_s",
        slider=(0.1, 5, 0.1),
    )

    def __post_init__(self):
        validate(self)


def damping_rate(error, damping, deviation, decay_time):
    """Return the rate of one direction of Delta w.

    Args:
        error: desired minus measured (N or Nm).
        damping: D, or D_z.
        deviation: Delta w in this direction.
        decay_time: T_s (s).
    """
    return -error / damping - deviation / decay_time


def force_difference(desired_wrench, measured_wrench, gait_phase, foot):
    """Return by how much half the difference of both feet's vertical forces is too small (N).

    Seen from one foot; 0 unless both feet are planned to carry. The weight below the sensors falls
    out of the difference.
    """
    if gait_phase[SUPPORT] < 0.5 or gait_phase[SUPPORT + 1] < 0.5:
        return 0.0
    wanted = desired_wrench[WANTED[0]] - desired_wrench[WANTED[1]]
    felt = measured_wrench[FELT[0]] - measured_wrench[FELT[1]]
    return (0.5 - foot) * (wanted - felt)


class DampingForceControl(FootForceControl):
    """Yields to one foot's force error like a damper, without a contact model."""

    Params = DampingForceControlParams

    @law
    def force_rate(
        wrench,
        contact_wrench,
        desired_wrench,
        measured_wrench,
        gait_phase,
        task_modification,
        torque_damping,
        force_damping,
        decay_time,
        foot,
    ):
        """Return the rates of the foot's angles and height."""
        delta = task_modification
        e_z = force_difference(desired_wrench, measured_wrench, gait_phase, foot)
        return (
            damping_rate(wrench[0] - contact_wrench[0], torque_damping, delta[0], decay_time),
            damping_rate(wrench[1] - contact_wrench[1], torque_damping, delta[1], decay_time),
            damping_rate(e_z, force_damping, delta[2], decay_time),
        )
