"""How many worlds are enough: as many as an interval needs to become narrow."""

from collections.abc import Callable
from typing import TypeVar

from lola_drake.errors import LolaError, shown

Found = TypeVar("Found")

FIRST = 10
"""Worlds after which an interval is looked at for the first time."""

GROWTH = 1.5
"""Of their number, until the next look."""


def until(width: float | None, most: int, measure: Callable[[int], tuple[Found, float]]) -> Found:
    """Return what is measured in so many worlds that the widest interval is narrow enough.

    It is looked at after 10, 15, 22 worlds and so on. To stop where it happens to be narrow makes
    an interval hold its number a little less often than 95 %; with these few looks that is little.

    Args:
        width: of the widest interval, from its low end to its high one (percentage points); None
            for all worlds.
        most: number of worlds.
        measure: returns what is found in so many worlds, and the width of its widest interval.
    """
    if width is None:
        return measure(most)[0]
    worlds = min(FIRST, most)
    while True:
        found, widest = measure(worlds)
        if widest <= width or worlds == most:
            return found
        worlds = min(most, int(GROWTH * worlds))


def parse_width(text: str) -> float:
    """Return the width that `--until 2%` means (percentage points); LolaError if it is none."""
    try:
        width = float(text.strip().removesuffix("%"))
    except ValueError:
        width = 0.0
    if not 0.1 <= width <= 100:
        raise LolaError(f"{shown(text)} is not allowed, it must be from 0.1% to 100%")
    return width
