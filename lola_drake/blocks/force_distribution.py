"""Distribution of the wrench about the CoM to the two feet.

The paper refers to a heuristic of its predecessor [23]. This one follows what is known of it: the
vertical force by the planned load shares, then the torque that is left to the feet, within the
pads, and what they cannot give by a shift of the load. The numbers are our own.

| paper         | here                  |
|---------------|-----------------------|
| Lambda_mod    | `modified_wrench`     |
| lambda_f,d    | `wrench_l/r` of `desired_wrench` |
| d/dt of it    | `rate_l/r` of the same |
"""

from dataclasses import dataclass

from lola_drake.block import Block, Part, State, law
from lola_drake.parameters import parameter, validate
from lola_drake.signals import (
    DESIRED_WRENCH,
    GAIT_PHASE,
    IDEAL_WRENCH,
    PERIOD,
    TASK_REFERENCE,
    Signal,
)
from lola_drake.theory.scalars import exp


@dataclass(frozen=True)
class ForceDistributionParams:
    """Limits of the feet's torques, and the filter of the wrenches' rates."""

    cop_margin_x: float = parameter(
        0.09, "greatest distance of the desired CoP from the TCP, along x", "m", above=0
    )
    cop_margin_y: float = parameter(
        0.08, "greatest distance of the desired CoP from the TCP, along y", "m", above=0
    )
    least_force: float = parameter(
        20.0, "vertical force that a shift of the load leaves on a foot", "N", minimum=0
    )
    rate_filter: float = parameter(
        0.02, "time constant of the filter of the desired wrenches' rates", "s", above=0
    )

    def __post_init__(self):
        validate(self)


def distribute(modified, load, r_left, r_right, margin_x, margin_y, least_force):
    """Return lambda_d of both feet: T_x, T_y, F_z of the left, then of the right, shape (6,).

    Args:
        modified: Lambda_mod = [F, T] in T (N, Nm), shape (6,).
        load: shares of the left and right foot, shape (2,), of sum 1.
        r_left: left TCP relative to the CoM in T (m), x, y, z.
        r_right: the same of the right TCP.
        margin_x: greatest distance of a foot's desired CoP from its TCP along x (m).
        margin_y: the same along y.
        least_force: vertical force that a shift of the load leaves on a foot (N).
    """
    f_x, f_y, f_z = modified[0], modified[1], modified[2]
    left, right = load[0], load[1]
    x = left * r_left[0] + right * r_right[0]
    y = left * r_left[1] + right * r_right[1]
    z = left * r_left[2] + right * r_right[2]
    rest_x = modified[3] - (y * f_z - z * f_y)
    rest_y = modified[4] - (z * f_x - x * f_z)
    left_x, left_y, left_z = foot_wrench(left, f_z, rest_x, rest_y, margin_x, margin_y)
    right_x, right_y, right_z = foot_wrench(right, f_z, rest_x, rest_y, margin_x, margin_y)
    # What the feet cannot give by themselves, as far as the pads reach, a shift of the load gives.
    rest_x -= left_x + right_x
    rest_y -= left_y + right_y
    lever_x, lever_y = r_left[1] - r_right[1], r_right[0] - r_left[0]
    shift = (rest_x * lever_x + rest_y * lever_y) / (lever_x * lever_x + lever_y * lever_y)
    most = max(right_z - least_force, 0.0) if left > 0 else 0.0
    least = min(least_force - left_z, 0.0) if right > 0 else 0.0
    shift = min(max(shift, least), most)
    return left_x, left_y, left_z + shift, right_x, right_y, right_z - shift


def foot_wrench(share, f_z, rest_x, rest_y, margin_x, margin_y):
    """Return T_x, T_y, F_z that a foot takes by its share, its CoP within the margins."""
    force = share * f_z
    limit_x, limit_y = max(force, 0.0) * margin_y, max(force, 0.0) * margin_x
    return (
        min(max(share * rest_x, -limit_x), limit_x),
        min(max(share * rest_y, -limit_y), limit_y),
        force,
    )


def unplanned(desired, load, ideal_force):
    """Return the part of lambda_d that the plan does not make by itself.

    The pattern makes the planned load by letting the feet sink in. What is left is for the rates of
    eq. 15: the torques, the feedback of the CoM's height, and a shift of the load.

    Args:
        desired: T_x, T_y, F_z of the left and then the right foot (Nm, N), shape (6,).
        load: shares of the left and right foot, shape (2,).
        ideal_force: vertical force of Lambda_id (N).

    Returns:
        The same six, without the planned loads.
    """
    return (
        desired[0],
        desired[1],
        desired[2] - load[0] * ideal_force,
        desired[3],
        desired[4],
        desired[5] - load[1] * ideal_force,
    )


FILTERED = Signal(
    "filtered_wrench",
    "What of the desired wrenches the plan does not make, filtered.",
    DESIRED_WRENCH.fields[:2],
)


class ForceDistribution(Block):
    """Gives each foot its desired wrench and that wrench's rate.

    The rates are those of what is not planned, see `unplanned`. The state is the filtered wrench
    from which they are taken.
    """

    Params = ForceDistributionParams
    state = (State(FILTERED, hidden=True),)
    parts = {
        "load": Part(GAIT_PHASE, "load"),
        "ideal_force": Part(IDEAL_WRENCH, "F"),
        "r_left": Part(TASK_REFERENCE, "w_l"),
        "r_right": Part(TASK_REFERENCE, "w_r"),
    }

    @law
    def desired_wrench(
        modified_wrench,
        ideal_force,
        load,
        r_left,
        r_right,
        filtered_wrench,
        cop_margin_x,
        cop_margin_y,
        least_force,
        rate_filter,
    ):
        """Return lambda_d of both feet, and its rate, shape (12,)."""
        wrench = distribute(
            modified_wrench, load, r_left, r_right, cop_margin_x, cop_margin_y, least_force
        )
        now, before = unplanned(wrench, load, ideal_force[2]), filtered_wrench
        return (
            *wrench,
            (now[0] - before[0]) / rate_filter,
            (now[1] - before[1]) / rate_filter,
            (now[2] - before[2]) / rate_filter,
            (now[3] - before[3]) / rate_filter,
            (now[4] - before[4]) / rate_filter,
            (now[5] - before[5]) / rate_filter,
        )

    @law
    def next_filtered_wrench(filtered_wrench, desired_wrench, rate_filter):
        """Move the filter; exactly, for a wrench that is held over the period."""
        gain = rate_filter * (1 - exp(-PERIOD / rate_filter))
        old, rate = filtered_wrench, desired_wrench
        return (
            old[0] + gain * rate[6],
            old[1] + gain * rate[7],
            old[2] + gain * rate[8],
            old[3] + gain * rate[9],
            old[4] + gain * rate[10],
            old[5] + gain * rate[11],
        )
