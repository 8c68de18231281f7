"""The gait's schedule: which foot does what and when, over the next few steps.

A step is a double support, in which the load moves onto the new stance foot, and then the swing of
the other foot; it ends with the planned touchdown. Everything that moves is a sum of smooth
transitions, so a schedule is a handful of numbers and can be evaluated at any times at once.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lola_drake.theory.footholds import (
    LEFT,
    MOST_OPEN,
    RIGHT,
    UP,
    advance,
    clear_foothold,
    detour,
    foothold,
)
from lola_drake.theory.smooth import linear, quintic

FOOT, TOE, HEADING, HEIGHT, PITCH = (slice(0, 4), slice(4, 8)), (8, 9), 10, 11, (12, 13)
"""Where a schedule's motion has the feet's poses, the toes' lifts, the yaw, the CoM's height and
the feet's pitch."""

MOTION_SIZE = 14

PITCH_PER_RISE = 2.0
"""How far a swing foot's heel is lifted over its toe for what it has to rise or to go down (rad/m):
were it kept level, the ankle would meet its stop, of a leg that is bent so much, or that lags
behind a body that already goes down (the angle is our own choice)."""

TOE_AXIS = 0.045
"""How far the toe's axis lies ahead of the TCP in the robot's model, an estimate (m)."""

PLACE = [0, 1, 3]
"""Where a foot's pose has x, y and yaw."""

MOST_TURNED = MOST_OPEN / 2
"""How far the torso may be turned against the stance foot (rad)."""


