"""What all laws of one foot's force share: where the foot is taken, and what a law has no say in.

A force law gives the rate that it wants of the foot, `force_rate`. Here it is blended with the
position control of the swing (the paper's eq. 16), the CoM's dynamics are added (eq. 21), a late
foot seeks the ground, and all is limited and integrated (eq. 10 and 11).

| paper          | here                               |
|----------------|------------------------------------|
| lambda_f,m     | `measured_wrench`                  |
| A_TF           | `theory.foot_wrench`, eq. 13       |
| lambda_f       | `contact_wrench`                   |
| K_x            | `position_gain`                    |
| b_f            | `blend` of `gait_phase`            |
| Delta w_a,f'   | `com_dynamics_rate`                |
| Delta w'       | `modification_rate()`, eq. 16, 21  |
| w_mod, w_mod'  | `task_command`, eq. 10 and 11      |

The paper says nothing of a foot that finds no ground where it is planned; that it seeks it
(`theory.late_foot`) is our own choice.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lola_drake.block import Block, Part, State, law
from lola_drake.parameters import parameter, validate
from lola_drake.signals import (
    CONTACT,
    DESIRED_WRENCH,
    GAIT_PHASE,
    MEASURED_WRENCH,
    PERIOD,
    TASK_MODIFICATION,
    TASK_REFERENCE,
    TORSO_ORIENTATION,
    Field,
    Signal,
)
from lola_drake.theory.foot_wrench import wrench_at_tcp
from lola_drake.theory.late_foot import TOUCHED, overdue_time, seeking_rate

FORCE_CONTROLLED = np.array([3, 4, 2])
"""S_c,f of eq. 12: sin gamma_x, sin gamma_y and z within a foot's task."""

OVERDUE = Signal(
    "overdue",
    "How long a foot has been overdue on the ground; -1 once it has touched.",
    (Field("overdue", ("",), "s"),),
)
FORCE_RATE = Signal(
    "force_rate",
    "What the force law wants: the rate of the foot's force-controlled directions.",
    (Field("rate", ("sin_gamma_x", "sin_gamma_y", "z"), ("1/s", "1/s", "m/s"), "T"),),
)
GRIP = Signal(
    "grip",
    "How far a foot's torques are controlled, 0 for one without load.",
    (Field("grip", ("",), "-"),),
)


