"""The walking pattern generator: from what the user asks for to references for the next step.

The paper takes the ideal pattern as given; its structure (a plan over the next three steps, made
anew at the beginning of each, and a CoM found by spline collocation) is that of the LOLA group's
publications (Buschmann et al. 2007, 2010). The numbers are our own choice unless they are marked.

| paper            | here                            |
|------------------|---------------------------------|
| w_id, w_id'      | output `task_reference`         |
| Lambda_id        | output `ideal_wrench`           |
| b_f              | `blend` in output `gait_phase`  |
"""

from collections import OrderedDict
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from lola_drake.block import Block, State
from lola_drake.parameters import ParameterError, parameter, validate
from lola_drake.signals import (
    GAIT_PHASE,
    IDEAL_WRENCH,
    PERIOD,
    PLANNED_MOTION,
    TASK_REFERENCE,
    Field,
    Signal,
)
from lola_drake.theory.footholds import (
    LEFT,
    RIGHT,
    UP,
    advance,
    first_foot,
    foothold,
    limited_step,
    paired_steps,
    with_closing_steps,
)
from lola_drake.theory.gait import GaitTiming
from lola_drake.theory.leg_masses import LegModel
from lola_drake.theory.step_plan import PatternModel, StepPlan, plan_step, zmp_shift
from lola_drake.theory.step_request import (
    HORIZON,
    REQUEST_SIZE,
    StepRequest,
    pack_request,
    unpack_request,
)

EARLY = (0.5, 0.88)
"""Part of the swing in which a contact is an early one: after it, landing is near anyway."""

RESET_SUPPORTS = np.arange(0.16, 0.45, 0.04)
"""Durations of the double support that are tried after an early contact (s)."""


LEAST_SWING = 0.2
"""What a step must leave of its time for the swing (s)."""


@dataclass(frozen=True)
class WalkingPatternParams:
    """How LOLA walks."""

    step_time: float = parameter(
        0.8, "from touchdown to touchdown (paper)", "s", minimum=0.4, maximum=3
    )
    double_support: float = parameter(
        0.34, "part of the step in which both feet carry", "s", minimum=0.05, maximum=2.5
    )
    first_double_support: float = parameter(
        0.8, "shift of the load before the first step", "s", minimum=0.2, maximum=5
    )
    last_double_support: float = parameter(
        0.4, "shift of the load after the last step", "s", minimum=0.1, maximum=5
    )
    step_height: float = parameter(0.05, "clearance of the swing foot", "m", minimum=0, maximum=0.2)
    step_width: float = parameter(
        0.23, "distance of the feet sideways", "m", minimum=0.22, maximum=0.5
    )
    com_height: float = parameter(
        0.87, "height of the CoM above the ground", "m", minimum=0.76, maximum=0.92
    )
    zmp_forward: float = parameter(
        -0.03, "ZMP under a loaded foot, forward of the TCP", "m", minimum=-0.1, maximum=0.05
    )
    zmp_inward: float = parameter(
        0.05, "ZMP under a loaded foot, inward of the TCP", "m", minimum=-0.05, maximum=0.09
    )
    blend_time: float = parameter(
        0.1,
        "duration of the blending between force and position control",
        "s",
        minimum=0.001,
        maximum=1,
    )
    contact_blend_time: float = parameter(
        0.02, "the same after an early contact: into force control", "s", minimum=0.001, maximum=1
    )
    ground_stiffness: float = parameter(
        3e5,
        "vertical, of a foot's pads (estimate): how deep a loaded foot sinks in, and U",
        "N/m",
        minimum=5e4,
        maximum=1e7,
    )
    horizontal_lead: float = parameter(
        0.05, "part of the swing before the foot moves forward", "-", minimum=0, maximum=0.4
    )
    horizontal_lag: float = parameter(
        0.15, "part of the swing after it has moved forward", "-", minimum=0, maximum=0.4
    )
    plateau: float = parameter(
        0.1, "part of the swing that the foot stays at its highest", "-", minimum=0, maximum=0.6
    )
    phase_reset: bool = parameter(
        False, "stop the swing and begin the double support at an early contact"
    )
    step_adaptation: bool = parameter(False, "move the foothold after a push")
    late_foot_probing: bool = parameter(
        False, "let the load wait, up to 0.15 s, for a foot that finds no ground"
    )
    height_adaptation: bool = parameter(
        False, "let the plan take over what the feet had to add to their heights"
    )
    ground_behind: float = parameter(
        1.0,
        "height of the ground expected behind an early foothold: 0 as before it, 1 as under it",
        "-",
        minimum=0,
        maximum=1,
    )
    toe_lift: float = parameter(
        0.15, "lift of the toe in the middle of the swing", "rad", minimum=0, maximum=0.6
    )

    def __post_init__(self):
        validate(self)
        if self.double_support > self.step_time - LEAST_SWING:
            allowed = f"<= step_time - {LEAST_SWING:g} s = {self.step_time - LEAST_SWING:.6g} s"
            raise ParameterError("double_support", self.double_support, allowed)

    @property
    def adaptive(self) -> bool:
        """Return whether anything changes a step that is under way."""
        return self.step_adaptation or self.late_foot_probing or self.height_adaptation

    def timing(self) -> GaitTiming:
        """Return the part that the schedule of the gait needs."""
        names = GaitTiming.__dataclass_fields__
        return GaitTiming(**{name: getattr(self, name) for name in names})


