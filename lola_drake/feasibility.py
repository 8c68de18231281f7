"""What a scenario asks of feet and ground together, and whether it can be.

Every check raises a ParameterError with the key as it stands in a scenario.
"""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from math import radians
from typing import TYPE_CHECKING

import numpy as np

from lola_drake.parameters import ParameterError
from lola_drake.theory.gait import LEFT, RIGHT, advance, foothold
from lola_drake.theory.rectangles import Rectangle

if TYPE_CHECKING:
    from lola_drake.ground import Ground, Obstacle
    from lola_drake.scenario import StartPose, StepGroup, TimedCommand

SOLE = (0.27, 0.22)
"""Length and width of a foot over its pads (m)."""

CLOSE = 0.02
"""By how much soles may be smaller for the planned steps: turned feet come close (m)."""

STEP = {"length": 0.55, "sideways": 0.3, "turn": radians(45.0)}
"""The greatest step: forward and to the side (m), and turn (rad)."""

LOOKED_AT = 4
"""Equal steps after which nothing new comes."""


def overlapping(obstacles: "Sequence[Obstacle]") -> "Iterator[tuple[Obstacle, Obstacle]]":
    """Return all pairs of obstacles of which one lies on the other."""
    for one, other in itertools.combinations(obstacles, 2):
        if one.outline.overlaps(other.outline):
            yield one, other


def check_start(start: "StartPose", width: float, ground: "Ground") -> None:
    """Refuse a start at which both feet, and what is between them, are not level."""
    path = np.array([start.x, start.y, radians(start.heading_deg)])
    heights: set[float | None] = {ground.height_at(start.x, start.y)}
    for foot in (LEFT, RIGHT):
        sole = _sole(path, foot, width)
        height = ground.height_at(sole.x, sole.y)
        under = [o for o in ground.obstacles if o.height >= height and sole.overlaps(o.outline)]
        # An edge under the sole is as bad as a board of another height.
        whole = all(o.covers(*corner) for o in under for corner in sole.corners())
        heights.add(height if whole else None)
    if len(heights) > 1:
        place = [start.x, start.y, start.heading_deg]
        raise ParameterError("start", place, "where both soles lie level, on no board's edge")


def check_steps(groups: "Sequence[StepGroup]", width: float) -> None:
    """Refuse planned steps that put a foot on the other one."""
    steps, owners = [], []
    for i, group in enumerate(groups):
        step = (group.length, group.sideways, radians(group.turn_deg))
        # An even number is left out, so that left and right stay what they are.
        count = group.count if group.count <= LOOKED_AT else LOOKED_AT + group.count % 2
        steps += [step] * count
        owners += [i] * count
    bad = _colliding(steps, width)
    if bad is not None:
        group = groups[owners[bad]]
        value = [group.length, group.sideways, group.turn_deg]
        allowed = f"steps with the feet beside each other, pattern.step_width is {width:g} m"
        raise ParameterError(f"walk.steps[{owners[bad]}]", value, allowed)


def check_command(commands: "Sequence[TimedCommand]", step_time: float, width: float) -> None:
    """Refuse a command that would need longer, wider or sharper steps than there are."""
    for i, command in enumerate(commands):
        asked = (command.v_x, command.v_y, command.turn_rate)
        names = zip(("v_x", "v_y", "turn_rate"), asked, STEP.values(), strict=True)
        for name, value, greatest in names:
            most = greatest / step_time
            if abs(value) > most:
                allowed = f">= {-most:.3g} and <= {most:.3g} with pattern.step_time {step_time:g} s"
                raise ParameterError(f"walk.command[{i}].{name}", value, allowed)
        v_x, v_y, turn_rate = asked
        step = (v_x * step_time, v_y * step_time, turn_rate * step_time)
        if _colliding([step] * LOOKED_AT, width) is not None:
            allowed = f"steps with the feet beside each other, pattern.step_width is {width:g} m"
            raise ParameterError(f"walk.command[{i}]", list(asked), allowed)


def _colliding(steps: Iterable[tuple[float, float, float]], width: float) -> int | None:
    """Return the first step whose foot lands on the other one, None if none does."""
    path, swing = np.zeros(3), LEFT
    standing = _sole(path, RIGHT, width, CLOSE)
    for i, step in enumerate(steps):
        path = advance(path, np.array(step))
        landed = _sole(path, swing, width, CLOSE)
        if landed.overlaps(standing):
            return i
        standing, swing = landed, 1 - swing
    return None


def _sole(path: np.ndarray, foot: int, width: float, smaller: float = 0.0) -> Rectangle:
    """Return a foot's sole, smaller by some length (m), when the robot's frame is at `path`."""
    x, y, heading = foothold(path, foot, width)
    return Rectangle(x, y, heading, SOLE[0] - smaller, SOLE[1] - smaller)
