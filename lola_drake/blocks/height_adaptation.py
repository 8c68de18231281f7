"""CoM height adaptation: what force control had to add to the feet's heights becomes the plan's.

A loaded foot that found the ground lower than planned has a modification Delta z < 0, and so has
the next one, if the plan goes on expecting the ground where it is not. The idea is Sygulla and
Rixen's (2020); the law is our own:

| here            | law                                                                            |
|-----------------|--------------------------------------------------------------------------------|
| s               | sum of eta_f Delta z_f, eta_f the planned loads                                |
| `height_rate`   | Delta h' = sat(-s / `TIME_CONSTANT`, +-`FASTEST`), within `REACH`              |
| bumpless        | w_id,z - Delta h and Delta z_f + Delta h: what a foot is commanded stays       |
| the next plan   | brings the CoM back to its height above the ground as it was found             |

The plan's own ground stays where it was, so that the pendulum's height is wrong by Delta h in it.
"""

from typing import ClassVar

import numpy as np

from lola_drake.block import Block, State, law
from lola_drake.blocks.adaptive_walking_pattern import AdaptiveWalkingPattern
from lola_drake.blocks.foot_force_control import FootForceControl
from lola_drake.blocks.walking_pattern import ENDS
from lola_drake.signals import (
    FEET,
    GAIT_PHASE,
    PERIOD,
    TASK_REFERENCE,
    Field,
    Signal,
)

TIME_CONSTANT = 0.3
"""With which the plan takes over what the feet have added (s)."""

FASTEST = 0.1
"""Greatest rate of Delta h (m/s)."""

REACH = (0.76, 0.92)
"""Least and greatest height of the CoM over the feet (m): the knee is bent, and not stretched."""

LIFT = Signal(
    "com_lift",
    "Delta h, by how much the feet are let down against the plan.",
    (Field("lift", ("",), "m", "T"),),
)

HEIGHT_RATE = Signal(
    "height_rate",
    "Delta h', its rate.",
    (Field("rate", ("",), "m/s", "T"),),
)

HEIGHTS = [TASK_REFERENCE.slice(f"w_{foot}").start + 2 for foot in FEET]
HEIGHT_RATES = [TASK_REFERENCE.slice(f"w_dot_{foot}").start + 2 for foot in FEET]


def lift_rate(load: np.ndarray, added: np.ndarray, lift: float, com_height: float) -> float:
    """Return Delta h' (m/s).

    Args:
        load: planned shares of the left and the right foot, shape (2,).
        added: Delta z of both feet (m), shape (2,).
        lift: Delta h (m).
        com_height: of the plan (m).
    """
    rate = min(max(-float(load @ added) / TIME_CONSTANT, -FASTEST), FASTEST)
    least, most = (height - com_height - lift for height in REACH)
    return max(min(rate, most / PERIOD), least / PERIOD)


class HeightAdaptivePattern(AdaptiveWalkingPattern):
    """Lets the feet of the plan down or up to where they found the ground."""

    signals: ClassVar[tuple[Signal, ...]] = (HEIGHT_RATE,)
    state: ClassVar[tuple[Signal | State, ...]] = (
        *AdaptiveWalkingPattern.state,
        State(LIFT, hidden=True),
        HEIGHT_RATE,
    )

    def next_state(
        self,
        time,
        request,
        contact,
        walk_command,
        phi,
        phi_dot,
        foothold_shift,
        com_lift,
        height_rate,
        gait_phase,
        task_modification_l,
        task_modification_r,
    ):
        """Return what the walking pattern returns, with lowered feet, and Delta h with its rate."""
        lift = com_lift[0] + PERIOD * height_rate[0]
        rows = self.advanced(
            time, request, contact, walk_command, phi, phi_dot, foothold_shift, lift
        )
        added = np.array([task_modification_l[2], task_modification_r[2]])
        load = gait_phase[GAIT_PHASE.slice("load")]
        rate = lift_rate(load, added + PERIOD * height_rate[0], lift, self.params.com_height)
        task = rows[ENDS[0] : ENDS[1]]
        task[HEIGHTS] -= lift
        task[HEIGHT_RATES] -= rate
        return np.concatenate([rows, [lift, rate]])


_task_command = FootForceControl.laws["task_command"]


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
    height_rate,
):
    """Return w_mod and its rate, shape (12,): what the plan lets down, Delta z takes back."""
    w = _task_command(
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
    )
    rate_z = w[8] + height_rate[0]
    return w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], rate_z, w[9], w[10], w[11]


def bumpless(force_law: type[Block]) -> type[Block]:
    """Return a law of a foot's force that takes back what the plan is changed by."""
    declared = {
        "task_command": law(task_command),
        "signals": (*force_law.signals, HEIGHT_RATE),
        "__doc__": force_law.__doc__,
        "__module__": force_law.__module__,
    }
    return type(force_law.__name__, (force_law,), declared)
