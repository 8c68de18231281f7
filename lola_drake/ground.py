"""The ground of a scenario: a floor, and boards, slopes, stairs and fields on it."""

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lola_drake.obstacles import Field, Obstacle, Stairs
from lola_drake.parameters import ParameterError, listing, parameter, validate
from lola_drake.partial_footholds import Foothold, Footprint
from lola_drake.theory.rectangles import common

LEVEL = 0.01
"""Boards whose tops differ by less than this carry a foot together (m)."""

_ROUNDING = 1e-9


class Surface(NamedTuple):
    """The ground at some points: height (m), shape (n,); unit normal in W, (n, 3); friction."""

    height: np.ndarray
    normal: np.ndarray
    friction: np.ndarray


@dataclass(frozen=True)
class Ground:
    """The floor at z = 0 and what lies on it."""

    stiffness: float = parameter(
        3e5, "vertical, of one whole foot on it", "N/m", minimum=5e4, maximum=1e7
    )
    dissipation: float = parameter(
        2.5, "Hunt-Crossley dissipation", "s/m", minimum=0.0, maximum=100
    )
    friction: float = parameter(0.8, "Coulomb friction coefficient", "", minimum=0.0, maximum=1.5)
    friction_speed: float = parameter(
        1e-3,
        "at which friction is full; below it the pads creep (own choice, for speed: a tenth of it "
        "makes a step of the plant half again as costly)",
        "m/s",
        minimum=1e-5,
        maximum=0.1,
    )
    obstacles: tuple[Obstacle, ...] = listing("boards, platforms, patches and slopes", 500)
    stairs: tuple[Stairs, ...] = listing("steps up and down again", 20)
    fields: tuple[Field, ...] = listing("boards of random height, side by side", 20)
    footholds: tuple[Foothold, ...] = listing("boards under a part of a planned foothold", 100)

    def __post_init__(self):
        validate(self)
        names = [board.name for board in self.boards]
        if len(set(names)) < len(names):
            twice = [name for name in names if names.count(name) > 1]
            raise ParameterError("obstacles", twice, "a list in which every name differs")
        for one, other in self._overlapping():
            # Of two heights the higher one counts; of the same, both would carry a foot.
            corners = common(one.outline, other.outline)
            above = [one.height_at(x, y) - other.height_at(x, y) for x, y in corners]
            least = LEVEL - _ROUNDING
            if above and min(above) < least and max(above) > -least:
                both = [one.name, other.name]
                allowed = f"boards beside each other, or {LEVEL:g} m apart in height"
                raise ParameterError("obstacles", both, allowed)

    def _overlapping(self) -> Iterator[tuple[Obstacle, Obstacle]]:
        """Yield all pairs of boards of which one lies on the other, of what is declared apart."""
        for one, other in itertools.combinations(self._declared, 2):
            if one.outline.overlaps(other.outline):
                for a, b in itertools.product(one.boards, other.boards):
                    if a.outline.overlaps(b.outline):
                        yield a, b

    @property
    def _declared(self) -> tuple[Obstacle | Stairs | Field, ...]:
        return self.obstacles + self.stairs + self.fields

    @cached_property
    def boards(self) -> tuple[Obstacle, ...]:
        """Return everything that lies on the floor, but what is under footholds; see `laid`."""
        return tuple(board for laid in self._declared for board in laid.boards)

    def laid(self, feet: Sequence[Footprint]) -> "Ground":
        """Return the ground with boards under the footholds of a plan.

        Raises:
            ParameterError: if the plan has no such step, or a board lies on another.
        """
        if not self.footholds:
            return self
        found: list[Obstacle] = []
        for i, foothold in enumerate(self.footholds):
            try:
                found += foothold.boards(feet)
            except ParameterError as error:
                raise error.under(f"footholds[{i}]") from None
        return dataclasses.replace(self, obstacles=(*self.obstacles, *found), footholds=())

    def height_at(self, x: float, y: float) -> float:
        """Return the height of the ground at a point of W (m)."""
        return max((0.0, *(b.height_at(x, y) for b in self.boards if b.covers(x, y))))

    def surface(self, points: np.ndarray) -> Surface:
        """Return the ground at points of W (m), shape (n, 2)."""
        x, y = np.asarray(points).T
        height, friction = np.zeros(len(x)), np.full(len(x), self.friction)
        normal = np.tile([0.0, 0.0, 1.0], (len(x), 1))
        for board in self.boards:
            top = board.height_at(x, y)
            highest = board.covers(x, y) & (top > height)
            height[highest], normal[highest] = top[highest], board.normal
            friction[highest] = board.relative_friction * self.friction
        return Surface(height, normal, friction)
