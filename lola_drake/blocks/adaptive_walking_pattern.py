"""The walking pattern with what changes the step that is under way; each part is a switch.

`step_adaptation` moves the foothold after a push, see `lola_drake.theory.step_adaptation`, and
keeps the swing foot level with the ground while the robot leans. At the touchdown the plan goes on
from the place where the foot stands, with the CoM as fast as it makes the foothold the right one,
and with the double support for which the ZMP is to be shifted least.
`late_foot_probing` waits for a foot that finds no ground: the load stays on the other foot, by at
most `WAIT`, while the force control seeks the ground at its `search_speed`. The LOLA group's later
publications have these ideas; laws and numbers are our own.
"""

from dataclasses import replace

import numpy as np

from lola_drake.block import Part, State
from lola_drake.blocks.walking_pattern import (
    ENDS,
    Played,
    WalkingPattern,
    continued,
)
from lola_drake.signals import (
    FEET,
    PERIOD,
    PLANNED_MOTION,
    TASK_REFERENCE,
    TORSO_ORIENTATION,
    Field,
    Signal,
)
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.gait import PLACE
from lola_drake.theory.smooth import quintic
from lola_drake.theory.step_adaptation import (
    DECIDED,
    FADING,
    LEVELLING,
    allowed_shift,
    approach,
    capture_shift,
    part_ahead,
    too_low,
)
from lola_drake.theory.step_plan import StepPlan
from lola_drake.theory.step_request import StepRequest, pack_request

WAIT = 0.15
"""How long the load waits for a late foot, at most (s)."""

SUPPORTS = np.arange(0.16, 0.34, 0.04)
"""Durations of the double support that are tried after a step whose foothold was moved (s)."""

SHIFT = Signal(
    "foothold_shift",
    "How far the feet are moved from their plan, how fast, and how far the swing foot is to be.",
    (
        Field("shift", ("x", "y"), "m", "P"),
        Field("rate", ("x", "y"), "m/s", "P"),
        Field("target", ("x", "y"), "m", "P"),
        Field("heights", ("l", "r"), "m", "P"),
        Field("height_rates", ("l", "r"), "m/s", "P"),
    ),
)

W = [TASK_REFERENCE.slice(f"w_{foot}", 3) for foot in FEET]
W_DOT = [TASK_REFERENCE.slice(f"w_dot_{foot}", 3) for foot in FEET]
POSE = [PLANNED_MOTION.slice(f"foot_{foot}") for foot in FEET]
HEADING = PLANNED_MOTION.index("heading")
COM, ZMP = PLANNED_MOTION.slice("com"), PLANNED_MOTION.slice("zmp")
HEIGHTS = slice(SHIFT.slice("heights").start, SHIFT.size)


class AdaptiveWalkingPattern(WalkingPattern):
    """Plans each step as the walking pattern does, and changes it while it is under way."""

    state = (*WalkingPattern.state, State(SHIFT, hidden=True))
    parts = {
        "phi": Part(TORSO_ORIENTATION, "phi"),
        "phi_dot": Part(TORSO_ORIENTATION, "phi_dot"),
    }

    def next_state(self, time, request, contact, walk_command, phi, phi_dot, foothold_shift):
        """Return the request, the plan's row as it is changed, and the change, of the next tick."""
        return self.advanced(time, request, contact, walk_command, phi, phi_dot, foothold_shift)

    def advanced(
        self, time, request, contact, walk_command, phi, phi_dot, foothold_shift, lift=0.0
    ) -> np.ndarray:
        """Return the same where the feet are let down by `lift` against the plan (m)."""
        played = self._recall(request)
        row = round((time - played.request.start_time) / PERIOD)
        following = self._following(time, contact, walk_command, played.request, played.plan, row)
        if following is not None:
            following = replace(self._moved_on(following, played, foothold_shift[:2]), lift=lift)
            played = self._recall(pack_request(following))
            row = round((time - following.start_time) / PERIOD)
            foothold_shift = np.append(np.zeros(HEIGHTS.start), foothold_shift[HEIGHTS])
        elif self.params.step_adaptation:
            support = self.params.double_support
            foothold_shift = next_shift(played, row, phi, phi_dot, foothold_shift, support)
        row = min(row + 1, len(played.rows) - 1)
        return np.append(shifted(played, row, foothold_shift), foothold_shift)

    def _moved_on(self, following: StepRequest, played: Played, shift: np.ndarray) -> StepRequest:
        """Return what follows a step, its foot having come down elsewhere if there is a shift."""
        if not shift.any():
            return following
        supports = [replace(following, support=support) for support in SUPPORTS]
        return self.smoothest([moved_on(request, played, shift) for request in supports])

    def _following(
        self, now, contact, command, request: StepRequest, plan: StepPlan, row: int
    ) -> StepRequest | None:
        """Return the request that replaces the present one, with a wait for a late foot."""
        if row * PERIOD < request.wait:
            arrived = on_ground(contact, 1 - request.swing)
            return replace(continued(request, plan, row), wait=0.0) if arrived else None
        following = super()._following(now, contact, command, request, plan, row)
        if following is None or not self.params.late_foot_probing:
            return following
        landed = following.step_index > request.step_index
        late = landed and not on_ground(contact, request.swing)
        return replace(following, wait=WAIT) if late else following


