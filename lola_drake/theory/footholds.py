"""Where the feet come down: never one on the other, whatever is asked for.

Soles are nearly as wide as the feet are apart, so a foot cannot follow the other one sideways, and
one that is turned needs room. Three rules keep them apart (own choice): the foot on the side to
which it goes sets out first, the other one then closes; and a foothold is moved outward as far as
the sole needs it.
"""

from collections.abc import Iterator

import numpy as np

from lola_drake.theory.rectangles import Rectangle

LEFT, RIGHT = 0, 1

SOLE = (0.27, 0.22)
"""Length and width of a foot over its pads (m)."""

GAP = 0.005
"""What is left between the soles where a foothold has to be moved (m)."""

NARROW = 0.02
"""By how much the foot that follows may be moved outward; for more, it closes first (m)."""

MOST_OPEN = np.deg2rad(40.0)
"""How far a foot may be turned against the other one (rad): the hips' stops are 24 deg each."""

FORWARD, SIDEWAYS, TURN, UP = range(4)
"""Columns of steps: forward, left (m), turn to the left (rad), up (m)."""

GREATEST = np.array([0.55, 0.3, np.deg2rad(45.0)])
"""The greatest step forward, sideways (m), and in turn (rad); what is asked of one has to leave
room for the others: their squares, each relative to its greatest, add up to 1 at most."""

GREATEST_AGAIN = np.array([0.45, 0.15, np.deg2rad(22.5)])
"""The same of steps that are walked again and again: sideways and in turn, one foot of two takes
all; forward it is what reaches no joint's limit (0.48 m do)."""