@dataclass
class Profile:
    """A start value and the smooth changes that follow it.

    Attributes:
        start: the value before the first change, shape (d,).
        changes: entries (time from, time to, change of the value with shape (d,)).
        transition: how a change goes from 0 to 1, see `smooth`.
        end: the value after the last change, shape (d,).
    """

    start: np.ndarray
    changes: list[tuple[float, float, np.ndarray]] = field(default_factory=list)
    transition: Callable = quintic
    end: np.ndarray = field(init=False)

    def __post_init__(self):
        self.end = self.start

    def add(self, t_from: float, t_to: float, change: np.ndarray) -> None:
        """Append a change that begins at t_from and is complete at t_to (s)."""
        change = np.asarray(change, dtype=float)
        self.changes.append((t_from, t_to, change))
        self.end = self.end + change

    def __call__(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return value, rate and acceleration at ascending times, each of shape (d, len(time))."""
        begun = [change for change in self.changes if change[0] < time[-1]]
        t_from, t_to = np.array([change[:2] for change in begun]).reshape(-1, 2).T
        change = np.array([change[2] for change in begun]).reshape(-1, len(self.start)).T
        duration = t_to - t_from
        s, ds, dds = self.transition((time - t_from[:, None]) / duration[:, None])
        rate, acceleration = change / duration @ ds, change / duration**2 @ dds
        return self.start[:, None] + change @ s, rate, acceleration


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
    """The horizon: what the feet, the torso and the load do.

    Attributes:
        motion: per foot the TCP's x, y, z (m) and yaw (rad), per foot the toe's lift (rad), the
            torso's yaw (rad), the CoM's height (m), per foot the pitch (rad), the heel up.
        load: the left foot's share of the load.
        swings: entries (foot, lift-off time, touchdown time).
        path: the robot's frame on the ground x, y (m), yaw (rad) after every step.
        end: time at which the last change is complete (s).
    """

    motion: Profile
    load: Profile
    swings: list[tuple[int, float, float]] = field(default_factory=list)
    path: list[np.ndarray] = field(default_factory=list)
    end: float = 0.0


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
    wait: float = 0.0,
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
        displacements: one row (forward, left, turn, up) per step, shape (n, 4).
        wait: how long everything stays as it is before (s).

    Returns:
        The schedule, time 0 being now. The feet are side by side at its end; a closing step is
        added where that needs one, and a second one where the last foothold had to make room.
    """
    plan = Schedule(
        motion=Profile(np.array([*feet[LEFT], *feet[RIGHT], 0.0, 0.0, heading, height, 0.0, 0.0])),
        load=Profile(np.array([load]), transition=linear),
        end=wait,
    )
    for displacement in displacements:
        path, ground = advance(path, displacement[:UP]), ground + displacement[UP]
        _add_step(plan, timing, support, swing, path, ground)
        support, swing = timing.double_support, 1 - swing
    for _ in (LEFT, RIGHT):
        if not _side_by_side(plan, timing, path, swing):
            _add_step(plan, timing, support, swing, path, ground)
            support, swing = timing.double_support, 1 - swing
    settled = plan.end + timing.last_double_support
    plan.load.add(plan.end, settled, 0.5 - plan.load.end)
    plan.end = settled
    return plan


def _side_by_side(plan: Schedule, timing: GaitTiming, path: np.ndarray, foot: int) -> bool:
    target = foothold(path, foot, timing.step_width)
    return bool(np.abs(plan.motion.end[FOOT[foot]][PLACE] - target).max() < 1e-9)


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
    end = plan.motion.end
    stance_x, stance_y, stance_z, stance_yaw = end[FOOT[1 - swing]]
    standing = np.array([stance_x, stance_y, stance_yaw])
    x, y, yaw = clear_foothold(path, swing, timing.step_width, standing)
    heading = min(max(path[2], stance_yaw - MOST_TURNED), stance_yaw + MOST_TURNED)
    z = end[FOOT[swing]][2]
    highest, level = max(z, stance_z, ground), (stance_z + ground) / 2
    upward, downward = PITCH_PER_RISE * (highest - z), PITCH_PER_RISE * (z - ground)
    # Of a foot that goes down the heel comes up as in walking: about the toe, which stays level.
    toe = max(timing.toe_lift, downward)
    top = highest + timing.step_height + TOE_AXIS * max(downward, 0.0)
    across, rise, fall, body, tilt = np.zeros((5, MOTION_SIZE))
    across[FOOT[swing]] = [x, y, z, yaw] - end[FOOT[swing]]
    rise[FOOT[swing]], rise[TOE[swing]] = [0.0, 0.0, top - z, 0.0], toe
    fall[FOOT[swing]], fall[TOE[swing]] = [0.0, 0.0, ground - top, 0.0], -toe
    body[HEADING], body[HEIGHT] = heading - end[HEADING], timing.com_height + level - end[HEIGHT]
    lead, lag = timing.horizontal_lead * duration, timing.horizontal_lag * duration
    plan.motion.add(lift_off + lead, touchdown - lag, across)
    way = (lift_off + lead, touchdown - lag, across[FOOT[swing]][PLACE])
    _add_detour(plan, swing, standing, end[FOOT[swing]][PLACE], way, (lift_off, touchdown))
    plan.motion.add(lift_off, up, rise)
    plan.motion.add(down, touchdown, fall)
    plan.motion.add(lift_off, touchdown, body)
    tilt[PITCH[swing]] = max(upward, downward)
    if tilt.any():
        plan.motion.add(lift_off, up, tilt)
        plan.motion.add(up, (down + touchdown) / 2, -tilt)
    plan.swings.append((swing, lift_off, touchdown))
    plan.path.append(path)
    plan.end = touchdown


def _add_detour(
    plan: Schedule,
    swing: int,
    standing: np.ndarray,
    start: np.ndarray,
    across: tuple[float, float, np.ndarray],
    times: tuple[float, float],
) -> None:
    """Let the swing foot bow outward where its direct way would lead through the standing foot."""
    lift_off, touchdown = times
    middle, time = (lift_off + touchdown) / 2, np.linspace(lift_off, touchdown, 13)[2:-2]
    t_from, t_to, change = across
    done = quintic((time - t_from) / (t_to - t_from))[0]
    out = np.minimum(*(quintic((time - at) / (middle - at))[0] for at in times))
    ways = start + done[:, None] * change
    size = detour(ways, out, swing, standing)
    if size > 0:
        side = 1.0 if swing == LEFT else -1.0
        bow = np.zeros(MOTION_SIZE)
        yaw = standing[2]
        bow[FOOT[swing]][:2] = side * size * np.array([-np.sin(yaw), np.cos(yaw)])
        plan.motion.add(lift_off, middle, bow)
        plan.motion.add(middle, touchdown, -bow)
