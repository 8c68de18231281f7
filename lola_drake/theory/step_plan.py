"""From a schedule to references: what the pattern generator hands over for one step.

`plan_step` is a pure function of the request: the CoM is solved over the whole horizon in knots of
10 ms, then everything is sampled at the control rate for the step that comes now. One row of the
resulting table is everything the controller needs in one tick.
"""

from dataclasses import dataclass

import numpy as np

from lola_drake.signals import GAIT_PHASE, IDEAL_WRENCH, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.com_trajectory import KnotSpline, solve_com
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.gait import LEFT, RIGHT, GaitTiming, Schedule, make_schedule
from lola_drake.theory.leg_masses import LegModel, angular_momentum
from lola_drake.theory.smooth import bump, quintic
from lola_drake.theory.step_request import StepRequest

KNOT_STEP = 0.01
CORRECTIONS = 2
"""Passes that bring the ZMP and the legs' angular momentum together."""

SETTLING = 1.2
"""Time after the last step during which the CoM comes to rest (s): about four time constants."""


@dataclass(frozen=True)
class StepPlan:
    """The sampled plan of one step.

    Attributes:
        duration: until the planned touchdown (s).
        lift_off: when the foot lifts off, inf if it does not (s).
        task_reference, gait_phase, ideal_wrench, planned_motion: one row per tick, laid out as
            the signals of the same names.
        load: the left foot's share of the load at the end.
        path: the robot's frame at the end.
        zmp_shift: amplitude of the ZMP's free parameter (m), shape (2,).
    """

    duration: float
    lift_off: float
    task_reference: np.ndarray
    gait_phase: np.ndarray
    ideal_wrench: np.ndarray
    planned_motion: np.ndarray
    load: float
    path: np.ndarray
    zmp_shift: np.ndarray


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


def plan_step(model: PatternModel, request: StepRequest) -> StepPlan:
    """Return the plan of the step that begins now, looking ahead over all given displacements."""
    schedule = make_schedule(
        model.timing,
        request.feet,
        request.load,
        request.com[2],
        request.heading,
        request.path,
        request.ground,
        request.swing,
        request.support,
        request.displacements,
    )
    stepping = len(schedule.swings) > 0
    duration = schedule.swings[0][2] if stepping else schedule.end
    # The ZMP is moved while both feet carry: there it has the most room.
    shifting = schedule.swings[0][1] if stepping else schedule.end
    com, shift = _solve_horizon(model, request, schedule, shifting)
    at = _sample(schedule, model.period * np.arange(round(duration / model.period) + 1))
    motion = com(at.time)
    zmp = _zmp(model, at) + bump(at.time / shifting)[:, None] * shift
    return StepPlan(
        duration=duration,
        lift_off=shifting if stepping else np.inf,
        task_reference=_task_reference(model, schedule, at, motion),
        gait_phase=_gait_phase(model, request, schedule, at),
        ideal_wrench=_ideal_wrench(model, at, motion, zmp),
        planned_motion=_planned_motion(at, motion, zmp),
        load=float(request.swing == RIGHT) if stepping else 0.5,
        path=schedule.path[0] if stepping else request.path,
        zmp_shift=shift,
    )


@dataclass(frozen=True)
class _Sampled:
    """A schedule at given times: one row per time.

    Attributes:
        time: (s), shape (n,).
        pose, rate: of the left and the right TCP, each of shape (n, 4).
        load, load_rate: the left foot's share of the load, shape (n,).
        heading, turn: the torso's yaw (rad) and its rate (rad/s), shape (n,).
    """

    time: np.ndarray
    pose: tuple[np.ndarray, np.ndarray]
    rate: tuple[np.ndarray, np.ndarray]
    load: np.ndarray
    load_rate: np.ndarray
    heading: np.ndarray
    turn: np.ndarray

    @property
    def ground(self) -> np.ndarray:
        """Return the height of the ZMP's plane: that of the feet, weighted by their loads."""
        left, right = self.pose
        return self.load * left[:, 2] + (1 - self.load) * right[:, 2]


