"""Rectangles on the ground."""

from math import pi

import pytest

from lola_drake.theory.rectangles import Rectangle

SQUARE = Rectangle(0.0, 0.0, 0.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("other", "overlap"),
    [
        (Rectangle(0.5, 0.5, 0.3, 0.1, 0.1), True),
        (Rectangle(1.9, 0.0, 0.0, 2.0, 2.0), True),
        (Rectangle(2.0, 0.0, 0.0, 2.0, 2.0), False),
        (Rectangle(2.0 - 1e-9, 0.0, 0.0, 2.0, 2.0), False),
        (Rectangle(0.0, 0.0, pi / 4, 9.0, 0.1), True),
        # Its corners lie between those of the square, but its side keeps off.
        (Rectangle(1.6, 1.6, -pi / 4, 4.0, 1.0), False),
        (Rectangle(1.3, 1.3, -pi / 4, 4.0, 1.0), True),
    ],
)
def test_overlap(other, overlap):
    assert SQUARE.overlaps(other) is other.overlaps(SQUARE) is overlap


def test_corners_are_covered_and_what_lies_beyond_is_not():
    turned = Rectangle(1.0, 2.0, 0.4, 0.6, 0.2)
    for x, y in turned.corners():
        d_x, d_y = x - turned.x, y - turned.y
        assert turned.covers(turned.x + 0.99 * d_x, turned.y + 0.99 * d_y)
        assert not turned.covers(turned.x + 1.01 * d_x, turned.y + 1.01 * d_y)
