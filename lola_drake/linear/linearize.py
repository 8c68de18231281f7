"""Linear models of any part of a diagram: the exact tick of its discrete blocks.

Every block is linearised on its own and the results are interconnected through the diagram's
wiring. That is exact, costs a few hundred small evaluations, and never mixes what a block does
with what its neighbours do. Noise is a pure function of the tick and the tick is fixed, so noise
is the same in all evaluations and drops out. The walking pattern does not depend on the robot: it
is held at what it says in this tick, and along a walk the result is the exact linear map of that
tick. Contact switches are held too: they do not move by a little. Logs have no state and drop out.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.systems.framework import Context, System

from lola_drake.errors import shown
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.interconnection import LinearBlocks, Matrices, StateSelection
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.linear.model import LinearModel, OperatingPoint
from lola_drake.linear.wiring import Selection, Wiring

NEGLIGIBLE = 1e-9
"""A coupling this much smaller than the largest one of its state counts as none."""


def linearize(
    system: System,
    inputs: str | Iterable[str],
    outputs: str | Iterable[str],
    at: Context,
    *,
    opened: str | Iterable[str] = (),
    hold: str | Iterable[str] = (),
    minimal: bool = False,
    equilibrium: float | None = None,
    kinks: bool = False,
) -> LinearModel:
    """Return the linear model of a diagram or block at an operating point.

    Signals are named `[block.]signal[.field[.entry]]`, for instance `measured_wrench`,
    `measured_wrench_l`, `desired_wrench.wrench_l.F_z` or `plant.net_actuation.tkfl`; a name without
    an entry means all of them. A label of the result is such a name with slashes for the points,
    and its unit in brackets where one is known.

    Args:
        system: a Diagram of discrete blocks with one period, or one such block.
        inputs: signals to which something is added on the way to their readers; at least one where
            the model has one output or one state.
        outputs: signals as their readers see them, or states.
        at: a context of `system`, or of a diagram around it; it stays as it is.
        opened: signals that are cut. Their readers get only what an input there adds, and an
            output there is what the source gives.
        hold: paths of more blocks to hold, besides walking pattern and contact switches.
        minimal: whether to cut the states that no input excites or no output observes; the
            result's `operating_point.cut` says which.
        equilibrium: the largest drift of a state in one tick that is let pass, relative to 100 N,
            100 Nm, and 1 of everything else in SI units; None for any, as on a walk.

        kinks: whether to take the mean slope where the two sides have different ones.

    Returns:
        A discrete-time `control.StateSpace` with named signals and states and an
        `operating_point`.

    Raises:
        AnalysisError: if an input is wanting, a signal or a block to hold is unknown, a block
            cannot be linearised (see `soundness`) or has a kink or a quantiser here, the context
            is of another diagram, or the operating point is not the equilibrium it should be.
    """
    entering, wanted = names_in("inputs", inputs), names_in("outputs", outputs)
    cut, still = names_in("opened", opened), names_in("hold", hold)
    if not isinstance(system, System):
        raise AnalysisError(f"system: {shown(system)} is not allowed, it must be a System of Drake")
    wiring = Wiring(system)
    added, cut_open = ([wiring.select(name) for name in names] for names in (entering, cut))
    read = [s for name in wanted if (s := _signal_or_none(wiring, name))]
    blocks = linear_blocks(system, at, added, [*read, *cut_open], hold=still)
    found = [blocks.select(name) for name in wanted]
    _check_once("inputs", added)
    _check_once("outputs", found)
    if blocks.kinks and not kinks:
        raise AnalysisError(
            f"no linear model here: {blocks.kinks[0]} is at a kink or quantised; "
            "kinks=True lets it pass"
        )
    if equilibrium is not None:
        blocks.check_equilibrium(equilibrium)
    return state_space(blocks, added, found, cut_open, minimal=minimal, time=at.get_time())


def state_space(
    blocks: LinearBlocks,
    inputs: Sequence[Selection],
    outputs: Sequence[Selection | StateSelection],
    opened: Sequence[Selection] = (),
    *,
    minimal: bool = False,
    time: float = 0.0,
) -> LinearModel:
    """Return the model of interconnected blocks; the arguments are those of `linearize`."""
    matrices = blocks.interconnect(inputs, outputs, opened)
    names = np.array(blocks.state_names, dtype=object)
    kept = essential(matrices) if minimal else np.ones(len(names), dtype=bool)
    if not inputs and 1 in (kept.sum(), len(matrices.D)):
        raise AnalysisError(
            "inputs: [] is not allowed, it must be at least one signal where the model has one "
            "output or one state; python-control has no other such model"
        )
    return LinearModel(
        matrices.A[np.ix_(kept, kept)],
        matrices.B[kept],
        matrices.C[:, kept],
        matrices.D,
        blocks.period or True,
        inputs=[label for selection in inputs for label in selection.labels_with_units],
        outputs=[label for selection in outputs for label in selection.labels_with_units],
        states=list(names[kept]),
        operating_point=OperatingPoint(
            time=time,
            drift=dict(zip(names, blocks.drift, strict=True)),
            residual=float(np.abs(blocks.relative_drift).max(initial=0.0)),
            held=blocks.held,
            cut=tuple(names[~kept]),
            kinks=blocks.kinks,
        ),
    )


def essential(matrices: Matrices) -> np.ndarray:
    """Return which states some input excites and some output observes, shape (n,).

    Judged by the structure alone: by which states act on which.
    """
    scale = np.abs(matrices.A).max(axis=1, initial=1e-300, keepdims=True)
    acts = np.abs(matrices.A) > NEGLIGIBLE * scale
    excited = _reached(acts, (matrices.B != 0).any(axis=1))
    observed = _reached(acts.T, (matrices.C != 0).any(axis=0))
    return excited & observed


def _reached(acts: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return what is reached from `start` when column j acts on row i where acts[i, j]."""
    reached = start
    while True:
        further = reached | acts[:, reached].any(axis=1)
        if (further == reached).all():
            return reached
        reached = further


def names_in(argument: str, given: str | Iterable[str]) -> list[str]:
    """Return what is given for an argument as a list; AnalysisError if it is no names."""
    several = isinstance(given, Iterable) and not isinstance(given, str)
    names: list = list(given) if several else [given]
    if not all(isinstance(name, str) for name in names):
        raise AnalysisError(
            f"{argument}: {shown(given)} is not allowed, it must be a name, or a list of names"
        )
    return names


def _check_once(argument: str, selections: Iterable[Selection | StateSelection]) -> None:
    """Raise AnalysisError if an entry is there twice: python-control would take both for one."""
    labels = [label for selection in selections for label in selection.labels]
    for label in labels:
        if labels.count(label) > 1:
            raise AnalysisError(f"{argument}: {label} is named more than once")


def _signal_or_none(wiring: Wiring, name: str) -> Selection | None:
    """Return the signal of a name; None if there is none, for it may be a state."""
    try:
        return wiring.select(name)
    except AnalysisError:
        return None