def _sample(schedule: Schedule, time: np.ndarray) -> _Sampled:
    pose, rate = zip(*(profile(time) for profile in schedule.foot), strict=True)
    load, load_rate = (value[:, 0] for value in schedule.load(time))
    heading, turn = (value[:, 0] for value in schedule.heading(time))
    return _Sampled(time, pose, rate, load, load_rate, heading, turn)


def _solve_horizon(
    model: PatternModel, request: StepRequest, schedule: Schedule, shifting: float
) -> tuple[KnotSpline, np.ndarray]:
    """Return the CoM over the horizon, and the ZMP's shift until the time `shifting`."""
    at = _sample(schedule, np.arange(0.0, schedule.end + SETTLING, KNOT_STEP))
    height = _height(schedule, at.time)
    lifting = GRAVITY + height.acceleration[:, 0]
    stiffness = lifting / (height.position[:, 0] - at.ground)
    zmp, shape = _zmp(model, at), bump(at.time / shifting)

    def solve(zmp: np.ndarray) -> tuple[KnotSpline, np.ndarray]:
        start, velocity = request.com[:2], request.com_velocity[:2]
        return solve_com(KNOT_STEP, stiffness, zmp, shape, start, velocity)

    # The legs' angular momentum depends on the CoM and the CoM on it: each pass leaves a fifth.
    horizontal, shift = solve(zmp)
    for _ in range(CORRECTIONS):
        momentum = angular_momentum(
            model.legs,
            KNOT_STEP,
            np.column_stack([horizontal.position, height.position]),
            at.heading,
            tuple(pose[:, :3] for pose in at.pose),
            tuple(pose[:, 3] for pose in at.pose),
        )
        rate = np.gradient(momentum, KNOT_STEP, axis=0) / (model.legs.mass * lifting)[:, None]
        horizontal, shift = solve(zmp + np.column_stack([rate[:, 1], -rate[:, 0]]))
    com = KnotSpline(
        KNOT_STEP,
        np.column_stack([horizontal.position, height.position]),
        np.column_stack([horizontal.velocity, height.velocity]),
        np.column_stack([horizontal.acceleration, height.acceleration]),
    )
    return com, shift


def _height(schedule: Schedule, time: np.ndarray) -> KnotSpline:
    position, velocity = schedule.height(time)
    acceleration = np.zeros_like(position)
    for t_from, t_to, change in schedule.height.changes:
        _, _, dds = quintic((time - t_from) / (t_to - t_from))
        acceleration += (dds / (t_to - t_from) ** 2)[:, None] * change
    return KnotSpline(KNOT_STEP, position, velocity, acceleration)


def _zmp(model: PatternModel, at: _Sampled) -> np.ndarray:
    forward, inward = model.p_TcpZmp
    zmp = 0.0
    for pose, share, left in zip(at.pose, (at.load, 1 - at.load), (-inward, inward), strict=True):
        c, s = np.cos(pose[:, 3]), np.sin(pose[:, 3])
        offset = np.column_stack([c * forward - s * left, s * forward + c * left])
        zmp = zmp + share[:, None] * (pose[:, :2] + offset)
    return zmp


_Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""The CoM's position, velocity and acceleration, each of shape (n, 3)."""


def _task_reference(
    model: PatternModel, schedule: Schedule, at: _Sampled, com: _Motion
) -> np.ndarray:
    """Return w_id and its rate: the feet relative to the CoM, seen from the torso frame.

    A loaded foot sinks in; the reference is lowered by as much, so that the CoM keeps its height
    and the swing foot meets the ground when it should.
    """
    table = np.zeros((len(at.time), TASK_REFERENCE.size))
    c_position, c_velocity, _ = com
    sink = model.legs.mass * GRAVITY / model.ground_stiffness
    for foot, name, share, share_rate in (
        (LEFT, "l", at.load, at.load_rate),
        (RIGHT, "r", 1 - at.load, -at.load_rate),
    ):
        pose, rate = at.pose[foot], at.rate[foot]
        position, velocity = pose[:, :3] - c_position, rate[:, :3] - c_velocity
        position[:, 2] -= sink * share
        velocity[:, 2] -= sink * share_rate
        p, v = _unturn(at.heading, position), _unturn(at.heading, velocity)
        v += at.turn[:, None] * np.column_stack([p[:, 1], -p[:, 0], np.zeros(len(p))])
        w, w_dot = TASK_REFERENCE.slice(f"w_{name}"), TASK_REFERENCE.slice(f"w_dot_{name}")
        table[:, w.start : w.start + 3] = p
        table[:, w.stop - 1] = pose[:, 3] - at.heading
        table[:, w_dot.start : w_dot.start + 3] = v
        table[:, w_dot.stop - 1] = rate[:, 3] - at.turn
        lift, lift_rate = schedule.toe[foot](at.time)
        table[:, TASK_REFERENCE.slice("toes").start + foot] = lift[:, 0]
        table[:, TASK_REFERENCE.slice("toe_rates").start + foot] = lift_rate[:, 0]
    return table