REQUEST = Signal(
    "request",
    "What the present plan answers; see `step_request`.",
    (Field("entries", tuple(map(str, range(REQUEST_SIZE))), ""),),
)


PLANNED = (TASK_REFERENCE, GAIT_PHASE, IDEAL_WRENCH, PLANNED_MOTION)
"""What a plan says in every tick."""


ENDS = np.cumsum([REQUEST.size, *(signal.size for signal in PLANNED)])[:-1]
"""Where in the state the request ends, and then each of the signals but the last."""


class Played(NamedTuple):
    """A plan that is played.

    Attributes:
        request: that it answers.
        plan: the plan.
        rows: the block's whole state in every tick of the plan.
    """

    request: StepRequest
    plan: StepPlan
    rows: np.ndarray


class WalkingPattern(Block):
    """Plans each step at its beginning and plays the plan, one row per tick.

    The state is the request that the present plan answers, and the plan's row of this tick. The
    plan itself is a pure function of the request and is kept in a memo, not in the state.
    """

    Params = WalkingPatternParams
    kind = "planning"
    state: ClassVar[tuple[Signal | State, ...]] = (State(REQUEST, hidden=True), *PLANNED)
    held = True
    params: WalkingPatternParams

    def __init__(
        self,
        params: WalkingPatternParams,
        legs: LegModel,
        *,
        steps: np.ndarray | None = None,
        start_time: float = 0.0,
    ):
        """Create the generator, standing at the plan's origin.

        Args:
            params: the gait.
            legs: lumped masses of the robot.
            steps: (forward, left, turn, up) of each step in m and rad, shape (n, 4); None to follow
                the command. A foot that would come upon the other one closes first.
            start_time: when the first of `steps` begins (s).
        """
        self._steps = None if steps is None else with_closing_steps(steps, params.step_width)
        self._start_time = start_time
        self.model = PatternModel(
            timing=params.timing(),
            legs=legs,
            p_TcpZmp=np.array([params.zmp_forward, params.zmp_inward]),
            blend_time=params.blend_time,
            contact_blend_time=params.contact_blend_time,
            ground_stiffness=params.ground_stiffness,
            period=PERIOD,
        )
        self._plans: OrderedDict[bytes, Played] = OrderedDict()
        standing = self._recall(pack_request(standing_request(params))).rows[0]
        names = [signal.name for signal in (REQUEST, *PLANNED)]
        super().__init__(params, initial=dict(zip(names, np.split(standing, ENDS), strict=True)))

    def next_state(self, time, request, contact, walk_command):
        """Return the request and the plan's row of the next tick."""
        request, plan, rows = self._recall(request)
        row = round((time - request.start_time) / PERIOD)
        following = self._following(time, contact, walk_command, request, plan, row)
        if following is not None:
            request, plan, rows = self._recall(pack_request(following))
            row = round((time - request.start_time) / PERIOD)
        return rows[min(row + 1, len(rows) - 1)]

    def _recall(self, packed: np.ndarray) -> Played:
        """Return the plan that answers a request; it is made when it is asked for first."""
        key = packed.tobytes()
        if key not in self._plans:
            request = unpack_request(packed)
            plan = plan_step(self.model, request)
            tables = [getattr(plan, signal.name) for signal in PLANNED]
            rows = np.hstack([np.tile(packed, (len(tables[0]), 1)), *tables])
            self._plans[key] = Played(request, plan, rows)
            if len(self._plans) > 4:
                self._plans.popitem(last=False)
        return self._plans[key]

    def _following(
        self, now, contact, command, request: StepRequest, plan: StepPlan, row: int
    ) -> StepRequest | None:
        """Return the request that replaces the present one in the next tick, if any does."""
        last = len(plan.gait_phase) - 1
        swinging = plan.lift_off < np.inf
        if swinging and self._touches_early(contact, request, plan, row):
            return self.after_early_contact(now, command, request, plan, row)
        if swinging and row + 1 < last:
            return None
        step_index = request.step_index + swinging
        swing = 1 - request.swing if swinging else request.swing
        standing = plan.load == 0.5
        swing, coming = self._next(now, command, step_index, swing, standing)
        if row + 1 < last and not len(coming):
            return None
        row = min(row + 1, last)
        first = self.params.first_double_support if standing else self.params.double_support
        return replace(
            continued(request, plan, row),
            step_index=step_index,
            swing=swing,
            load=plan.load,
            path=plan.path,
            ground=request.ground + rise(request),
            support=first,
            displacements=coming,
        )

    def _touches_early(self, contact, request: StepRequest, plan: StepPlan, row: int) -> bool:
        """Return whether the swing foot has met the ground where it should not yet."""
        if not self.params.phase_reset:
            return False
        swing = (row * PERIOD - plan.lift_off) / (plan.duration - plan.lift_off)
        if not EARLY[0] < swing < EARLY[1]:
            return False
        return bool(contact[4 * request.swing : 4 * request.swing + 4].any())

    def after_early_contact(
        self, now, command, request: StepRequest, plan: StepPlan, row: int
    ) -> StepRequest:
        """Return the request that takes the touched ground for the foothold: the phase reset.

        The foot stops where it is, and the double support begins. Its duration is the one for
        which the CoM, as it moves now, asks for the least shift of the ZMP. Behind the foothold
        the ground is expected at the foothold's height, as the paper tells of its board (V.A), or
        lower (`ground_behind`).
        """
        stopped, behind = continued(request, plan, row), self.params.ground_behind
        foot, side = stopped.feet[request.swing], 1.0 if request.swing == LEFT else -1.0
        planned, swing = request.ground + rise(request), 1 - request.swing
        landed = replace(
            stopped,
            step_index=request.step_index + 1,
            swing=swing,
            load=float(request.swing == RIGHT),
            path=advance(foot[[0, 1, 3]], np.array([0.0, -side * self.params.step_width / 2, 0.0])),
            ground=planned + behind * (foot[2] - planned),
            displacements=self._next(now, command, request.step_index + 1, swing, False)[1],
        )
        return self.smoothest([replace(landed, support=support) for support in RESET_SUPPORTS])

    def smoothest(self, candidates: list[StepRequest]) -> StepRequest:
        """Return the request that asks for the least shift of the ZMP."""
        shifts = [np.abs(zmp_shift(self.model, c)).max() for c in candidates]
        return candidates[int(np.argmin(shifts))]

    def _next(
        self, now, command, step_index: int, swing: int, standing: bool
    ) -> tuple[int, np.ndarray]:
        """Return the foot that goes next, and the next steps, at most the horizon.

        From standing it is the foot on the side to which it goes, where the other one would be in
        its way.
        """
        width = self.params.step_width
        if self._steps is not None:
            begun = now >= self._start_time - 0.5 * PERIOD
            steps = self._steps[step_index : step_index + HORIZON] if begun else np.zeros((0, 4))
            if standing and len(steps):
                swing = first_foot(steps[0], width, swing)
            return swing, steps
        step = limited_step(np.append(command * self.params.step_time, 0.0))
        if not step.any():
            return swing, np.zeros((0, 4))
        if standing:
            swing = first_foot(step, width, swing)
        return swing, paired_steps(step, swing, HORIZON, width)


