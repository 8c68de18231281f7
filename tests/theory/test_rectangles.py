"""Rectangles on the ground."""

from math import cos, pi, sin

import numpy as np
import pytest

from lola_drake.theory.rectangles import Rectangle, common

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


@pytest.mark.parametrize("direction", [0.0, 0.7, pi / 2, 3.0, -1.2])
@pytest.mark.parametrize(("x", "y", "heading"), [(0.5, 0.2, 0.0), (-0.8, 0.1, 0.5), (0.3, -1, -1)])
def test_way_out_is_the_shortest_that_leaves_the_other_one(x, y, heading, direction):
    def moved(way):
        return Rectangle(x + way * cos(direction), y + way * sin(direction), heading, 2.0, 1.0)

    way = moved(0.0).way_out(SQUARE, direction)
    assert way > 0
    assert not moved(way).overlaps(SQUARE)
    assert moved(0.999 * way).overlaps(SQUARE)
    assert moved(way).way_out(SQUARE, direction) == 0


def test_corners_are_covered_and_what_lies_beyond_is_not():
    turned = Rectangle(1.0, 2.0, 0.4, 0.6, 0.2)
    for x, y in turned.corners():
        d_x, d_y = x - turned.x, y - turned.y
        assert turned.covers(turned.x + 0.99 * d_x, turned.y + 0.99 * d_y)
        assert not turned.covers(turned.x + 1.01 * d_x, turned.y + 1.01 * d_y)


def area(corners):
    """Return the area of a polygon by the shoelace formula."""
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return 0.5 * abs(sum(x * v - u * y for (x, y), (u, v) in pairs))


def test_what_two_rectangles_have_in_common_is_what_both_cover():
    """Against a fine grid of points, in any position and direction."""
    random = np.random.default_rng(2)
    grid = [(x, y) for x in np.linspace(-0.9, 0.9, 61) for y in np.linspace(-0.9, 0.9, 61)]
    apart = 0
    for _ in range(25):
        one, other = (
            Rectangle(
                *random.uniform(-0.2, 0.2, 2), random.uniform(0, 6), *random.uniform(0.2, 1, 2)
            )
            for _ in range(2)
        )
        corners = common(one, other)
        covered = sum(one.covers(*point) and other.covers(*point) for point in grid) * 0.03**2
        assert area(corners) == pytest.approx(covered, abs=0.02)
        apart += not corners
    assert apart < 25