def _gait_phase(
    model: PatternModel, request: StepRequest, schedule: Schedule, at: _Sampled
) -> np.ndarray:
    """Return where in the gait the feet are: support, load, and b_f.

    A foot stays under force control as long as it may bear load, and b_f fades while it is pulled
    back to the plan, during its swing (the paper's IV.B): a fade that is over at lift-off would
    press a foot down that is still loaded. That b_f rises again before touchdown is our own choice:
    nothing is wanted of a foot in the air, and the first touch finds it compliant. (Rising from the
    touchdown on costs a fifth of the torque error on flat ground.)
    """
    time = at.time
    table = np.zeros((len(time), GAIT_PHASE.size))
    support = np.ones((len(time), 2))
    blend = 1 - (1 - request.blend) * (1 - quintic(time / model.contact_blend_time)[0])[:, None]
    for foot, lift_off, touchdown in schedule.swings[:1]:
        blend[:, foot] -= quintic((time - lift_off) / model.blend_time)[0]
        blend[:, foot] += quintic((time - touchdown) / model.blend_time + 1)[0]
        support[(time >= lift_off) & (time < touchdown), foot] = 0.0
    table[:, GAIT_PHASE.slice("support")] = support
    table[:, GAIT_PHASE.slice("load")] = np.column_stack([at.load, 1 - at.load])
    table[:, GAIT_PHASE.slice("blend")] = np.clip(blend, 0.0, 1.0)
    table[:, GAIT_PHASE.index("step_index")] = request.step_index
    table[:, GAIT_PHASE.index("time_in_step")] = time
    return table


def _ideal_wrench(model: PatternModel, at: _Sampled, com: _Motion, zmp: np.ndarray) -> np.ndarray:
    """Return Lambda_id in T: m (c'' + g e_z), and its torque about the CoM, acting at the ZMP."""
    position, _, acceleration = com
    force = model.legs.mass * (acceleration + [0.0, 0.0, GRAVITY])
    torque = np.cross(np.column_stack([zmp, at.ground]) - position, force)
    torque[:, 2] = 0.0
    table = np.zeros((len(at.time), IDEAL_WRENCH.size))
    table[:, IDEAL_WRENCH.slice("F")] = _unturn(at.heading, force)
    table[:, IDEAL_WRENCH.slice("T")] = _unturn(at.heading, torque)
    return table


def _planned_motion(at: _Sampled, com: _Motion, zmp: np.ndarray) -> np.ndarray:
    table = np.zeros((len(at.time), PLANNED_MOTION.size))
    table[:, PLANNED_MOTION.slice("com")] = com[0]
    table[:, PLANNED_MOTION.slice("com_velocity")] = com[1]
    table[:, PLANNED_MOTION.slice("zmp")] = zmp
    table[:, PLANNED_MOTION.index("heading")] = at.heading
    table[:, PLANNED_MOTION.slice("foot_l")] = at.pose[LEFT]
    table[:, PLANNED_MOTION.slice("foot_r")] = at.pose[RIGHT]
    return table


def _unturn(heading: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors of P expressed in T, which is turned by the heading about z."""
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = vectors.T
    return np.column_stack([c * x + s * y, c * y - s * x, z])
