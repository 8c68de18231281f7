"""Boards under a part of a foot, where the plan puts it down."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lola_drake.obstacles import Laid, Obstacle
from lola_drake.parameters import ParameterError, parameter
from lola_drake.theory.footholds import SOLE

MARGIN = 0.03
"""By how much the board of a foothold goes on beyond the sole (m), but not towards the other
foot."""


@dataclass(frozen=True)
class Footprint:
    """Where a foot is planned to stand: "l" or "r", its TCP's x and y in W (m), heading (rad)."""

    foot: str
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class Foothold(Laid):
    """A board under a part of a foot, where the plan puts that foot down."""

    name: str = parameter("foothold", "what it is called in the model and in plots")
    position: tuple[float, float] = parameter(
        (0.0, 0.0), "by which it is moved, as the foot sees it", "m", minimum=-1, maximum=1
    )
    heading_deg: float = parameter(
        0.0, "by which it is turned about the middle of the part", "deg", minimum=-90, maximum=90
    )
    step: int = parameter(5, "the planned step, 1 for the first", "", minimum=1, maximum=10000)
    count: int = parameter(1, "of steps in a row, each with a board", "", minimum=1, maximum=50)
    part: str = parameter(
        "front",
        "what lies on it",
        choices=(
            "whole",
            "front",
            "heel",
            "inner",
            "outer",
            "front_inner",
            "front_outer",
            "heel_inner",
            "heel_outer",
        ),
    )
    height: float = parameter(0.06, "of its top over the floor", "m", minimum=0.001, maximum=0.5)

    def boards(self, feet: Sequence[Footprint]) -> tuple[Obstacle, ...]:
        """Return its boards under the feet of a plan.

        Raises:
            ParameterError: if the plan has not so many steps.
        """
        last = self.step + self.count - 1
        if last > len(feet):
            allowed = f"such that step {last} is one of the {len(feet)} planned steps"
            raise ParameterError("step", self.step, allowed)
        return tuple(self._under(feet[k - 1], k) for k in range(self.step, last + 1))

    def _under(self, foot: Footprint, number: int) -> Obstacle:
        (back, front), (right, left) = self._reach(foot.foot)
        place = Laid(position=(foot.x, foot.y), heading_deg=math.degrees(foot.heading))
        along, across = (back + front) / 2 + self.position[0], (right + left) / 2 + self.position[1]
        return Obstacle(
            name=f"{self.name} {number}",
            position=place._beside(along, across),
            heading_deg=place.heading_deg + self.heading_deg,
            relative_stiffness=self.relative_stiffness,
            relative_friction=self.relative_friction,
            size=(front - back, left - right),
            height=self.height,
        )

    def _reach(self, foot: str) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return from where to where the board goes in the foot's frame, along and across (m)."""
        end, side = SOLE[0] / 2 + MARGIN, SOLE[1] / 2
        back, front = 0.0 if "front" in self.part else -end, 0.0 if "heel" in self.part else end
        inner, outer = 0.0 if "outer" in self.part else -side, side + MARGIN
        if "inner" in self.part:
            outer = 0.0
        return (back, front), ((inner, outer) if foot == "l" else (-outer, -inner))
