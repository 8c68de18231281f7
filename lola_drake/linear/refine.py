"""Extrema and zeros of a function of frequency, from a grid down to the last digit."""

from collections.abc import Callable

import numpy as np

Curve = Callable[[np.ndarray], np.ndarray]

HALVINGS_OF_PEAK, HALVINGS_OF_ZERO = 20, 40
PEAKS = 8
"""How many of the largest peaks of a grid are looked at: the largest may lie between its points."""


def largest(curve: Curve, grid: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Return the largest value of a curve, and where.

    Args:
        curve: the function.
        grid: where it has been looked at, ascending.
        values: of the curve there.
    """
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    peaks = np.flatnonzero((values >= padded[:-2]) & (values >= padded[2:]))
    peaks = peaks[np.argsort(-values[peaks])][:PEAKS]
    at, found = _climb(curve, grid, peaks)
    best = int(np.argmax(found))
    return float(found[best]), float(at[best])


def zeros_of(curve: Curve, grid: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return where a curve crosses zero.

    Two crossings between neighbours of the grid are found where the curve comes near zero there.

    Args: as in `largest`.
    """
    grid, values = _with_near_misses(curve, grid, values)
    signs = _sign(values)
    k = np.flatnonzero(signs[1:] != signs[:-1])
    low, high, sign = grid[k], grid[k + 1], signs[k]
    for _ in range(HALVINGS_OF_ZERO if k.size else 0):
        middle = 0.5 * (low + high)
        before = _sign(curve(middle)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def _with_near_misses(
    curve: Curve, grid: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the grid with the points at which a curve that nearly touches zero comes nearest."""
    size, signs = np.abs(values), _sign(values)
    same = signs[1:] == signs[:-1]
    before, here, after = size[:-2], size[1:-1], size[2:]
    near = (here <= before) & (here <= after) & (2 * here < np.maximum(before, after))
    found, new = [grid], [values]
    for sign in (1.0, -1.0):
        k = 1 + np.flatnonzero(near & same[:-1] & same[1:] & (signs[1:-1] == sign))
        if k.size:
            at, nearest = _climb(_times(-sign, curve), grid, k)
            found.append(at)
            new.append(-sign * nearest)
    grid, order = np.unique(np.concatenate(found), return_index=True)
    return grid, np.concatenate(new)[order]


def _sign(values: np.ndarray) -> np.ndarray:
    """Return 1 or -1: a curve that is zero at a point of the grid crosses there, or not at all."""
    return np.where(values < 0, -1.0, 1.0)


def _times(factor: float, curve: Curve) -> Curve:
    return lambda f: factor * curve(f)


def _climb(curve: Curve, grid: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the peaks near some points of a grid, and the curve there, by halving intervals."""
    low, at, high = grid[np.maximum(k - 1, 0)], grid[k], grid[np.minimum(k + 1, len(grid) - 1)]
    best = curve(at)
    for _ in range(HALVINGS_OF_PEAK):
        points = np.array([0.5 * (low + at), at, 0.5 * (at + high)])
        tried = curve(points[[0, 2]].ravel()).reshape(2, -1)
        heights = np.array([tried[0], best, tried[1]])
        # The top lies between the neighbours of the highest of the five points.
        five = np.array([low, *points, high])
        row, column = np.argmax(heights, axis=0), np.arange(k.size)
        low, at, high = (five[row + shift, column] for shift in range(3))
        best = heights[row, column]
    return at, best
