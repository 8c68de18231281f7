"""Where to linearise: standing, on one foot, in any pose, or at any moment of any scenario."""

import re
from dataclasses import dataclass

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

from lola_drake.linear.equilibrium import find_equilibrium
from lola_drake.linear.errors import AnalysisError, drake_errors
from lola_drake.linear.studies.poses import Pose, place
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.plant import has_fallen
from lola_drake.scenario import Scenario, override
from lola_drake.world import build_simulation

QUIET = (
    "sensors.imu.angle_noise",
    "sensors.imu.rate_noise",
    "sensors.imu.angle_bias",
    "sensors.foot_force.force_noise",
    "sensors.foot_force.torque_noise",
)
SETTLING = (50, 450, 1500)
"""Ticks in which the contacts find their states before Newton's method tries, again and again."""


STANDING, ON_LEFT, ON_RIGHT = Pose(), Pose(load=1.0), Pose(load=0.0)
POSES = {"stand": STANDING, "left": ON_LEFT, "right": ON_RIGHT}


@dataclass(frozen=True)
class Situation:
    """A diagram and a context of it, ready to be linearised.

    Attributes:
        diagram: the closed loop.
        context: the operating point.
        residual: the drift that is left in an equilibrium, as in `linearize`; None elsewhere.
        description: in a few words.
    """

    diagram: Diagram
    context: Context
    residual: float | None
    description: str


def quiet(scenario: Scenario) -> Scenario:
    """Return the scenario with sensors that keep their delays and filters, but have no errors."""
    return override(scenario, dict.fromkeys(QUIET, 0.0))


def situation(scenario: Scenario, at: str) -> Situation:
    """Return the operating point that a text means.

    Args:
        scenario: what runs, or stands.
        at: `stand`, `left` or `right` (the stance foot), `t=3.2` for a time of the scenario (s),
            or values of a `Pose` such as `load=0.7 stride=0.2`.
    """
    if at in POSES:
        return in_pose(scenario, POSES[at], at)
    values = dict(re.findall(r"(\w+)=(-?[\d.]+(?:e-?\d+)?)(?:[\s,]+|$)", at))
    if not values or re.sub(r"\w+=\S+?(?:[\s,]+|$)", "", at):
        known = ", ".join(POSES)
        raise AnalysisError(
            f"no operating point {at!r}: say {known}, t=SECONDS, or values of a pose"
        )
    if set(values) == {"t"}:
        return at_time(scenario, float(values["t"]))
    try:
        return in_pose(scenario, Pose(**{k: float(v) for k, v in values.items()}), at)
    except TypeError:
        raise AnalysisError(
            f"no operating point {at!r}: a pose has {', '.join(Pose.__dataclass_fields__)}"
        ) from None


def in_pose(scenario: Scenario, pose: Pose, description: str = "pose") -> Situation:
    """Return the equilibrium in a pose, with quiet sensors and a frozen plan.

    Raises:
        AnalysisError: if the robot cannot rest there.
    """
    diagram = build_simulation(quiet(scenario))
    context = diagram.CreateDefaultContext()
    place(diagram, context, scenario, pose)
    ticks = TickLoop(diagram, context)
    for count in SETTLING:
        with drake_errors("the pose cannot be held"):
            for _ in range(count):
                ticks.advance()
        try:
            return Situation(diagram, *find_equilibrium(diagram, ticks.context), description)
        except AnalysisError as error:
            failure = error
    raise failure


def at_time(scenario: Scenario, time: float) -> Situation:
    """Return the loop as it is at a time of the scenario (s)."""
    if not 0 <= time <= scenario.duration:
        raise AnalysisError(f"{scenario.name} lasts {scenario.duration:g} s, {time:g} s is outside")
    diagram = build_simulation(scenario)
    simulator = Simulator(diagram)
    plant = diagram.GetSubsystemByName("plant")
    with drake_errors(f"{scenario.name} cannot be simulated"):
        simulator.AdvanceTo(time)
    context = simulator.get_context()
    if has_fallen(plant.GetPositions(plant.GetMyContextFromRoot(context))):
        raise AnalysisError(f"{scenario.name}: the robot has fallen before {time:g} s")
    return Situation(diagram, context.Clone(), None, f"{scenario.name} at {time:g} s")
