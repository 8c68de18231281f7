"""Cycles of the bus that are missed: a fault between controller, sensors and servos."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.parameters import parameter, validate
from lola_drake.signals import PERIOD


@dataclass(frozen=True)
class MissedCycles:
    """Cycles of the bus in which nothing arrives: what has arrived before still holds."""

    time: float = parameter(2.0, "of the first one", "s", minimum=0.0, maximum=3600)
    count: int = parameter(1, "of cycles in a row", "", minimum=1, maximum=1000)

    def __post_init__(self):
        validate(self)


def gaps_of(missed: Sequence[MissedCycles]) -> np.ndarray:
    """Return from when to when cycles are missed (s), shape (n, 2); halfway between ticks."""
    first = np.array([round(cycles.time / PERIOD) - 0.5 for cycles in missed])
    count = np.array([cycles.count for cycles in missed])
    return PERIOD * np.column_stack([first, first + count])


def is_missed(time, gaps):
    """Return whether a cycle of the bus is missed; a law.

    Args:
        time: of it (s).
        gaps: as from `gaps_of`.
    """
    for i in range(len(gaps)):
        if gaps[i][0] < time < gaps[i][1]:
            return True
    return False
