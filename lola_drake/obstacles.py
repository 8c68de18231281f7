"""What can be laid on the floor of a scenario: boards, stairs, fields of boards.

Everything is made of boards, `Obstacle`; the others are short ways to say many of them.
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lola_drake.parameters import ParameterError, parameter, validate
from lola_drake.theory.rectangles import Rectangle

RESERVED = ("floor",)
"""Names that the plant gives to other things than boards."""

THINNEST = 0.02
"""Thickness of the thinnest board (m) as stiff as the ground; its lower part is in the floor.

A box is a field of springs only to half its depth, and in soft ground feet sink in deep."""

BOARDS = 500
"""The greatest number of boards in one field."""

WOOD, FOAM, ICE = (0.72, 0.53, 0.34), (0.45, 0.62, 0.42), (0.55, 0.74, 0.86)
"""Colours of what is as the ground, soft, and slippery (red, green, blue)."""


@dataclass(frozen=True)
class Laid:
    """What everything has that lies on the floor: name, place and material."""

    name: str = parameter("board", "what it is called in the model and in plots")
    position: tuple[float, float] = parameter(
        (0.0, 0.0), "x and y of its centre in W", "m", minimum=-1e3, maximum=1e3
    )
    heading_deg: float = parameter(0.0, "direction of its length", "deg", minimum=-360, maximum=360)
    free_shift: tuple[float, float] = parameter(
        (0.0, 0.0),
        "how far it may be moved along its length without another experiment",
        "m",
        minimum=-10,
        maximum=10,
    )
    relative_stiffness: float = parameter(
        1.0, "stiffness over the ground's; below 1 it is soft", "", minimum=0.02, maximum=10
    )
    relative_friction: float = parameter(
        1.0, "friction over the ground's; below 1 it is slippery", "", minimum=0.01, maximum=1
    )

    def __post_init__(self):
        validate(self)
        if not self.name:
            raise ParameterError("name", self.name, "a text that is not empty")
        if self.name in RESERVED:
            raise ParameterError("name", self.name, "another name: this one is the floor's")
        if self.free_shift[0] > self.free_shift[1]:
            raise ParameterError("free_shift", self.free_shift, "from the least to the greatest")

    def shifted(self, distance: float) -> "Laid":
        """Return it moved along its length (m)."""
        return dataclasses.replace(self, position=self._beside(distance, 0.0))

    def _beside(self, along: float, across: float) -> tuple[float, float]:
        """Return a place that lies so far along its length and to the left of its centre (m)."""
        c, s = (f(math.radians(self.heading_deg)) for f in (math.cos, math.sin))
        x, y = self.position
        return x + c * along - s * across, y + s * along + c * across

    def _part(self, number: int, along: float, across: float, **changes) -> "Obstacle":
        """Return one of the boards that it is made of."""
        return Obstacle(
            name=f"{self.name} {number}",
            position=self._beside(along, across),
            heading_deg=self.heading_deg,
            relative_stiffness=self.relative_stiffness,
            relative_friction=self.relative_friction,
            **changes,
        )


@dataclass(frozen=True)
class Obstacle(Laid):
    """A board, platform, patch or slope on the floor, as in `RollPitchYaw(roll, pitch, heading)`.

    Positive pitch: its front is lower. Positive roll: its left is higher.
    """

    size: tuple[float, float] = parameter(
        (0.4, 1.0), "length and width, seen from above", "m", minimum=0.01, maximum=100
    )
    height: float = parameter(
        0.04, "height of its top over the floor, in its middle", "m", minimum=0.001, maximum=2
    )
    pitch_deg: float = parameter(
        0.0, "inclination along its length, down ahead", "deg", minimum=-30, maximum=30
    )
    roll_deg: float = parameter(
        0.0, "inclination across it, up to the left", "deg", minimum=-30, maximum=30
    )

    @property
    def boards(self) -> "tuple[Obstacle, ...]":
        """Return the boards that it is made of: itself."""
        return (self,)

    @property
    def level(self) -> bool:
        """Return whether its top is level."""
        return self.pitch_deg == 0.0 == self.roll_deg

    @property
    def colour(self) -> tuple[float, float, float]:
        """Return the colour it is drawn in (red, green, blue)."""
        soft = FOAM if self.relative_stiffness < 1.0 else WOOD
        return ICE if self.relative_friction < 1.0 else soft

    @cached_property
    def outline(self) -> Rectangle:
        """Return what it covers of the floor."""
        return Rectangle(*self.position, math.radians(self.heading_deg), *self.size)

    @cached_property
    def normal(self) -> tuple[float, float, float]:
        """Return the unit vector in W that is normal to its top."""
        heading, pitch, roll = map(math.radians, (self.heading_deg, self.pitch_deg, self.roll_deg))
        ahead, left = math.cos(roll) * math.sin(pitch), -math.sin(roll)
        c, s = math.cos(heading), math.sin(heading)
        return c * ahead - s * left, s * ahead + c * left, math.cos(roll) * math.cos(pitch)

    @cached_property
    def extent(self) -> tuple[float, float, float]:
        """Return length, width and thickness of the box (m): it reaches into the floor.

        Inclined about both axes, it covers its outline to a few millimetres.
        """
        length = self.size[0] / math.cos(math.radians(self.pitch_deg))
        width = self.size[1] / math.cos(math.radians(self.roll_deg))
        highest = max(self.height_at(x, y) for x, y in self.outline.corners())
        return length, width, max(highest, THINNEST / self.relative_stiffness)

    def covers(self, x, y):
        """Return whether a point of W lies over it; also for arrays of points."""
        return self.outline.covers(x, y)

    def height_at(self, x, y):
        """Return the height (m) of the plane of its top at a point of W; also for arrays."""
        n_x, n_y, n_z = self.normal
        d_x, d_y = x - self.position[0], y - self.position[1]
        return self.height - (n_x * d_x + n_y * d_y) / n_z


@dataclass(frozen=True)
class Stairs(Laid):
    """Steps up to a landing and as many down again, all of the same height."""

    name: str = parameter("stairs", "what they are called in the model and in plots")
    position: tuple[float, float] = parameter(
        (1.0, 0.0), "x and y of the middle of the first edge in W", "m", minimum=-1e3, maximum=1e3
    )
    rises: int = parameter(3, "steps up, and down again", "", minimum=1, maximum=50)
    rise: float = parameter(0.04, "height of a step", "m", minimum=0.01, maximum=0.3)
    tread: float = parameter(0.3333, "length of a step", "m", minimum=0.1, maximum=10)
    landing: float = parameter(0.6666, "length of the highest step", "m", minimum=0.1, maximum=100)
    width: float = parameter(1.2, "of all steps", "m", minimum=0.1, maximum=100)

    @cached_property
    def boards(self) -> tuple[Obstacle, ...]:
        """Return the boards that they are made of, each on the one before."""
        whole = self._length
        return tuple(
            self._part(
                k + 1,
                whole / 2,
                0.0,
                size=(whole - 2 * k * self.tread, self.width),
                height=(k + 1) * self.rise,
            )
            for k in range(self.rises)
        )

    @property
    def outline(self) -> Rectangle:
        """Return what they cover of the floor."""
        return self.boards[0].outline

    @property
    def _length(self) -> float:
        return self.landing + 2 * (self.rises - 1) * self.tread

    def __post_init__(self):
        super().__post_init__()
        if self.rises * self.rise > 2.0:
            raise ParameterError("rise", self.rise, f"<= {2.0 / self.rises:.4g} m for {self.rises}")


@dataclass(frozen=True)
class Field(Laid):
    """Boards side by side, of heights and inclinations that are drawn at random."""

    name: str = parameter("field", "what it is called in the model and in plots")
    position: tuple[float, float] = parameter(
        (1.0, 0.0), "x and y of the middle of its first edge in W", "m", minimum=-1e3, maximum=1e3
    )
    size: tuple[float, float] = parameter(
        (6.0, 1.2), "length and width", "m", minimum=0.1, maximum=100
    )
    board: tuple[float, float] = parameter(
        (0.4, 0.3), "length and width of a board, about", "m", minimum=0.05, maximum=100
    )
    height: float = parameter(
        0.04, "of the boards over the floor, on average", "m", minimum=0.001, maximum=1
    )
    spread: float = parameter(
        0.03, "by how much a board may be higher or lower", "m", minimum=0.0, maximum=0.5
    )
    tilt_deg: float = parameter(
        0.0, "by how much a board may pitch and roll", "deg", minimum=0.0, maximum=20
    )
    seed: int = parameter(
        0, "of the heights; each sampled world has its own", "", minimum=0, maximum=1_000_000_000
    )

    def __post_init__(self):
        super().__post_init__()
        if self.height - self.spread < 0.001:
            raise ParameterError("spread", self.spread, f"<= height {self.height:g} m less 1 mm")
        if math.prod(self._numbers) > BOARDS:
            raise ParameterError(
                "board", list(self.board), f"so large that {BOARDS} cover the field"
            )

    @property
    def _numbers(self) -> tuple[int, int]:
        """Return how many boards lie along it, and how many across."""
        (length, width), (along, across) = self.size, self.board
        return max(round(length / along), 1), max(round(width / across), 1)

    @property
    def outline(self) -> Rectangle:
        """Return what it covers of the floor."""
        middle = self._beside(self.size[0] / 2, 0.0)
        return Rectangle(*middle, math.radians(self.heading_deg), *self.size)

    @cached_property
    def boards(self) -> tuple[Obstacle, ...]:
        """Return the boards that it is made of."""
        n, m = self._numbers
        length, width = self.size[0] / n, self.size[1] / m
        draws = np.random.default_rng(self.seed).uniform(-1.0, 1.0, (n * m, 3)).tolist()
        return tuple(
            self._part(
                k + 1,
                (k // m + 0.5) * length,
                (k % m + 0.5) * width - self.size[1] / 2,
                size=(length, width),
                height=self.height + self.spread * up,
                pitch_deg=self.tilt_deg * pitch,
                roll_deg=self.tilt_deg * roll,
            )
            for k, (up, pitch, roll) in enumerate(draws)
        )
