"""Equilibria of the one-tick map by Newton's method; its derivative is the linear model itself."""

import numpy as np
from pydrake.systems.framework import Context, Diagram
from scipy.linalg import matrix_balance

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.interconnection import LinearBlocks
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.linear.poles import neutral

ITERATIONS = 20

SLOW = (1e-12, 1e-6)
"""What moves by less than this part of itself in a tick stays where it is. First that is nothing;
if that leads nowhere, it is what takes longer than a quarter of an hour: a height that no law holds
is carried away by the noise of the numbers."""

LOST = 1e3
"""Newton's method has lost its way when the drift has grown to this many times the first one."""


def find_equilibrium(
    diagram: Diagram, start: Context, allowed: float = 1e-6
) -> tuple[Context, float]:
    """Return a context near `start` in which no state moves, and what drift is left.

    Args:
        diagram: whose discrete states are to rest.
        start: where to begin; it stays as it is. What is fixed in it stays fixed.
        allowed: the largest drift that is left in one tick, as in `linearize`. What limits it is
            the tolerance of the plant's contact solver.

    Raises:
        AnalysisError: if Newton's method does not get there.
    """
    for slow in SLOW:
        try:
            return _search(diagram, start.Clone(), allowed, slow)
        except AnalysisError as error:
            failure = error
    raise failure


def _search(
    diagram: Diagram, context: Context, allowed: float, slow: float
) -> tuple[Context, float]:
    """Return the context, moved to an equilibrium, and the drift that is left."""
    drifts: list[float] = []
    while len(drifts) < ITERATIONS:
        # What blocks are does not change on the way: they are looked into once.
        blocks = linear_blocks(diagram, context, [], [], checked=not drifts)
        drift = float(np.abs(blocks.relative_drift).max(initial=0.0))
        if drifts and 0.1 * drifts[-1] < drift <= allowed:
            return context, drift
        if drifts and drift > LOST * max(drifts[0], allowed):
            break
        drifts.append(drift)
        blocks.coordinates.move(context, _newton_step(blocks, slow))
    try:
        blocks.check_equilibrium(allowed)
    except AnalysisError as error:
        raise AnalysisError(f"no equilibrium found, {error}") from None
    return context, drift


def _newton_step(blocks: LinearBlocks, slow: float) -> np.ndarray:
    """Return the motion that brings the drift to zero, to first order."""
    A = blocks.interconnect([], []).A
    # States have many units: balancing makes them comparable.
    _, (scale, _) = matrix_balance(A, permute=False, separate=True)
    balanced = (np.eye(len(A)) - A) * scale / scale[:, None]
    free = ~neutral(blocks.state_names)
    step = np.zeros(len(A))
    # Least squares: what nothing moves, such as an integrator without gain, stays.
    step[free] = np.linalg.lstsq(
        balanced[np.ix_(free, free)], (blocks.drift / scale)[free], rcond=slow
    )[0]
    return step * scale
