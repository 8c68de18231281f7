"""The gait's schedule: which foot does what and when, over the next few steps.

A step is a double support, in which the load moves onto the new stance foot, and then the swing of
the other foot; it ends with the planned touchdown. Everything that moves is a sum of smooth
transitions, so a schedule is a handful of numbers and can be evaluated at any times at once.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from lola_drake.theory.smooth import linear, quintic

LEFT, RIGHT = 0, 1


@dataclass
class Profile:
    """A start value and the smooth changes that follow it.

    Attributes:
        start: the value before the first change, shape (d,).
        changes: entries (time from, time to, change of the value with shape (d,)).
        transition: how a change goes from 0 to 1, see `smooth`.
    """

    start: np.ndarray
    changes: list[tuple[float, float, np.ndarray]] = field(default_factory=list)
    transition: Callable = quintic

    @property
    def end(self) -> np.ndarray:
        """Return the value after the last change."""
        return self.start + sum(change for *_, change in self.changes)

    def add(self, t_from: float, t_to: float, change: np.ndarray) -> None:
        """Append a change that begins at t_from and is complete at t_to (s)."""
        self.changes.append((t_from, t_to, np.asarray(change, dtype=float)))

    def __call__(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return value and rate, each of shape (len(time), d)."""
        begun = [change for change in self.changes if change[0] < time[-1]]
        t_from, t_to = np.array([change[:2] for change in begun]).reshape(-1, 2).T
        change = np.array([change[2] for change in begun]).reshape(-1, len(self.start))
        duration = t_to - t_from
        s, ds, _ = self.transition((time[:, None] - t_from) / duration)
        return self.start + s @ change, (ds / duration) @ change


