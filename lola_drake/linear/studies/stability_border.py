"""The border of stability in delta: by the linear model, and by the nonlinear simulation."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import own_context
from lola_drake.linear.poles import UNSTABLE
from lola_drake.linear.studies.bisection import border
from lola_drake.linear.studies.map_kinds import DELTA
from lola_drake.linear.studies.operating_points import Situation
from lola_drake.linear.studies.stability_map import growth_rate
from lola_drake.linear.studies.workpoint import Workpoint, make_workpoint
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.linear.wiring import Wiring
from lola_drake.scenario import Scenario
from lola_drake.signals import PERIOD

RANGE = (0.002, 0.1)
"""Within which the border is looked for (s)."""

KICK, NOISE = 1.0, 1e-3
"""Force by which the feet's sensors are wrong for ten ticks, to set the loop in motion; and what
counts as rest afterwards (N)."""


def compare_borders(scenario: Scenario, at: str) -> dict[str, float]:
    """Return the border of a scenario at an equilibrium by both, in seconds."""
    workpoint = make_workpoint(scenario, at)
    return {
        "predicted_s": predicted_border(workpoint),
        "simulated_s": simulated_border(workpoint.situation),
    }


def predicted_border(workpoint: Workpoint, accuracy: float = 0.002) -> float:
    """Return the smallest stable delta (s) by the linear model.

    Args:
        workpoint: an equilibrium.
        accuracy: relative.
    """

    def is_stable(delta: float) -> bool:
        return growth_rate(workpoint.varied({DELTA: delta})) <= UNSTABLE / PERIOD

    return _smallest(is_stable, accuracy)


def simulated_border(situation: Situation, accuracy: float = 0.02) -> float:
    """Return the smallest stable delta (s) by the nonlinear simulation.

    Args:
        situation: an equilibrium.
        accuracy: relative.
    """
    return _smallest(lambda delta: not swings_up(situation, delta), accuracy)


def swings_up(situation: Situation, delta: float, duration: float = 1.0) -> bool:
    """Return whether the nonlinear simulation swings up after a kick.

    The largest changes of the contact wrenches from tick to tick are compared between the second
    and the last quarter of the time; where they are far larger than the kick, it has swung up
    long before.

    Args:
        situation: an equilibrium.
        delta: time constant of the force control (s).
        duration: of the simulation (s).
    """
    ticks = TickLoop(situation.diagram, with_gain(situation, "time_constant", delta))
    count = round(duration / ticks.period)
    kick = np.zeros((count, 12))
    kick[:10, [2, 8]] = KICK
    try:
        record = ticks.run(["contact_wrench_l", "contact_wrench_r"], count, "measured_wrench", kick)
    except AnalysisError:
        return True  # it swung up until nothing could be computed any more
    motion = np.abs(np.diff(record, axis=0)).max(axis=1)
    early, late = motion[count // 4 : count // 2].max(), motion[3 * count // 4 :].max()
    return bool(late > max(early, NOISE) or late > 10 * KICK)


def with_gain(situation: Situation, name: str, value: float) -> Context:
    """Return a copy of the situation's context in which a gain is another, in all its blocks."""
    context = situation.context.Clone()
    for system in Wiring(situation.diagram).blocks.values():
        index = getattr(system, "gain_index", {}).get(name)
        if index is not None:
            own_context(system, context).get_mutable_numeric_parameter(index).SetAtIndex(0, value)
    return context


def _smallest(is_stable: Callable[[float], bool], accuracy: float) -> float:
    low, high = RANGE
    if is_stable(low) or not is_stable(high):
        raise AnalysisError(f"no border of stability between {low:g} s and {high:g} s")
    return border(is_stable, low, high, accuracy, relative=True)
