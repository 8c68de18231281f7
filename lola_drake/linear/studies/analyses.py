"""Named analyses at an operating point: poles, margins, responses, root locus, tables."""

from dataclasses import dataclass
from typing import Any

import control
import numpy as np

from lola_drake.linear.linearize import state_space
from lola_drake.linear.margin import Margins, MatrixMargins
from lola_drake.linear.margins import margins
from lola_drake.linear.open_loop import negated
from lola_drake.linear.poles import Pole, poles
from lola_drake.linear.studies.named_analyses import NamedAnalysis, named_analysis
from lola_drake.linear.studies.tables import extra_tables, signals_of_tables
from lola_drake.linear.studies.workpoint import Workpoint, make_workpoint
from lola_drake.linear.text_table import Table
from lola_drake.scenario import Scenario

SHOWN_STEP, LONGEST_STEP = 0.5, 5.0
"""Length of a step response (s): that of one which does not settle, and in which it must."""

SETTLED = 0.02
"""What is left of a step response when it has settled, relative to its largest value."""


@dataclass(frozen=True)
class Loop:
    """A loop opened at a signal, and its margins.

    Attributes:
        signal: where it is opened.
        transfer: L.
        margins: of each of its entries, the others being closed.
        together: of all entries at once; None if there is only one.
    """

    signal: str
    transfer: control.StateSpace
    margins: tuple[Margins, ...]
    together: MatrixMargins | None


@dataclass(frozen=True)
class Locus:
    """The poles over a parameter.

    Attributes:
        key: of the parameter.
        values: of the parameter.
        poles: one array for each value.
        nominal: the parameter's value in the scenario.
    """

    key: str
    values: tuple[float, ...]
    poles: tuple[np.ndarray, ...]
    nominal: float


@dataclass(frozen=True)
class Analysis:
    """All there is to say about one part of the loop.

    Attributes:
        name: of the analysis.
        definition: what was done.
        workpoint: the operating point.
        model: from the definition's inputs to its outputs.
        poles: of the model, slowest first.
        loops: its margins.
        locus: its poles over the knob; None if it was not asked for.
        tables: whatever else belongs to it.
    """

    name: str
    definition: NamedAnalysis
    workpoint: Workpoint
    model: control.StateSpace
    poles: list[Pole]
    loops: list[Loop]
    locus: Locus | None
    tables: list[Table]


def analyse(
    name: str,
    scenario: Scenario,
    at: str | None = None,
    *,
    locus: bool = True,
) -> Analysis:
    """Carry out a named analysis.

    Args:
        name: one of `named_analyses.NAMED_ANALYSES`.
        scenario: its parameters, and for `t=...` what runs.
        at: the operating point as in `operating_points.situation`; None for the analysis's own.
        locus: whether to compute the root locus too.
    """
    how = named_analysis(name)
    read = (*how.outputs, *how.opened, *how.loops, *signals_of_tables(name))
    workpoint = make_workpoint(scenario, at or how.at, (*how.inputs, *read), read)
    model = part(workpoint, how)
    return Analysis(
        name=name,
        definition=how,
        workpoint=workpoint,
        model=model,
        poles=poles(model),
        loops=[open_at(workpoint, signal) for signal in how.loops],
        locus=root_locus(workpoint, how) if locus else None,
        tables=extra_tables(name, workpoint),
    )


def part(workpoint: Workpoint, how: NamedAnalysis) -> control.StateSpace:
    """Return the model that a named analysis is about, at a workpoint."""
    return state_space(
        workpoint.blocks,
        workpoint.select(how.inputs),
        workpoint.select(how.outputs),
        workpoint.select(how.opened),
        minimal=True,
        time=workpoint.situation.context.get_time(),
    )


def open_at(workpoint: Workpoint, signal: str) -> Loop:
    """Return the loop of a workpoint opened at a signal."""
    at = workpoint.select([signal])
    transfer = negated(state_space(workpoint.blocks, at, at, at, minimal=True))
    found = margins(transfer)
    return Loop(signal, transfer, found.each, found.together if len(found.each) > 1 else None)


def root_locus(workpoint: Workpoint, how: NamedAnalysis) -> Locus:
    """Return the poles of a named analysis's model over its knob."""
    found = []
    for value in how.values:
        model = part(workpoint.varied({how.knob: value}), how)
        found.append(np.linalg.eigvals(model.A))
    return Locus(how.knob, how.values, tuple(found), value_of(workpoint.scenario, how.knob))


def step_response(
    model: control.StateSpace, k: int, height: float, duration: float = SHOWN_STEP
) -> tuple[np.ndarray, np.ndarray]:
    """Return times and all outputs after a step at input k, shapes (n,) and (n, outputs)."""
    count = round(duration / model.dt)
    x, rows = np.zeros(model.nstates), []
    for _ in range(count):
        rows.append(model.C @ x + model.D[:, k] * height)
        x = model.A @ x + model.B[:, k] * height
    return model.dt * np.arange(count), np.array(rows)


def settled_step(
    model: control.StateSpace, k: int, height: float
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Return a step response until output k has settled, and whether it has.

    It has when it stays within `SETTLED` of its largest motion around where it ends.
    """
    times, outputs = step_response(model, k, height, LONGEST_STEP)
    away = np.abs(outputs[:, k] - outputs[-1, k])
    moving = np.flatnonzero(away > SETTLED * np.abs(outputs[:, k]).max())
    last = moving[-1] if moving.size else 0
    # What moves to within the last fifth ends nowhere.
    settled = last < 0.8 * len(times)
    count = max(round(1.3 * last), 50) if settled else round(SHOWN_STEP / model.dt)
    return times[:count], outputs[:count], bool(settled)


def value_of(scenario: Scenario, key: str) -> float:
    """Return the number that a dotted key of a scenario means."""
    value: Any = scenario
    for name in key.split("."):
        value = getattr(value, name)
    return float(value)
