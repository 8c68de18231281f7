"""Extrema and zeros between the points of a grid."""

import numpy as np
import pytest

from lola_drake.linear.refine import largest

GRID = np.arange(6.0)


@pytest.mark.parametrize("top", [2.6, 3.3])
def test_a_peak_is_found_on_either_side_of_a_point(top):
    """The curve is steep there, so that whoever looks elsewhere misses it."""

    def curve(x):
        return np.exp(-20 * np.abs(x - top)) - 0.01 * (x - top) ** 2

    height, at = largest(curve, GRID, curve(GRID))
    assert at == pytest.approx(top, abs=1e-5)
    assert height == pytest.approx(1.0, abs=1e-4)


def test_it_is_not_looked_for_beyond_the_neighbours():
    """A curve that rises again farther off has its peak where the grid saw one."""

    def curve(x):
        return np.where(x < 4.2, 2 - (x - 2.3) ** 2, 10.0 * (x > 4.5) * (x < 4.9) - 5)

    height, at = largest(curve, GRID, curve(GRID))
    assert (height, at) == (pytest.approx(2.0), pytest.approx(2.3, abs=1e-5))
