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

    def covers(self, x: float, y: float) -> bool:
        """Return whether a point lies in it."""
        c, s = cos(self.heading), sin(self.heading)
        d_x, d_y = x - self.x, y - self.y
        along, across = c * d_x + s * d_y, c * d_y - s * d_x
        return abs(along) <= self.length / 2 and abs(across) <= self.width / 2

    def corners(self) -> list[tuple[float, float]]:
        """Return its four corners."""
        c, s = cos(self.heading), sin(self.heading)
        halves = [(i * self.length / 2, k * self.width / 2) for i in (-1, 1) for k in (-1, 1)]
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
