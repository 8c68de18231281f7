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

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

from lola_drake.blocks.scalars import AlgebraicSystem, convertible
from lola_drake.parameters import parameter, validate
from lola_drake.signals import DESIRED_WRENCH, FEET, GAIT_PHASE, MODIFIED_WRENCH, TASK_REFERENCE

_LOAD = GAIT_PHASE.slice("load")
_LEFT, _RIGHT = (TASK_REFERENCE.slice(f"w_{foot}", 3) for foot in FEET)


@dataclass(frozen=True)
class ForceDistributionParams:
    """Limits of the feet's torques, and the filter of the wrenches' rates."""

    cop_margin_x: float = parameter(
        0.09,
        "greatest distance of the desired CoP from the TCP, along x",
        "m",
        above=0,
        maximum=0.135,
    )
    cop_margin_y: float = parameter(
        0.08,
        "greatest distance of the desired CoP from the TCP, along y",
        "m",
        above=0,
        maximum=0.11,
    )
    least_force: float = parameter(
        20.0,
        "vertical force that a shift of the load leaves on a foot",
        "N",
        minimum=0,
        maximum=300,
    )
    rate_filter: float = parameter(
        0.02,
        "time constant of the filter of the desired wrenches' rates",
        "s",
        minimum=0.001,
        maximum=1,
    )

    def __post_init__(self):
        validate(self)


def distribute(
    modified: Sequence[float],
    load: Sequence[float],
    r_left: Sequence[float],
    r_right: Sequence[float],
    margin_x: float,
    margin_y: float,
    least_force: float,
) -> list[float]:
    """Return lambda_d of the left and right foot.

    Args:
        modified: Lambda_mod = [F, T] in T (N, Nm), shape (6,).
        load: shares of the left and right foot, shape (2,), of sum 1.
        r_left: left TCP relative to the CoM in T (m), x, y, z.
        r_right: the same of the right TCP.
        margin_x: greatest distance of a foot's desired CoP from its TCP along x (m).
        margin_y: the same along y.
        least_force: vertical force that a shift of the load leaves on a foot (N).

    Returns:
        T_x, T_y, F_z of the left foot, then of the right, shape (6,).
    """
    f_x, f_y, f_z, t_x, t_y, _ = modified
    left, right = load
    x, y, z = (left * r_l + right * r_r for r_l, r_r in zip(r_left, r_right, strict=True))
    rest_x = t_x - (y * f_z - z * f_y)
    rest_y = t_y - (z * f_x - x * f_z)
    wrench = []
    for share in load:
        force = share * f_z
        limit_x, limit_y = max(force, 0.0) * margin_y, max(force, 0.0) * margin_x
        wrench += [
            min(max(share * rest_x, -limit_x), limit_x),
            min(max(share * rest_y, -limit_y), limit_y),
            force,
        ]
    # What the feet cannot give: a force moved from the right foot to the left one.
    rest_x -= wrench[0] + wrench[3]
    rest_y -= wrench[1] + wrench[4]
    lever_x, lever_y = r_left[1] - r_right[1], r_right[0] - r_left[0]
    shift = (rest_x * lever_x + rest_y * lever_y) / (lever_x * lever_x + lever_y * lever_y)
    most = max(wrench[5] - least_force, 0.0) if left > 0 else 0.0
    least = min(least_force - wrench[2], 0.0) if right > 0 else 0.0
    shift = min(max(shift, least), most)
    wrench[2] += shift
    wrench[5] -= shift
    return wrench


@convertible
class ForceDistribution(AlgebraicSystem):
    """Gives each foot its desired wrench and that wrench's rate.

    The rates are those of what the stabiliser adds to the plan, and of the feet's torques. The
    state is the filtered wrench from which they are taken.

    .. pydrake_system::

        name: ForceDistribution
        input_ports:
        - modified_wrench
        - gait_phase
        - task_reference
        output_ports:
        - desired_wrench
    """

    def __init__(self, params: ForceDistributionParams, period: float):
        """Create the block for the given control period (s)."""
        super().__init__()
        self._params = params
        # Exact for a wrench that is held over the period.
        self._gain = params.rate_filter * (1 - exp(-period / params.rate_filter))
        self._modified = self.DeclareVectorInputPort("modified_wrench", MODIFIED_WRENCH.size)
        self._phase = self.DeclareVectorInputPort("gait_phase", GAIT_PHASE.size)
        self._reference = self.DeclareVectorInputPort("task_reference", TASK_REFERENCE.size)
        state = self.DeclareDiscreteState(6)
        inputs = {p.ticket() for p in (self._modified, self._phase, self._reference)}
        self._output = self.DeclareVectorOutputPort(
            "desired_wrench",
            DESIRED_WRENCH.size,
            self._calc,
            prerequisites_of_calc=inputs | {self.discrete_state_ticket(state)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc(self, context, output):
        reference = self._reference.Eval(context).tolist()
        modified = self._modified.Eval(context).tolist()
        load = self._phase.Eval(context).tolist()[_LOAD]
        wrench = distribute(
            modified,
            load,
            reference[_LEFT],
            reference[_RIGHT],
            self._params.cop_margin_x,
            self._params.cop_margin_y,
            self._params.least_force,
        )
        # The pattern itself makes the planned load by letting the feet sink in.
        unplanned = wrench.copy()
        unplanned[2] -= load[0] * modified[2]
        unplanned[5] -= load[1] * modified[2]
        filtered = context.get_discrete_state_vector().CopyToVector().tolist()
        rate = [
            (wrench - filtered) / self._params.rate_filter
            for wrench, filtered in zip(unplanned, filtered, strict=True)
        ]
        output.set_value(wrench + rate)

    def _update(self, context, state):
        rate = self._output.Eval(context)[6:]
        filtered = context.get_discrete_state_vector().CopyToVector()
        state.set_value(filtered + self._gain * rate)
