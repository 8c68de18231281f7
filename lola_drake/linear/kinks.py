"""Whether a function has a kink or is quantised where it is differentiated."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

ROUNDING = 1e-11
"""What rounding makes of a value, relative to 1 and to the value; generously."""

BENT, BENT_OF_SOLVER = 1e-4, 0.2
"""Part of a column by which both sides' slopes must differ to count; the same for a contact
solver, which returns a guess that is good enough."""

OVERLOOKED = 1e-4
"""Changes that a contact solver may overlook."""

SMOOTH_CONTACT = 1e-6
"""Step within which contact is smooth: friction bends over 0.1 mm/s."""

FARTHER = 8.0
"""Factor between two steps: a smooth bend grows with its square, a kink's like the step, and a
jump's not at all. Between the first two lies `KINKED`."""
KINKED = 24.0

STEEP = 1e3
"""Slope from which on it may be a jump."""

FAR = (1e-3, 1.0)
"""Relative steps by which a quantised function is found out."""


@dataclass(frozen=True)
class Column:
    """Where a step to both sides leads.

    Attributes:
        step: its length.
        ahead, base, behind: the function after a step, without, and after one backwards.
    """

    step: float
    ahead: np.ndarray
    base: np.ndarray
    behind: np.ndarray

    @property
    def bend(self) -> np.ndarray:
        """Return by how much more it rises ahead than behind."""
        return np.abs(self.ahead - 2 * self.base + self.behind)


def is_flat(column: Column) -> bool:
    """Return whether nothing moves at all."""
    return np.array_equal(column.ahead, column.base) and np.array_equal(column.behind, column.base)


def has_kink(column: Column, at: Callable[[float], np.ndarray]) -> bool:
    """Return whether there is a kink or a jump.

    Args:
        column: the differences.
        at: the function after a step.
    """
    rises = np.abs(column.ahead - column.base), np.abs(column.behind - column.base)
    largest = np.max(rises, initial=0.0)
    if largest > STEEP * column.step and not (
        np.abs(at(FARTHER * column.step) - column.base).max() > 2 * largest
    ):
        return True  # a jump need not bend
    noticed = ROUNDING * (1 + np.abs(column.base)) + BENT * largest
    if not (column.bend > noticed).any():
        return False
    near, far = (
        Column(step, at(step), column.base, at(-step)).bend
        for step in (FARTHER * column.step, FARTHER**2 * column.step)
    )
    return bool(((column.bend > noticed) & (far < KINKED * near)).any())


def solver_has_kink(column: Column, at: Callable[[float], np.ndarray]) -> bool:
    """Return whether there is a kink in what a contact solver gives.

    At the operating point itself the solver may return the guess that it started from: the slopes
    are compared beside it.

    Args: as in `has_kink`.
    """
    if column.step > SMOOTH_CONTACT:
        return False
    step = FARTHER * column.step
    ahead, behind = at(step) - column.ahead, column.behind - at(-step)
    largest = np.max(np.abs([ahead, behind]), initial=OVERLOOKED)
    return bool((np.abs(ahead - behind) > BENT_OF_SOLVER * largest).any())


def is_quantised(column: Column, at: Callable[[float], np.ndarray]) -> bool:
    """Return whether a function that is flat here is so at two other heights: not just a switch.

    Args: as in `has_kink`.
    """
    for step in (sign * far for far in FAR for sign in (1, -1)):
        try:
            heights = [column.base, at(step), at(2 * step)]
            beside = at(step + column.step), at(2 * step + column.step)
        except (Exception, SystemExit):
            continue  # so far away the function need not exist
        flat = all(np.array_equal(*pair) for pair in zip(heights[1:], beside, strict=True))
        if flat and ((heights[0] != heights[1]) & (heights[1] != heights[2])).any():
            return True
    return False
