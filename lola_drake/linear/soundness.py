"""Whether a block's tick is what a linear model can be made of: a function of states and inputs.

Drake tells only the timing of periodic discrete updates. What else changes a block's state
(per-step events, unrestricted updates, a Python attribute) is found by trying.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context, System

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import Instance, discrete_state, join_groups, set_discrete_state

PROBE = 1e-3
"""Relative step away from the operating point, where what does nothing at rest does something."""

MEETINGS = (0.0, 3600.0)
"""Times at which events of all periods meet, whatever their period (s)."""


def check_timing(path: str, instance: Instance) -> None:
    """Raise AnalysisError if a block is not a discrete system with one update and one period."""
    block, context = instance.system, instance.context
    reason = None
    if block.num_continuous_states():
        reason = "it has continuous state"
        if isinstance(block, MultibodyPlant):
            reason += ", build it with a time step"
    elif context.num_abstract_states():
        reason = "it has abstract state"
        if isinstance(block, MultibodyPlant):
            reason += ", build it with use_sampled_output_ports=False"
    elif context.num_discrete_state_groups():
        if block.GetUniquePeriodicDiscreteUpdateAttribute() is None:
            reason = "it has no single periodic discrete update"
    if reason:
        raise AnalysisError(f"{path} cannot be linearised: {reason}")


def check_memory(
    names: str,
    roots: list[Context],
    move: Callable[[float], None],
    tick: Callable[[], np.ndarray],
) -> None:
    """Raise AnalysisError if blocks remember more than their contexts hold.

    The same tick must come out twice, whatever has been computed for later ticks in between.

    Args:
        names: of the blocks.
        roots: the contexts whose times are those of the blocks.
        move: moves all states and inputs by a relative step.
        tick: returns what one tick leads to.
    """
    start = roots[0].get_time()

    def after(ticks: int, step: float) -> np.ndarray:
        for root in roots:
            root.SetTime(start + 1e-3 * ticks)
        move(step)
        return tick()

    first, second = after(0, 0.0), after(1, 0.0)
    with suppress(Exception, SystemExit):
        after(2, PROBE)
    after(3, 0.0)
    again = after(1, 0.0), after(0, 0.0)
    if not (_same(again[0], second) and _same(again[1], first)):
        raise AnalysisError(
            f"{names} cannot be linearised: the same tick comes out different the second time, "
            "as of a block that keeps state outside its context"
        )


def check_events(path: str, instance: Instance) -> None:
    """Raise AnalysisError if Simulator makes more of a tick than the one discrete update."""
    block, context = instance.system, instance.context
    if isinstance(block, MultibodyPlant) or not context.num_discrete_state_groups():
        return
    timing = block.GetUniquePeriodicDiscreteUpdateAttribute()
    if timing is None:
        return
    period, offset = timing.period_sec(), timing.offset_sec()
    for time in (context.get_time(), *MEETINGS):
        alone = _off_balance(block, context)
        alone.SetTime(offset + max(round((time - offset) / period), 0) * period)
        expected = join_groups(block.EvalUniquePeriodicDiscreteUpdate(alone))
        simulator = Simulator(block, alone)
        simulator.Initialize(InitializeParams(suppress_initialization_events=True))
        # Two steps within one period: in the second one nothing periodic happens.
        for _ in range(2):
            simulator.AdvanceTo(simulator.get_context().get_time() + 0.25 * period)
        found = discrete_state(simulator.get_context())
        if simulator.get_num_unrestricted_updates() or not _same(found, expected):
            raise AnalysisError(
                f"{path} cannot be linearised: more than its periodic discrete update changes its "
                "state"
            )


def _off_balance(block: System, context: Context) -> Context:
    """Return a context of the block alone, with the same inputs and its state moved if possible."""
    alone = block.CreateDefaultContext()
    alone.SetTimeStateAndParametersFrom(context)
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        if port.HasValue(context):
            port.FixValue(alone, port.EvalAbstract(context))
    state = discrete_state(context)
    set_discrete_state(alone, state + PROBE * np.maximum(1.0, np.abs(state)))
    try:
        block.EvalUniquePeriodicDiscreteUpdate(alone)
    except (Exception, SystemExit):
        set_discrete_state(alone, state)
    return alone


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return np.allclose(one, other, rtol=1e-9, atol=1e-12)