def rise(request: StepRequest) -> float:
    """Return by how much the step that begins goes up (m)."""
    return float(request.displacements[0, UP]) if len(request.displacements) else 0.0


def continued(request: StepRequest, plan: StepPlan, row: int) -> StepRequest:
    """Return the request with the plan's motion in a row as its start."""
    motion = plan.planned_motion[row]
    return replace(
        request,
        start_time=request.start_time + row * PERIOD,
        com=motion[PLANNED_MOTION.slice("com")],
        com_velocity=motion[PLANNED_MOTION.slice("com_velocity")],
        feet=(motion[PLANNED_MOTION.slice("foot_l")], motion[PLANNED_MOTION.slice("foot_r")]),
        heading=float(motion[PLANNED_MOTION.index("heading")]),
        blend=plan.gait_phase[row, GAIT_PHASE.slice("blend")],
    )


def standing_request(params: WalkingPatternParams) -> StepRequest:
    """Return the request of a robot that stands at the plan's origin."""
    feet = []
    for foot in (LEFT, RIGHT):
        x, y, yaw = foothold(np.zeros(3), foot, params.step_width)
        feet.append(np.array([x, y, 0.0, yaw]))
    return StepRequest(
        start_time=0.0,
        step_index=0,
        swing=LEFT,
        load=0.5,
        com=np.array([params.zmp_forward, 0.0, params.com_height]),
        com_velocity=np.zeros(3),
        feet=(feet[0], feet[1]),
        path=np.zeros(3),
        ground=0.0,
        heading=0.0,
        support=params.first_double_support,
        blend=np.ones(2),
        displacements=np.zeros((0, 4)),
    )
