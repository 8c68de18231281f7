"""What the two sides of a point say about the function there."""

import numpy as np
import pytest

from lola_drake.linear.kinks import Column, is_quantised


def looked_at(function, point: float, step: float = 1e-7) -> bool:
    """Return whether a function of a number is called quantised at a point where it is flat."""

    def at(change: float) -> np.ndarray:
        return np.array([float(function(point + change))])

    return is_quantised(Column(step, at(step), at(0.0), at(-step)), at)


@pytest.mark.parametrize(
    ("function", "quantised"),
    [
        (lambda u: np.floor(4 * u), True),
        (lambda u: np.floor(1000 * u), True),
        # It comes back to its first height after two stairs.
        (lambda u: np.floor(u) % 2, True),
        (lambda u: float(u > 0), False),
        (lambda u: 3.0, False),
        (lambda u: max(u - 1, 0.0), False),
    ],
)
def test_stairs_are_quantised_and_a_single_switch_is_not(function, quantised):
    assert looked_at(function, 0.1003) is quantised
