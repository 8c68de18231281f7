"""The look of the pictures of linear models: that of all figures, with more colours."""

import functools
from collections.abc import Callable

from lola_drake.figures.style import (
    FAINT,
    FIRST,
    INK,
    LEFT,
    LIMIT,
    RIGHT,
    SECOND,
    THIRD,
    look,
)

COLOURS, MAP = (LEFT, RIGHT, FIRST, SECOND, THIRD, "#E69F00"), "viridis"

__all__ = ["COLOURS", "FAINT", "INK", "LIMIT", "MAP", "in_look"]


def in_look(draw: Callable) -> Callable:
    """Let a function make its figure in the one look of all figures."""

    @functools.wraps(draw)
    def drawing(*args, **kwargs):
        with look():
            return draw(*args, **kwargs)

    return drawing
