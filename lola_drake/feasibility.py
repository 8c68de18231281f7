"""What a scenario asks of feet and ground together, and whether it can be.

Every check raises a ParameterError with the key as it stands in a scenario.
"""

from collections.abc import Sequence
from math import radians

import numpy as np

from lola_drake.ground import Ground
from lola_drake.parameters import ParameterError
from lola_drake.partial_footholds import Footprint
from lola_drake.signals import FEET
from lola_drake.theory.footholds import (
    GREATEST_AGAIN,
    LEFT,
    RIGHT,
    Walker,
    advance,
    first_foot,
    foothold,
    reach,
    sole,
    with_closing_steps,
)
from lola_drake.walk import StartPose, StepGroup, TimedCommand

BARELY = 1 + 1e-9
"""What is at its limit but for rounding is allowed."""

TOGETHER = "such that (length/0.55)^2 + (sideways/0.3)^2 + (turn_deg/45)^2 <= 1"


def footprints(start: StartPose, steps: np.ndarray, width: float) -> list[Footprint]:
    """Return where the foot of each planned step is to stand, one after the other.

    Args:
        start: where the robot stands before.
        steps: forward, left, turn, up of each, shape (n, 4).
        width: distance of the feet (m).
    """
    if not len(steps):
        return []
    origin, found = np.array([start.x, start.y, radians(start.heading_deg)]), []
    walker = Walker(width, first_foot(steps[0], width, LEFT))
    for step in with_closing_steps(steps, width):
        foot = walker.swing
        walker.take(step)
        found.append(Footprint(FEET[foot], *advance(origin, walker.feet[foot]).tolist()))
    return found


def check_start(start: StartPose, width: float, ground: Ground) -> None:
    """Refuse a start at which both feet, and what is between them, are not level."""
    path = np.array([start.x, start.y, radians(start.heading_deg)])
    heights: set[float | None] = {ground.height_at(start.x, start.y)}
    for foot in (LEFT, RIGHT):
        covered = sole(foothold(path, foot, width))
        height = ground.height_at(covered.x, covered.y)
        near = [board for board in ground.boards if covered.overlaps(board.outline)]
        under = [board for board in near if board.height >= height or not board.level]
        # An edge under the sole is as bad as a board of another height.
        whole = all(
            board.level and board.covers(*corner) for board in under for corner in covered.corners()
        )
        heights.add(height if whole else None)
    if len(heights) > 1:
        place = [start.x, start.y, start.heading_deg]
        raise ParameterError("start", place, "where both soles lie level, on no board's edge")


def check_steps(groups: Sequence[StepGroup]) -> None:
    """Refuse planned steps that go too far in several ways at once."""
    for i, group in enumerate(groups):
        step = np.array([group.length, group.sideways, radians(group.turn_deg)])
        if reach(step) > BARELY:
            value = [group.length, group.sideways, group.turn_deg]
            raise ParameterError(f"walk.steps[{i}]", value, TOGETHER)


def check_command(commands: Sequence[TimedCommand], step_time: float) -> None:
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
