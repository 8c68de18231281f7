"""Where something goes from stable to unstable, by bisection."""

from collections.abc import Callable, Sequence

import numpy as np

Question = Callable[[float], bool]


def border(
    is_stable: Question, unstable: float, stable: float, accuracy: float, relative: bool = False
) -> float:
    """Return the last value that is stable on the way to one that is not.

    Args:
        is_stable: whether it is at a value.
        unstable: a value at which it is not.
        stable: a value at which it is; if both are whole numbers, so is what
            is returned.
        accuracy: of the border.
        relative: whether that is a part of the border.
    """
    whole = isinstance(stable, int) and isinstance(unstable, int)
    while abs(unstable - stable) > (1 if whole else accuracy * (abs(stable) if relative else 1.0)):
        middle = (unstable + stable) // 2 if whole else 0.5 * (unstable + stable)
        if is_stable(middle):
            stable = middle
        else:
            unstable = middle
    return stable


def stable_spans(
    values: Sequence[float], stable: np.ndarray, is_stable: Question
) -> list[tuple[float, float]]:
    """Return the ranges in which something is stable, their ends found to 0.5 %.

    Args:
        values: at which it has been looked, ascending or descending.
        stable: whether it is there, shape (n,).
        is_stable: whether it is at any value.
    """
    edges = np.flatnonzero(np.diff(np.r_[False, stable, False].astype(int))).reshape(-1, 2)
    spans = []
    for first, after in edges:
        low, high = values[first], values[after - 1]
        if first > 0:
            low = border(is_stable, values[first - 1], low, 0.005, relative=True)
        if after < len(values):
            high = border(is_stable, values[after], high, 0.005, relative=True)
        spans.append((low, high))
    return spans
