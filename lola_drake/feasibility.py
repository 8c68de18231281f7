"""What a scenario asks of feet and ground together, and whether it can be.

Every check raises a ParameterError with the key as it stands in a scenario.
"""

import itertools
from collections.abc import Iterator, Sequence
from math import radians
from typing import TYPE_CHECKING

import numpy as np

from lola_drake.parameters import ParameterError
from lola_drake.theory.footholds import GREATEST_AGAIN, LEFT, RIGHT, foothold, reach, sole

if TYPE_CHECKING:
    from lola_drake.ground import Ground, Obstacle
    from lola_drake.scenario import StartPose, StepGroup, TimedCommand

BARELY = 1 + 1e-9
"""What is at its limit but for rounding is allowed."""

TOGETHER = "such that (length/0.55)^2 + (sideways/0.3)^2 + (turn_deg/45)^2 <= 1"


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
        covered = sole(foothold(path, foot, width))
        height = ground.height_at(covered.x, covered.y)
        under = [o for o in ground.obstacles if o.height >= height and covered.overlaps(o.outline)]
        # An edge under the sole is as bad as a board of another height.
        whole = all(o.covers(*corner) for o in under for corner in covered.corners())
        heights.add(height if whole else None)
    if len(heights) > 1:
        place = [start.x, start.y, start.heading_deg]
        raise ParameterError("start", place, "where both soles lie level, on no board's edge")


def check_steps(groups: "Sequence[StepGroup]") -> None:
    """Refuse planned steps that go too far in several ways at once."""
    for i, group in enumerate(groups):
        step = np.array([group.length, group.sideways, radians(group.turn_deg)])
        if reach(step) > BARELY:
            value = [group.length, group.sideways, group.turn_deg]
            raise ParameterError(f"walk.steps[{i}]", value, TOGETHER)


def check_command(commands: "Sequence[TimedCommand]", step_time: float) -> None:
    """Refuse a command that would need longer, wider or sharper steps than there are."""
    for i, command in enumerate(commands):
        asked = np.array([command.v_x, command.v_y, command.turn_rate])
        most = GREATEST_AGAIN / step_time
        for name, value, limit in zip(("v_x", "v_y", "turn_rate"), asked, most, strict=True):
            if abs(value) > limit * BARELY:
                allowed = f">= {-limit:.3g} and <= {limit:.3g} with {_pace(step_time)}"
                raise ParameterError(f"walk.command[{i}].{name}", float(value), allowed)
        if reach(asked * step_time, GREATEST_AGAIN) > BARELY:
            parts = zip(("v_x", "v_y", "turn_rate"), most, strict=True)
            ellipse = " + ".join(f"({name}/{limit:.3g})^2" for name, limit in parts)
            allowed = f"such that {ellipse} <= 1 with {_pace(step_time)}"
            raise ParameterError(f"walk.command[{i}]", asked.tolist(), allowed)


def _pace(step_time: float) -> str:
    return f"pattern.step_time {step_time:g} s"
