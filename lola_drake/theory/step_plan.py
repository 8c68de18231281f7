"""From a schedule to references: what the pattern generator hands over for one step.

`plan_step` is a pure function of the request: the CoM is solved over the whole horizon, then
everything is sampled at the control rate for the step that comes now. One row of the resulting
tables is everything the controller needs in one tick.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lola_drake.signals import (
    GAIT_PHASE,
    IDEAL_WRENCH,
    PLANNED_MOTION,
    TASK_REFERENCE,
    Signal,
)
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import LEFT, RIGHT
from lola_drake.theory.gait import Schedule
from lola_drake.theory.horizon import (
    PatternModel,
    Sampled,
    reference_zmp,
    sample,
    solve_horizon,
)
from lola_drake.theory.smooth import bump, quintic
from lola_drake.theory.step_request import StepRequest


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


def plan_step(model: PatternModel, request: StepRequest) -> StepPlan:
    """Return the plan of the step that begins now, looking ahead over all given displacements."""
    horizon = solve_horizon(model, request)
    schedule = horizon.schedule
    stepping = len(schedule.swings) > 0
    duration = schedule.swings[0][2] if stepping else schedule.end
    at = sample(schedule, model.period * np.arange(round(duration / model.period) + 1))
    position, velocity, acceleration = (values.T for values in horizon.com(at.time))
    com = position, velocity, acceleration
    zmp = reference_zmp(model, at) + bump(at.time / horizon.shifting) * horizon.shift[:, None]
    return StepPlan(
        duration=duration,
        lift_off=horizon.shifting if stepping else np.inf,
        task_reference=_task_reference(model, at, com),
        gait_phase=_gait_phase(model, request, schedule, at),
        ideal_wrench=_ideal_wrench(model, at, com, zmp),
        planned_motion=_planned_motion(at, com, zmp),
        load=float(request.swing == RIGHT) if stepping else 0.5,
        path=schedule.path[0] if stepping else request.path,
        zmp_shift=horizon.shift,
    )


def zmp_shift(model: PatternModel, request: StepRequest) -> np.ndarray:
    """Return only the plan's shift of the ZMP (m), shape (2,)."""
    return solve_horizon(model, request).shift


_Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""The CoM's position, velocity and acceleration, each of shape (3, n)."""


def _table(signal: Signal, at: Sampled, fields: dict[str, Any]) -> np.ndarray:
    """Return a signal with one row per time, given the rows of its fields."""
    table = np.zeros((len(at.time), signal.size))
    for name, values in fields.items():
        table.T[signal.slice(name)] = values
    return table


def _task_reference(model: PatternModel, at: Sampled, com: _Motion) -> np.ndarray:
    """Return w_id and its rate: the feet relative to the CoM, seen from the torso frame.

    A loaded foot sinks in; the reference is lowered by as much, so that the CoM keeps its height
    and the swing foot meets the ground when it should.
    """
    w, w_dot = np.zeros((2, 6, 2, len(at.time)))
    sink = model.legs.mass * GRAVITY / model.ground_stiffness
    position, velocity = at.pose[:3] - com[0][:, None], at.rate[:3] - com[1][:, None]
    position[2] -= sink * at.load
    velocity[2] -= sink * at.load_rate
    x, y, _ = w[:3] = _unturn(at.heading, position)
    w_dot[:3] = _unturn(at.heading, velocity)
    w_dot[0] += at.turn * y
    w_dot[1] -= at.turn * x
    w[4], w_dot[4] = np.sin(at.pitch), np.cos(at.pitch) * at.pitch_rate
    w[5], w_dot[5] = at.pose[3] - at.heading, at.rate[3] - at.turn
    fields = {
        "w_l": w[:, LEFT],
        "w_r": w[:, RIGHT],
        "toes": at.toe,
        "w_dot_l": w_dot[:, LEFT],
        "w_dot_r": w_dot[:, RIGHT],
        "toe_rates": at.toe_rate,
    }
    return _table(TASK_REFERENCE, at, fields)


def _gait_phase(
    model: PatternModel, request: StepRequest, schedule: Schedule, at: Sampled
) -> np.ndarray:
    """Return where in the gait the feet are: support, load, and b_f.

    A foot stays under force control as long as it may bear load, and b_f fades while it is pulled
    back to the plan, during its swing (the paper's IV.B): a fade that is over at lift-off would
    press a foot down that is still loaded. That b_f rises again before touchdown is our own choice:
    nothing is wanted of a foot in the air, and the first touch finds it compliant. (Rising from the
    touchdown on costs a fifth of the torque error on flat ground.)
    """
    time = at.time
    support = np.ones((2, len(time)))
    blend = 1 - (1 - request.blend)[:, None] * (1 - quintic(time / model.contact_blend_time)[0])
    for foot, lift_off, touchdown in schedule.swings[:1]:
        blend[foot] -= quintic((time - lift_off) / model.blend_time)[0]
        blend[foot] += quintic((time - touchdown) / model.blend_time + 1)[0]
        support[foot, (time >= lift_off) & (time < touchdown)] = 0.0
    fields = {
        "support": support,
        "load": at.load,
        "blend": np.clip(blend, 0.0, 1.0),
        "step_index": request.step_index,
        "time_in_step": time,
    }
    return _table(GAIT_PHASE, at, fields)


def _ideal_wrench(model: PatternModel, at: Sampled, com: _Motion, zmp: np.ndarray) -> np.ndarray:
    """Return Lambda_id in T: m (c'' + g e_z), and its torque about the CoM, acting at the ZMP."""
    position, _, acceleration = com
    force = model.legs.mass * (acceleration + [[0.0], [0.0], [GRAVITY]])
    (x, y, z), (f_x, f_y, f_z) = np.vstack([zmp, at.ground]) - position, force
    torque = np.array([y * f_z - z * f_y, z * f_x - x * f_z, np.zeros_like(z)])
    fields = {"F": _unturn(at.heading, force), "T": _unturn(at.heading, torque)}
    return _table(IDEAL_WRENCH, at, fields)


def _planned_motion(at: Sampled, com: _Motion, zmp: np.ndarray) -> np.ndarray:
    fields = {
        "com": com[0],
        "com_velocity": com[1],
        "zmp": zmp,
        "heading": at.heading,
        "foot_l": at.pose[:, LEFT],
        "foot_r": at.pose[:, RIGHT],
    }
    return _table(PLANNED_MOTION, at, fields)


def _unturn(heading: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors of P in T, which is turned by the heading about z, shape (3, ...)."""
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = vectors
    return np.array([c * x + s * y, c * y - s * x, z])