def advance(path: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Return the frame (x, y, yaw) moved by a displacement (forward, left, turn)."""
    x, y, yaw = path
    c, s = np.cos(yaw), np.sin(yaw)
    forward, left, turn = displacement
    return np.array([x + c * forward - s * left, y + s * forward + c * left, yaw + turn])


def foothold(path: np.ndarray, foot: int, width: float) -> np.ndarray:
    """Return where a foot stands (x, y, yaw) when the robot's frame is at `path`."""
    return advance(path, np.array([0.0, width / 2 if foot == LEFT else -width / 2, 0.0]))


def sole(place: np.ndarray) -> Rectangle:
    """Return what a foot at x, y, yaw covers of the ground."""
    x, y, yaw = place.tolist()
    return Rectangle(x, y, yaw, *SOLE)


def room_needed(
    place: np.ndarray, foot: int, standing: np.ndarray, yaw: float | None = None
) -> float:
    """Return how far outward a foot has to be moved to be clear of the one that stands (m).

    Args:
        place: of the foot: x, y, yaw.
        foot: which one it is.
        standing: x, y, yaw of the other one.
        yaw: against which outward is to the side (rad); that of the foot unless given.
    """
    outward = (place[2] if yaw is None else yaw) + (np.pi / 2 if foot == LEFT else -np.pi / 2)
    way = sole(place).way_out(sole(standing), outward)
    return way + GAP if way > 0 else 0.0


def detour(places: np.ndarray, detours: np.ndarray, foot: int, standing: np.ndarray) -> float:
    """Return by how much a foot has to swing outward of the standing one, to pass it (m).

    Args:
        places: x, y, yaw along the direct way, shape (n, 3).
        detours: which part of the detour is made in each of them, shape (n,).
        foot: which one it is.
        standing: x, y, yaw of the other one.
    """
    forward = np.array([np.cos(standing[2]), np.sin(standing[2])])
    left = (places[:, :2] - standing[:2]) @ [-forward[1], forward[0]]
    beside = np.abs(left).min() >= SOLE[1] and not np.ptp(np.append(places[:, 2], standing[2]))
    if beside:
        return 0.0
    rooms = [room_needed(place, foot, standing, standing[2]) for place in places]
    return max(room / part for room, part in zip(rooms, detours, strict=True))


def clear_foothold(path: np.ndarray, foot: int, width: float, standing: np.ndarray) -> np.ndarray:
    """Return where a foot comes down (x, y, yaw), clear of the other one that stands.

    It is turned against the other one by no more than the hips allow.
    """
    x, y, yaw = foothold(path, foot, width)
    turned = min(max(yaw, standing[2] - MOST_OPEN), standing[2] + MOST_OPEN)
    place = np.array([x, y, turned])
    room = room_needed(place, foot, standing)
    return advance(place, np.array([0.0, room if foot == LEFT else -room, 0.0])) if room else place


def outer_foot(step: np.ndarray) -> int:
    """Return the foot on the side to which a step goes, or else turns."""
    return LEFT if (step[SIDEWAYS] or step[TURN]) > 0 else RIGHT


class Walker:
    """Two feet that take steps on the ground, without time; to find out how they come down.

    Attributes:
        path: the robot's frame x, y (m), yaw (rad).
        feet: x, y, yaw of the left and the right foot.
        swing: the foot that goes next.
    """

    def __init__(self, width: float, swing: int = LEFT):
        """Stand at the origin."""
        self.width, self.swing, self.path = width, swing, np.zeros(3)
        self.feet = [foothold(self.path, foot, width) for foot in (LEFT, RIGHT)]

    def follows(self, step: np.ndarray) -> bool:
        """Return whether the foot that goes next would come upon the other one."""
        if not (step[SIDEWAYS] or step[TURN]) or self.swing == outer_foot(step):
            return False
        place = foothold(advance(self.path, step[:UP]), self.swing, self.width)
        return room_needed(place, self.swing, self.feet[1 - self.swing]) > NARROW

    def take(self, step: np.ndarray) -> None:
        """Take one step."""
        self.path = advance(self.path, step[:UP])
        standing = self.feet[1 - self.swing]
        self.feet[self.swing] = clear_foothold(self.path, self.swing, self.width, standing)
        self.swing = 1 - self.swing


def first_foot(step: np.ndarray, width: float, swing: int) -> int:
    """Return which foot takes the first step: `swing`, unless it would have to follow."""
    return 1 - swing if Walker(width, swing).follows(step) else swing


def with_closing_steps(steps: np.ndarray, width: float) -> np.ndarray:
    """Return steps with one in place before each that would put a foot on the other one.

    Args:
        steps: forward, left, turn, up of each, shape (n, 4).
        width: distance of the feet (m).
    """
    return np.array(list(_closing(steps, width))).reshape(-1, 4)


def _closing(steps: np.ndarray, width: float) -> Iterator[np.ndarray]:
    if len(steps):
        walker = Walker(width, first_foot(steps[0], width, LEFT))
    for step in steps:
        if walker.follows(step):
            yield np.zeros(4)
            walker.take(np.zeros(4))
        yield step
        walker.take(step)


def reach(step: np.ndarray, greatest: np.ndarray = GREATEST) -> float:
    """Return how far a step goes (forward, left, turn), 1 being as far as steps go."""
    return float(np.linalg.norm(step[:UP] / greatest))


def limited_step(step: np.ndarray) -> np.ndarray:
    """Return a step that is walked again and again, shortened to what the feet can do."""
    return step / max(reach(step, GREATEST_AGAIN), 1.0)


def paired_steps(step: np.ndarray, swing: int, count: int, width: float) -> np.ndarray:
    """Return steps of the same mean displacement that put no foot on the other one.

    Where equal steps would, the outer foot takes what is asked of both sideways and in turn, and
    the other one closes.

    Args:
        step: forward, left, turn, up that is wanted of each.
        swing: the foot that goes first.
        count: how many.
        width: distance of the feet (m).

    Returns:
        The steps, shape (count, 4).
    """
    steps = np.tile(step, (count, 1))
    if Walker(width, 1 - outer_foot(step)).follows(step):
        feet = (swing + np.arange(count)) % 2
        for column in (SIDEWAYS, TURN):
            outer = LEFT if step[column] > 0 else RIGHT
            steps[:, column] *= 2 * (feet == outer)
    return steps
