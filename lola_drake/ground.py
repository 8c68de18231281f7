"""The ground of a scenario: a floor, and boards and platforms on it."""

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

from lola_drake.feasibility import overlapping
from lola_drake.parameters import ParameterError, listing, parameter, validate
from lola_drake.theory.rectangles import Rectangle

RESERVED = ("floor",)
"""Names that the plant gives to other things than boards."""


LEVEL = 0.01
"""Boards whose tops differ by less than this carry a foot together (m)."""


@dataclass(frozen=True)
class Obstacle:
    """A board or platform that lies on the floor."""

    name: str = parameter("board", "what it is called in the model and in plots")
    position: tuple[float, float] = parameter(
        (0.0, 0.0), "x and y of its centre in W", "m", minimum=-1e3, maximum=1e3
    )
    heading_deg: float = parameter(0.0, "direction of its length", "deg", minimum=-360, maximum=360)
    size: tuple[float, float] = parameter(
        (0.4, 1.0), "length and width", "m", minimum=0.01, maximum=100
    )
    height: float = parameter(
        0.04, "height of its top over the floor", "m", minimum=0.001, maximum=1
    )
    free_shift: tuple[float, float] = parameter(
        (0.0, 0.0),
        "how far it may be moved along its length without another experiment",
        "m",
        minimum=-10,
        maximum=10,
    )

    def __post_init__(self):
        validate(self)
        if not self.name:
            raise ParameterError("name", self.name, "a text that is not empty")
        if self.name in RESERVED:
            raise ParameterError("name", self.name, "another name: this one is the floor's")
        if self.free_shift[0] > self.free_shift[1]:
            raise ParameterError("free_shift", self.free_shift, "from the least to the greatest")

    def shifted(self, distance: float) -> "Obstacle":
        """Return it moved along its length (m)."""
        heading = math.radians(self.heading_deg)
        x, y = self.position
        moved = (x + distance * math.cos(heading), y + distance * math.sin(heading))
        return dataclasses.replace(self, position=moved)

    @cached_property
    def outline(self) -> Rectangle:
        """Return what it covers of the floor."""
        return Rectangle(*self.position, math.radians(self.heading_deg), *self.size)

    def covers(self, x: float, y: float) -> bool:
        """Return whether a point of W lies over it."""
        return self.outline.covers(x, y)


@dataclass(frozen=True)
class Ground:
    """The floor at z = 0 and what lies on it, all of one material."""

    stiffness: float = parameter(
        3e5, "vertical, of one whole foot on it", "N/m", minimum=5e4, maximum=1e7
    )
    dissipation: float = parameter(
        2.5, "Hunt-Crossley dissipation", "s/m", minimum=0.0, maximum=100
    )
    friction: float = parameter(0.8, "Coulomb friction coefficient", "", minimum=0.0, maximum=2)
    friction_speed: float = parameter(
        1e-3,
        "at which friction is full; below it the pads creep (own choice, for speed: a tenth of it "
        "makes a step of the plant half again as costly)",
        "m/s",
        minimum=1e-5,
        maximum=0.1,
    )
    obstacles: tuple[Obstacle, ...] = listing("boards and platforms, none on another", 100)

    def __post_init__(self):
        validate(self)
        names = [obstacle.name for obstacle in self.obstacles]
        if len(set(names)) < len(names):
            raise ParameterError("obstacles", names, "a list in which every name differs")
        for one, other in overlapping(self.obstacles):
            # Of two heights the higher one counts; of the same, both would carry a foot.
            if abs(one.height - other.height) < LEVEL:
                both = [one.name, other.name]
                allowed = f"boards beside each other, or {LEVEL:g} m apart in height"
                raise ParameterError("obstacles", both, allowed)

    def height_at(self, x: float, y: float) -> float:
        """Return the height of the ground at a point of W (m)."""
        return max((o.height for o in self.obstacles if o.covers(x, y)), default=0.0)
