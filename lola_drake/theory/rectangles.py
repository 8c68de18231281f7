"""Rectangles on the ground, such as boards and soles, and whether they lie on each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, sin

TOUCH = 1e-4
"""Rectangles that share less than this (m) lie beside each other: their edges may be rounded."""


@dataclass(frozen=True)
class Rectangle:
    """A rectangle: its centre (m), the direction of its length (rad), length and width (m)."""

    x: float
    y: float
    heading: float
    length: float
    width: float

    def covers(self, x, y):
        """Return whether a point lies in it; also for arrays of points."""
        c, s = cos(self.heading), sin(self.heading)
        d_x, d_y = x - self.x, y - self.y
        along, across = c * d_x + s * d_y, c * d_y - s * d_x
        return (abs(along) <= self.length / 2) & (abs(across) <= self.width / 2)

    def corners(self) -> list[tuple[float, float]]:
        """Return its four corners, one after the other around it."""
        c, s = cos(self.heading), sin(self.heading)
        around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        halves = [(i * self.length / 2, k * self.width / 2) for i, k in around]
        return [(self.x + c * a - s * b, self.y + s * a + c * b) for a, b in halves]

    def overlaps(self, other: "Rectangle") -> bool:
        """Return whether both have a part in common: no side of one keeps the other out."""
        return all(
            max(mine) - min(its) >= TOUCH and max(its) - min(mine) >= TOUCH
            for _, mine, its in self._shadows(other)
        )

    def way_out(self, other: "Rectangle", direction: float) -> float:
        """Return how far it has to be moved in a direction (rad) until it lies beside the other.

        It is 0 where they do not overlap.
        """
        if not self.overlaps(other):
            return 0.0
        ways = []
        for (u, v), mine, its in self._shadows(other):
            along = u * cos(direction) + v * sin(direction)
            if abs(along) > TOUCH:
                to_go = max(its) - min(mine) if along > 0 else max(mine) - min(its)
                ways.append(to_go / abs(along))
        return min(ways)

    def _shadows(self, other: "Rectangle") -> Iterator[tuple[tuple, list[float], list[float]]]:
        """Yield both rectangles' corners as seen along each of their sides, with its direction."""
        corners = self.corners(), other.corners()
        for rectangle in (self, other):
            c, s = cos(rectangle.heading), sin(rectangle.heading)
            for u, v in ((c, s), (-s, c)):
                mine, its = ([u * x + v * y for x, y in points] for points in corners)
                yield (u, v), mine, its


def common(one: Rectangle, other: Rectangle) -> list[tuple[float, float]]:
    """Return the corners of what two rectangles have in common, none if they have nothing.

    The first is cut along each side of the second (Sutherland and Hodgman).
    """
    corners = one.corners()
    c, s = cos(other.heading), sin(other.heading)
    for u, v, reach in (
        (c, s, other.length / 2),
        (-c, -s, other.length / 2),
        (-s, c, other.width / 2),
        (s, -c, other.width / 2),
    ):
        beyond = [u * (x - other.x) + v * (y - other.y) - reach for x, y in corners]
        kept = []
        for i, (x, y) in enumerate(corners):
            if beyond[i] * beyond[i - 1] < 0.0:
                part = beyond[i] / (beyond[i] - beyond[i - 1])
                kept.append(
                    (x + part * (corners[i - 1][0] - x), y + part * (corners[i - 1][1] - y))
                )
            if beyond[i] <= 0.0:
                kept.append((x, y))
        corners = kept
    return corners