def evaluate(
    profiles: Sequence[Profile], time: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what smooth profiles are at the given times, all of them at once.

    Much in a step changes in the same interval; each such transition is computed once.

    Args:
        profiles: with `quintic` changes.
        time: ascending (s), shape (n,).

    Returns:
        The values, rates and accelerations, one row per component of one profile after another,
        shape (d, n).
    """
    start = np.concatenate([profile.start for profile in profiles])
    shares: dict[tuple[float, float], np.ndarray] = {}
    row = 0
    for profile in profiles:
        rows = slice(row, row := row + len(profile.start))
        for t_from, t_to, change in profile.changes:
            if t_from < time[-1]:
                share = shares.setdefault((t_from, t_to), np.zeros(len(start)))
                share[rows] += change
    t_from, t_to = np.array([*shares]).reshape(-1, 2, 1).swapaxes(0, 1)
    change = np.array([*shares.values()]).reshape(-1, len(start)).T
    duration = t_to - t_from
    s, ds, dds = quintic((time - t_from) / duration)
    return start[:, None] + change @ s, change @ (ds / duration), change @ (dds / duration**2)


@dataclass(frozen=True)
class GaitTiming:
    """Times and shapes of a step; see `WalkingPatternParams` for their meaning."""

    step_time: float
    double_support: float
    last_double_support: float
    step_height: float
    step_width: float
    com_height: float
    horizontal_lead: float
    horizontal_lag: float
    plateau: float
    toe_lift: float


@dataclass
class Schedule:
    """The horizon: what every foot, the load, the heading and the CoM's height do.

    Attributes:
        foot: per foot the pose x, y, z (m), yaw (rad) of the TCP.
        toe: per foot the toe's lift (rad).
        load: the left foot's share of the load.
        heading: the torso's yaw (rad).
        height: the CoM's height (m).
        swings: entries (foot, lift-off time, touchdown time).
        path: the robot's frame on the ground x, y (m), yaw (rad) after every step.
        end: time at which the last change is complete (s).
    """

    foot: tuple[Profile, Profile]
    toe: tuple[Profile, Profile]
    load: Profile
    heading: Profile
    height: Profile
    swings: list[tuple[int, float, float]] = field(default_factory=list)
    path: list[np.ndarray] = field(default_factory=list)
    end: float = 0.0


def advance(path: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Return the frame (x, y, yaw) moved by a displacement (forward, left, turn)."""
    x, y, yaw = path
    c, s = np.cos(yaw), np.sin(yaw)
    forward, left, turn = displacement
    return np.array([x + c * forward - s * left, y + s * forward + c * left, yaw + turn])


def foothold(path: np.ndarray, foot: int, width: float) -> np.ndarray:
    """Return where a foot stands (x, y, yaw) when the robot's frame is at `path`."""
    return advance(path, np.array([0.0, width / 2 if foot == LEFT else -width / 2, 0.0]))


def make_schedule(
    timing: GaitTiming,
    feet: tuple[np.ndarray, np.ndarray],
    load: float,
    height: float,
    heading: float,
    path: np.ndarray,
    ground: float,
    swing: int,
    support: float,
    displacements: np.ndarray,
) -> Schedule:
    """Lay out steps from the present state until the robot stands again.

    Args:
        timing: times and shapes of the steps.
        feet: poses x, y, z, yaw of the left and right TCP.
        load: the left foot's present share of the load; 0.5 means standing.
        height: the CoM's present height (m).
        heading: the torso's present yaw (rad).
        path: the robot's present frame (x, y, yaw).
        ground: height at which the coming footholds are expected (m).
        swing: which foot swings first.
        support: duration of the first double support (s).
        displacements: one row (forward, left, turn) per step, shape (n, 3).

    Returns:
        The schedule, time 0 being now. The feet are side by side at its end; a closing step is
        added where that needs one.
    """
    plan = Schedule(
        foot=(Profile(feet[LEFT]), Profile(feet[RIGHT])),
        toe=(Profile(np.zeros(1)), Profile(np.zeros(1))),
        load=Profile(np.array([load]), transition=linear),
        heading=Profile(np.array([heading])),
        height=Profile(np.array([height])),
    )
    for displacement in displacements:
        path = advance(path, displacement)
        _add_step(plan, timing, support, swing, path, ground)
        support, swing = timing.double_support, 1 - swing
    if not _side_by_side(plan, timing, path, swing):
        _add_step(plan, timing, support, swing, path, ground)
    settled = plan.end + timing.last_double_support
    plan.load.add(plan.end, settled, 0.5 - plan.load.end)
    plan.end = settled
    return plan


def _side_by_side(plan: Schedule, timing: GaitTiming, path: np.ndarray, foot: int) -> bool:
    target = foothold(path, foot, timing.step_width)
    return bool(np.abs(plan.foot[foot].end[[0, 1, 3]] - target).max() < 1e-9)


def _add_step(
    plan: Schedule,
    timing: GaitTiming,
    support: float,
    swing: int,
    path: np.ndarray,
    ground: float,
) -> None:
    lift_off = plan.end + support
    touchdown = lift_off + timing.step_time - timing.double_support
    duration, middle = touchdown - lift_off, (lift_off + touchdown) / 2
    up, down = middle - timing.plateau * duration / 2, middle + timing.plateau * duration / 2
    plan.load.add(plan.end, lift_off, float(swing == RIGHT) - plan.load.end)
    foot = plan.foot[swing]
    x, y, yaw = foothold(path, swing, timing.step_width)
    stance_z = plan.foot[1 - swing].end[2]
    top = max(foot.end[2], stance_z, ground) + timing.step_height
    rise, fall = top - foot.end[2], ground - top
    horizontal = np.array([x, y, 0, yaw]) - foot.end * [1, 1, 0, 1]
    foot.add(
        lift_off + timing.horizontal_lead * duration,
        touchdown - timing.horizontal_lag * duration,
        horizontal,
    )
    foot.add(lift_off, up, np.array([0, 0, rise, 0]))
    foot.add(down, touchdown, np.array([0, 0, fall, 0]))
    plan.toe[swing].add(lift_off, up, [timing.toe_lift])
    plan.toe[swing].add(down, touchdown, [-timing.toe_lift])
    plan.heading.add(lift_off, touchdown, path[2:] - plan.heading.end)
    level = timing.com_height + (stance_z + ground) / 2
    plan.height.add(lift_off, touchdown, level - plan.height.end)
    plan.swings.append((swing, lift_off, touchdown))
    plan.path.append(path)
    plan.end = touchdown
