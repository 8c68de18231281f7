"""A line of samples under way, the newest first; if it is empty, a sample arrives at once.

All functions are laws: pure, and fit for machine code.
"""

import numpy as np


def delayed(line, sample):
    """Return the line after one tick, with the sample put in front; shape (n,)."""
    size = len(sample)
    following = np.zeros(len(line))
    for i in range(len(line)):
        following[i] = sample[i] if i < size else line[i - size]
    return following


def arriving(line, sample):
    """Return the sample that comes out in the next tick, shape (len(sample),)."""
    size, first = len(sample), len(line) - len(sample)
    oldest = np.zeros(size)
    for i in range(size):
        oldest[i] = sample[i] if first < 0 else line[first + i]
    return oldest