def on_ground(contact: np.ndarray, foot: int) -> bool:
    """Return whether any switch of a foot is closed."""
    return bool(contact[4 * foot : 4 * foot + 4].any())


def next_shift(
    played: Played,
    row: int,
    phi: np.ndarray,
    phi_dot: np.ndarray,
    shift: np.ndarray,
    support: float,
) -> np.ndarray:
    """Return the shift of the feet in the next tick.

    Args:
        played: the plan.
        row: of the plan, now.
        phi: inclination of the torso (rad), shape (2,).
        phi_dot: its rate (rad/s).
        shift: now, as the signal `foothold_shift`.
        support: duration of the double support after the touchdown (s).
    """
    plan, swing = played.plan, played.request.swing
    done = (row * PERIOD - plan.lift_off) / (plan.duration - plan.lift_off)
    moved, rate, target, heights, _ = np.split(shift, 5)
    if not 0 <= done < 1:
        # What a foot is higher than planned fades while it stands.
        rates = -heights / FADING
        return np.concatenate([np.zeros(HEIGHTS.start), heights + PERIOD * rates, rates])
    now, time_left = plan.planned_motion[row], plan.duration - row * PERIOD
    foot, standing, heading = now[POSE[swing]], now[POSE[1 - swing]], now[HEADING]
    if done < DECIDED:
        zmp, height = _turned(now[ZMP] - standing[:2], -heading), now[COM][2] - standing[2]
        wanted = capture_shift(phi, phi_dot, zmp, height, time_left, support)
        place = plan.planned_motion[-1][POSE[swing]][PLACE]
        target = allowed_shift(_turned(wanted, heading), place, swing, standing[PLACE])
    rate = rate + PERIOD * approach(moved, rate, target, time_left)
    level = too_low(phi, _turned(foot[:2] + moved - standing[:2], -heading))
    begun = quintic(np.array(2 * done))[0]
    rates = -heights / FADING
    rates[swing] = (begun * (heights[1 - swing] + level) - heights[swing]) / LEVELLING
    return np.concatenate([moved + PERIOD * rate, rate, target, heights + PERIOD * rates, rates])


def shifted(played: Played, row: int, shift: np.ndarray) -> np.ndarray:
    """Return the request and a plan's row with the feet moved."""
    state, swing = played.rows[row], played.request.swing
    if not shift.any():
        return state
    state = state.copy()
    _, task, _, _, motion = np.split(state, ENDS)
    moved, rate, _, heights, height_rates = np.split(shift, 5)
    before = played.plan.planned_motion[row - 1]
    heading, turn = motion[HEADING], (motion[HEADING] - before[HEADING]) / PERIOD
    x, y = _turned(moved, -heading)
    task[W[swing]][:2] += x, y
    task[W_DOT[swing]][:2] += _turned(rate, -heading) + [turn * y, -turn * x]
    motion[POSE[swing]][:2] += moved
    for foot, (height, height_rate) in enumerate(zip(heights, height_rates, strict=True)):
        task[W[foot]][2] += height
        task[W_DOT[foot]][2] += height_rate
        motion[POSE[foot]][2] += height
    return state


def moved_on(following: StepRequest, played: Played, shift: np.ndarray) -> StepRequest:
    """Return what follows a step whose foot came down elsewhere: it goes on from there."""
    swing = played.request.swing
    feet = [foot.copy() for foot in following.feet]
    feet[swing][:2] += shift
    height = following.com[2] - feet[swing][2]
    faster = np.sqrt(GRAVITY / height) * part_ahead(height, following.support) * shift
    return replace(
        following,
        feet=(feet[0], feet[1]),
        path=following.path + [*shift, 0.0],
        com_velocity=following.com_velocity + [*faster, 0.0],
    )


def _turned(vector: np.ndarray, yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