@dataclass(frozen=True)
class FootForceControlParams:
    """What is the same for all force laws: swing, search for the ground, limits."""

    position_gain: float = parameter(
        6.0,
        "K_x, return of the swing foot to the plan",
        "1/s",
        minimum=0,
        maximum=500,
        symbol="K_x",
        slider=(0, 50, 0.5),
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
    search_speed: float = parameter(
        0.25,
        "least speed at which a late foot seeks the ground, 0 for none",
        "m/s",
        minimum=0,
        maximum=1,
    )
    search_onset: float = parameter(
        0.03, "how long after its planned touchdown a foot is late", "s", minimum=0, maximum=1
    )
    search_ramp: float = parameter(
        0.05, "duration in which the search reaches its speed", "s", minimum=0.001, maximum=1
    )
    max_height: float = parameter(
        0.08, "limit of the foot's height modification", "m", above=0, maximum=0.3
    )
    max_height_rate: float = parameter(0.5, "limit of its rate", "m/s", above=0, maximum=5)
    max_angle: float = parameter(
        0.4, "limit of the foot's angle modification", "rad", above=0, maximum=0.8
    )
    max_angle_rate: float = parameter(2.0, "limit of its rate", "rad/s", above=0, maximum=20)

    def __post_init__(self):
        validate(self)

    @property
    def limits(self) -> np.ndarray:
        """Return the limits of Delta w (sin gamma_x, sin gamma_y, z), shape (3,)."""
        return np.array([self.max_angle, self.max_angle, self.max_height])

    @property
    def rate_limits(self) -> np.ndarray:
        """Return the limits of its rate, shape (3,)."""
        return np.array([self.max_angle_rate, self.max_angle_rate, self.max_height_rate])


def grip_of(force, grip_force):
    """Return how far a foot's torques are controlled, from 0 without load to 1 (own choice).

    Args:
        force: F_z on the foot (N).
        grip_force: from which on they wholly are (N).
    """
    return min(max(force / grip_force, 0.0), 1.0)


def modification_rate(force_rate, com_dynamics_rate, deviation, blend, position_gain):
    """Return one entry of Delta w' (eq. 16 and 21).

    Args:
        force_rate: w_f' of eq. 15.
        com_dynamics_rate: Delta w_a,f' of eq. 20.
        deviation: w - w_id in this direction.
        blend: b_f, 1 for force control and 0 for position control.
        position_gain: K_x (1/s).
    """
    return blend * (force_rate + com_dynamics_rate) - (1 - blend) * position_gain * deviation


def limited_rate(rate, deviation, limit, rate_limit):
    """Return the rate of one direction of Delta w, which ends where Delta w reaches its limit."""
    rate = min(max(rate, -rate_limit), rate_limit)
    return max(min(rate, (limit - deviation) / PERIOD), (-limit - deviation) / PERIOD)


class FootForceControl(Block):
    """Turns one foot's force error into a modification of its trajectory; a law gives `force_rate`.

    Its state is Delta w, the modification of sin gamma_x, sin gamma_y and z, and how long the foot
    has been overdue.
    """

    Params: ClassVar[type] = FootForceControlParams
    signals: ClassVar[tuple[Signal, ...]] = (FORCE_RATE, GRIP)
    state: ClassVar[tuple[Signal | State, ...]] = (
        TASK_MODIFICATION,
        State(OVERDUE, hidden=True, start=TOUCHED),
    )
    parts = {
        "w_id": Part(TASK_REFERENCE, "w"),
        "w_dot_id": Part(TASK_REFERENCE, "w_dot"),
        "blend": Part(GAIT_PHASE, "blend"),
        "support": Part(GAIT_PHASE, "support"),
        "pads": Part(CONTACT, "pads"),
        "wrench": Part(DESIRED_WRENCH, "wrench"),
        "wrench_rate": Part(DESIRED_WRENCH, "rate"),
        "measured": Part(MEASURED_WRENCH, ("F", "T")),
        "phi": Part(TORSO_ORIENTATION, "phi"),
    }

    @law
    def task_command(
        w_id,
        w_dot_id,
        blend,
        force_rate,
        grip,
        com_dynamics_rate,
        phi,
        task_modification,
        overdue,
        position_gain,
        leveling,
        search_onset,
        search_ramp,
        search_speed,
        limits,
        rate_limits,
    ):
        """Return w_mod and its rate, shape (12,)."""
        delta = task_modification
        rate_x = modification_rate(
            force_rate[0],
            com_dynamics_rate[0],
            delta[0] + leveling * phi[0],
            grip[0] * blend,
            position_gain,
        )
        rate_y = modification_rate(
            force_rate[1],
            com_dynamics_rate[1],
            delta[1] + leveling * phi[1],
            grip[0] * blend,
            position_gain,
        )
        rate_z = modification_rate(
            force_rate[2], com_dynamics_rate[2], delta[2], blend, position_gain
        )
        rate_z = seeking_rate(rate_z, overdue[0], search_onset, search_ramp, search_speed)
        return (
            w_id[0],
            w_id[1],
            w_id[2] + delta[2],
            w_id[3] + delta[0],
            w_id[4] + delta[1],
            w_id[5],
            w_dot_id[0],
            w_dot_id[1],
            w_dot_id[2] + limited_rate(rate_z, delta[2], limits[2], rate_limits[2]),
            w_dot_id[3] + limited_rate(rate_x, delta[0], limits[0], rate_limits[0]),
            w_dot_id[4] + limited_rate(rate_y, delta[1], limits[1], rate_limits[1]),
            w_dot_id[5],
        )

    @law
    def grip(contact_wrench, grip_force):
        """Return how far the foot's torques are controlled."""
        return (grip_of(contact_wrench[2], grip_force),)

    @law
    def contact_wrench(measured, w_id, task_modification, sensor):
        """Return lambda_f at the TCP, the foot being as it is commanded."""
        s_x, s_y = w_id[3] + task_modification[0], w_id[4] + task_modification[1]
        return wrench_at_tcp(measured, s_x, s_y, w_id[5], sensor)

    @law
    def next_task_modification(task_modification, task_command, w_dot_id):
        """Integrate Delta w' over one period (eq. 11)."""
        return (
            task_modification[0] + PERIOD * (task_command[9] - w_dot_id[3]),
            task_modification[1] + PERIOD * (task_command[10] - w_dot_id[4]),
            task_modification[2] + PERIOD * (task_command[8] - w_dot_id[2]),
        )

    @law
    def next_overdue(overdue, support, pads):
        """Count how long the foot has been overdue."""
        return (overdue_time(overdue[0], support, pads[0] + pads[1] + pads[2] + pads[3]),)
