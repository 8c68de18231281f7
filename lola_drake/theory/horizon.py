"""The horizon of a plan: the CoM over the next few steps, in knots of 10 ms.

The legs' angular momentum depends on the CoM and the CoM on it; a few passes bring them together.
Arrays have one row per component and one column per time.
"""

from dataclasses import dataclass, replace

import numpy as np

from lola_drake.theory.com_trajectory import KnotSpline, solve_com
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.gait import (
    FOOT,
    HEADING,
    HEIGHT,
    PITCH,
    TOE,
    GaitTiming,
    Schedule,
    make_schedule,
)
from lola_drake.theory.leg_masses import LegModel, LegMotion, derivative
from lola_drake.theory.smooth import bump
from lola_drake.theory.step_request import StepRequest

KNOT_STEP = 0.01
CORRECTIONS = 2
"""Passes that bring the ZMP and the legs' angular momentum together: each leaves a fifth."""

SETTLING = 1.2
"""Time after the last step during which the CoM comes to rest (s): about four time constants."""


@dataclass(frozen=True)
class PatternModel:
    """What the plan needs to know of the robot and the gait.

    Attributes:
        timing: times and shapes of the steps.
        legs: lumped masses of the robot.
        p_TcpZmp: where the ZMP is planned under a loaded foot: forward of the TCP, and inward
            (m), shape (2,).
        blend_time: duration of the blending between force and position control (s).
        contact_blend_time: the same of a foot that has touched before it was planned to (s).
        ground_stiffness: vertical stiffness of a foot on the ground (N/m).
        period: the control period (s).
    """

    timing: GaitTiming
    legs: LegModel
    p_TcpZmp: np.ndarray
    blend_time: float
    contact_blend_time: float
    ground_stiffness: float
    period: float


@dataclass(frozen=True)
class Horizon:
    """The next steps and the CoM that goes with them.

    Attributes:
        schedule: who does what when.
        com: the CoM (m).
        shifting: until when the ZMP is shifted (s).
        shift: by how much at most (m), shape (2,).
    """

    schedule: Schedule
    com: KnotSpline
    shifting: float
    shift: np.ndarray


@dataclass(frozen=True)
class Sampled:
    """A schedule at given times.

    Attributes:
        time: (s), shape (n,).
        pose, rate: x, y, z, yaw of the left and the right TCP, shape (4, 2, n).
        toe, toe_rate: lift of the left and the right toe (rad, rad/s), shape (2, n).
        pitch, pitch_rate: the same of how far the heel is up against the toe.
        load, load_rate: shares of the load of the left and the right foot, shape (2, n).
        heading, turn: the torso's yaw (rad) and its rate (rad/s), shape (n,).
        height: the CoM's height with its rate and acceleration (m), shape (3, n).
    """

    time: np.ndarray
    pose: np.ndarray
    rate: np.ndarray
    toe: np.ndarray
    toe_rate: np.ndarray
    pitch: np.ndarray
    pitch_rate: np.ndarray
    load: np.ndarray
    load_rate: np.ndarray
    heading: np.ndarray
    turn: np.ndarray
    height: np.ndarray

    @property
    def ground(self) -> np.ndarray:
        """Return the height of the ZMP's plane: that of the feet, weighted by their loads."""
        return (self.load * self.pose[2]).sum(axis=0)


def sample(schedule: Schedule, time: np.ndarray) -> Sampled:
    """Return a schedule at the given ascending times (s)."""
    value, rate, acceleration = schedule.motion(time)
    (load,), (load_rate,), _ = schedule.load(time)
    return Sampled(
        time=time,
        pose=np.stack([value[foot] for foot in FOOT], axis=1),
        rate=np.stack([rate[foot] for foot in FOOT], axis=1),
        toe=value[TOE, :],
        toe_rate=rate[TOE, :],
        pitch=value[PITCH, :],
        pitch_rate=rate[PITCH, :],
        load=np.array([load, 1 - load]),
        load_rate=np.array([load_rate, -load_rate]),
        heading=value[HEADING],
        turn=rate[HEADING],
        height=np.array([value[HEIGHT], rate[HEIGHT], acceleration[HEIGHT]]),
    )


def reference_zmp(model: PatternModel, at: Sampled) -> np.ndarray:
    """Return where the ZMP is wanted under the loaded feet (m), shape (2, n)."""
    forward, inward = model.p_TcpZmp
    left = np.array([[-inward], [inward]])
    x, y, _, yaw = at.pose
    c, s = np.cos(yaw), np.sin(yaw)
    zmp = np.array([x + c * forward - s * left, y + s * forward + c * left])
    return (at.load * zmp).sum(axis=1)


def solve_horizon(model: PatternModel, request: StepRequest) -> Horizon:
    """Return the plan of all given displacements, and of the step in which the robot stops."""
    schedule = make_schedule(
        replace(model.timing, com_height=model.timing.com_height - request.lift),
        request.feet,
        request.load,
        request.com[2],
        request.heading,
        request.path,
        request.ground,
        request.swing,
        request.support,
        request.displacements,
        request.wait,
    )
    # The ZMP is moved while both feet carry, where it has the most room, and in a wait before.
    shifting = schedule.swings[0][1] if schedule.swings else schedule.end
    at = sample(schedule, np.arange(0.0, schedule.end + SETTLING, KNOT_STEP))
    lifting = GRAVITY + at.height[2]
    stiffness = lifting / (at.height[0] - at.ground)
    zmp, shape = reference_zmp(model, at), bump(at.time / shifting)

    def solve(zmp: np.ndarray) -> tuple[KnotSpline, np.ndarray]:
        start, velocity = request.com[:2], request.com_velocity[:2]
        return solve_com(KNOT_STEP, stiffness, zmp.T, shape, start, velocity)

    legs = LegMotion(model.legs, KNOT_STEP, at.heading, at.pose)
    com, shift = solve(zmp)
    for _ in range(CORRECTIONS):
        momentum = legs.angular_momentum(np.vstack([com.position.T, at.height[0]]))
        x, y = derivative(momentum[:2], KNOT_STEP) / (model.legs.mass * lifting)
        com, shift = solve(zmp + np.array([y, -x]))
    motions = zip((com.position, com.velocity, com.acceleration), at.height, strict=True)
    com = KnotSpline(KNOT_STEP, *(np.vstack([plane.T, height]).T for plane, height in motions))
    return Horizon(schedule, com, shifting, shift)
