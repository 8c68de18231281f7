"""Where to walk: the start, planned steps, and what a user asks for over time."""

from dataclasses import dataclass
from itertools import islice
from math import radians

import numpy as np

from lola_drake.parameters import ParameterError, listing, parameter, validate


@dataclass(frozen=True)
class StartPose:
    """Where the robot stands at t = 0, in W."""

    x: float = parameter(0.0, "midpoint between the feet, x", "m", minimum=-1e3, maximum=1e3)
    y: float = parameter(0.0, "midpoint between the feet, y", "m", minimum=-1e3, maximum=1e3)
    heading_deg: float = parameter(0.0, "direction it faces", "deg", minimum=-360, maximum=360)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class StepGroup:
    """A number of equal steps; each moves the robot's frame once by length, sideways and turn.

    A foot that would come down on the other one takes a closing step in place before.
    """

    count: int = parameter(1, "how many such steps", "", minimum=1, maximum=10000)
    length: float = parameter(0.0, "forward per step", "m", minimum=-0.55, maximum=0.55)
    sideways: float = parameter(0.0, "to the left per step", "m", minimum=-0.3, maximum=0.3)
    turn_deg: float = parameter(0.0, "to the left per step", "deg", minimum=-45, maximum=45)
    height: float = parameter(0.0, "upward per step, as on stairs", "m", minimum=-0.2, maximum=0.2)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class TimedCommand:
    """What the user asks for from one time on, until the next command."""

    time: float = parameter(0.0, "from when on, simulated time", "s", minimum=0.0, maximum=3600)
    v_x: float = parameter(0.0, "forward", "m/s", minimum=-1.4, maximum=1.4)
    v_y: float = parameter(0.0, "to the left", "m/s", minimum=-0.75, maximum=0.75)
    turn_rate: float = parameter(0.0, "to the left", "rad/s", minimum=-2, maximum=2)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Walk:
    """Where to walk: planned steps, or a user's commands over time; neither means stand.

    Attributes:
        start_time: When the first of the planned steps begins.
        steps: Groups of steps, one after the other.
        command: Commands in the order of their times; before the first one the robot stands.
    """

    start_time: float = parameter(
        1.0, "when the planned steps begin", "s", minimum=0.0, maximum=3600
    )
    steps: tuple[StepGroup, ...] = listing("groups of steps, one after the other", 100)
    command: tuple[TimedCommand, ...] = listing("commands in the order of their times", 1000)

    def __post_init__(self):
        validate(self)
        times = [command.time for command in self.command]
        if self.steps and self.command:
            raise ParameterError("command", times, "empty where there are steps (give one of both)")
        if any(later <= earlier for earlier, later in zip(times, times[1:], strict=False)):
            raise ParameterError("command", times, "in the order of strictly increasing times")

    def planned(self, most: int) -> np.ndarray:
        """Return forward, left, turn, up of the planned steps, shape (n, 4), n at most `most`."""
        steps = (
            (group.length, group.sideways, radians(group.turn_deg), group.height)
            for group in self.steps
            for _ in range(group.count)
        )
        return np.array(list(islice(steps, most))).reshape(-1, 4)
