"""Which points of some factors' space a sweep tries: a grid, or points spread all over it."""

from collections.abc import Sequence
from itertools import product
from math import prod
from warnings import catch_warnings, simplefilter

import numpy as np
from scipy.stats import qmc

from lola_drake.errors import shown
from lola_drake.studies.factors import Factor, SweepError

DESIGNS = ("grid", "latin", "sobol")
"""Every combination; a Latin hypercube; Sobol's sequence, scrambled. Both of the latter are drawn
from the same seed every time, so that a sweep can be continued."""

MOST_RUNS = 100_000
"""Of one sweep."""

Point = dict[str, object]


def points(factors: Sequence[Factor], design: str, count: int | None, runs: int) -> list[Point]:
    """Return the points of a design, each the values of all keys.

    Args:
        factors: what is varied.
        design: one of `DESIGNS`.
        count: number of points; None for a grid, which has all combinations.
        runs: at each point.

    Raises:
        SweepError: If that is no design, lacks points, or would be more than `MOST_RUNS`.
    """
    if design not in DESIGNS:
        raise SweepError(f"design: {shown(design)}, there are {', '.join(DESIGNS)}")
    if design == "grid":
        return _grid(factors, count, runs)
    if not count or count < 2:
        raise SweepError(f"a design {design} needs a number of points: --points N, at least 2")
    _check_size(count, runs)
    sampler = {"latin": qmc.LatinHypercube, "sobol": qmc.Sobol}[design](len(factors), rng=0)
    with catch_warnings():
        # Sobol's points are spread best where their number is a power of two, and well otherwise.
        simplefilter("ignore", UserWarning)
        shares = sampler.random(count)
    return [_point(factors, row) for row in shares]


def _grid(factors: Sequence[Factor], count: int | None, runs: int) -> list[Point]:
    if count is not None:
        raise SweepError("a grid has all combinations: --points is for --design latin or sobol")
    for factor in factors:
        if factor.is_range:
            low, high = factor.values
            raise SweepError(f"{factor.key}: a grid needs their number, {low:g}:{high:g}:N")
    _check_size(prod(len(factor.values) for factor in factors), runs)
    keys = [factor.key for factor in factors]
    combinations = product(*(factor.values for factor in factors))
    return [dict(zip(keys, values, strict=True)) for values in combinations]


def _point(factors: Sequence[Factor], shares: np.ndarray) -> Point:
    return {
        factor.key: factor.at(float(share)) for factor, share in zip(factors, shares, strict=True)
    }


def _check_size(count: int, runs: int) -> None:
    if count * runs > MOST_RUNS:
        raise SweepError(
            f"{count:,} points with {runs:,} runs each: more than {MOST_RUNS:,} runs, take fewer"
        )
