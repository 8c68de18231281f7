"""Equilibria of the one-tick map by Newton's method; its derivative is the linear model itself."""

import numpy as np
from pydrake.systems.framework import Context, Diagram
from scipy.linalg import matrix_balance

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.interconnection import LinearBlocks
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.linear.poles import neutral

ITERATIONS = 20

SLOW = 2e-7
"""What moves by less than this part of itself in a tick stays where it is: as a height that no law
holds, which the numbers' noise alone would carry away."""


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
    context, last = start.Clone(), np.inf
    for k in range(ITERATIONS):
        # What blocks are does not change on the way: they are looked into once.
        blocks = linear_blocks(diagram, context, [], [], checked=not k)
        drift = float(np.abs(blocks.relative_drift).max(initial=0.0))
        if drift <= allowed and drift > 0.1 * last:
            return context, drift
        last = drift
        blocks.coordinates.move(context, _newton_step(blocks))
    try:
        blocks.check_equilibrium(allowed)
    except AnalysisError as error:
        raise AnalysisError(f"no equilibrium found, {error}") from None
    return context, drift


def _newton_step(blocks: LinearBlocks) -> np.ndarray:
    """Return the motion that brings the drift to zero, to first order."""
    A = blocks.interconnect([], []).A
    # States have many units: balancing makes them comparable.
    _, (scale, _) = matrix_balance(A, permute=False, separate=True)
    balanced = (np.eye(len(A)) - A) * scale / scale[:, None]
    free = ~neutral(blocks.state_names)
    step = np.zeros(len(A))
    # Least squares: what nothing moves, such as an integrator without gain, stays.
    step[free] = np.linalg.lstsq(
        balanced[np.ix_(free, free)], (blocks.drift / scale)[free], rcond=SLOW
    )[0]
    return step * scale
