"""Loop transfers: the diagram cut at a signal, from its readers round to its source."""

from collections.abc import Iterable

from pydrake.systems.framework import Context, Diagram

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.linearize import linearize, names_in
from lola_drake.linear.model import LinearModel


def open_loop(
    diagram: Diagram,
    at: str | Iterable[str],
    context: Context,
    *,
    minimal: bool = True,
    equilibrium: float | None = None,
) -> LinearModel:
    """Return the loop transfer L at a signal, all other loops being closed.

    The sign is that of negative feedback, as margins are defined: the closed loop is stable up to
    the first gain or phase that brings L to -1.

    Args:
        diagram: the closed loop.
        at: names of signals as in `linearize`, for instance `measured_wrench_l`. Several entries
            make L a square matrix; `lola.margins` takes it.
        context: the operating point.
        minimal: as in `linearize`.
        equilibrium: as in `linearize`.

    Raises:
        AnalysisError: if there is no signal, and as in `linearize`.
    """
    at = names_in("at", at)
    if not at:
        raise AnalysisError("at: [] is not allowed, it must be at least one signal")
    loop = linearize(
        diagram, at, at, at=context, opened=at, minimal=minimal, equilibrium=equilibrium
    )
    return negated(loop)


def negated(loop: LinearModel) -> LinearModel:
    """Return -loop with the names and the operating point of `loop`."""
    return LinearModel(
        loop.A,
        loop.B,
        -loop.C,
        -loop.D,
        loop.dt,
        inputs=loop.input_labels,
        outputs=loop.output_labels,
        states=loop.state_labels,
        operating_point=loop.operating_point,
    )
