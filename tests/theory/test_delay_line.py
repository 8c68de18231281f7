"""A line of samples under way: what goes in comes out, whole and in its turn."""

import numpy as np
import pytest

from lola_drake.theory.delay_line import arriving, delayed


@pytest.mark.parametrize("delay", [1, 2, 5])
def test_a_sample_comes_out_after_its_delay(delay):
    """A line of n samples delays by n + 1 ticks, the last of which is that of who reads it."""
    line, out = np.zeros(2 * (delay - 1)), []
    for k in range(1, 11):
        sample = (float(k), -float(k))
        out.append(arriving(line, sample))
        line = delayed(line, sample)
    expected = [max(k - delay + 1, 0) for k in range(1, 11)]
    assert np.array_equal(out, np.column_stack([expected, np.negative(expected)]))


def test_the_newest_sample_is_the_first():
    assert np.array_equal(delayed([3.0, 4.0, 1.0, 2.0], (5.0, 6.0)), [5.0, 6.0, 3.0, 4.0])


def test_an_empty_line_stays_empty():
    assert delayed([], (5.0, 6.0)).size == 0


def test_the_line_itself_is_left_alone():
    line = np.arange(4.0)
    delayed(line, (5.0, 6.0))
    arriving(line, (5.0, 6.0))
    assert np.array_equal(line, np.arange(4.0))
