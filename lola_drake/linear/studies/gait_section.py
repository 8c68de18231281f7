"""A moment of a gait at which every stride is looked at, once the gait repeats itself."""

import re
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, Diagram

from lola_drake.linear.coordinates import Coordinates, coordinates
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import discrete_state, set_discrete_state
from lola_drake.linear.linear_blocks import is_held
from lola_drake.linear.poles import neutral
from lola_drake.linear.studies.operating_points import quiet
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.linear.wiring import Wiring
from lola_drake.plant import has_fallen
from lola_drake.scenario import Scenario, override
from lola_drake.signals import GAIT_PHASE, PERIOD
from lola_drake.world import build_simulation

STEPS_PER_STRIDE = 2
SETTLED = 1e-6
"""How far a stride may miss its own beginning, relative to what is a lot."""

INTO_SWING = 0.2
"""How far into the swing of the left foot the section is (s)."""

MOST_STRIDES = 12
"""After how many strides the gait must have settled."""

_FAST = re.compile(r"/v/|dot|rate")


@dataclass(frozen=True)
class Section:
    """Where every stride is looked at.

    Attributes:
        scenario: that walks, with quiet sensors and steps without end.
        time: of the section (s).
        state: of the whole diagram, as one vector.
        ticks: of one stride.
        miss: by how much the stride misses its beginning, relative to what is a lot.
    """

    scenario: Scenario
    time: float
    state: np.ndarray
    ticks: int
    miss: float


def find_section(scenario: Scenario) -> Section:
    """Walk until the gait repeats itself, and return the middle of a swing of the left foot."""
    endless = quiet(_without_end(scenario))
    diagram = build_simulation(endless)
    ticks = TickLoop(diagram, diagram.CreateDefaultContext())
    frame = moving_coordinates(diagram, ticks.context)
    stride = round(STEPS_PER_STRIDE * endless.pattern.step_time / PERIOD)
    _walk_to_swing(ticks)
    for _ in range(MOST_STRIDES):
        before = ticks.context.Clone()
        for _ in range(stride):
            ticks.advance()
        if _fallen(diagram, ticks.context):
            raise AnalysisError(f"{scenario.name}: the robot falls before its gait has settled")
        miss = frame.difference(ticks.context, before) / typical(frame)
        miss = float(np.abs(miss[~neutral(frame.names)]).max())
        if miss < SETTLED:
            break
    state, time = discrete_state(ticks.context), ticks.context.get_time()
    return Section(endless, time, state, stride, miss)


def section_context(section: Section) -> tuple[Diagram, Context]:
    """Return the diagram of a section, and a context there."""
    diagram = build_simulation(section.scenario)
    context = diagram.CreateDefaultContext()
    context.SetTime(section.time)
    set_discrete_state(context, section.state)
    return diagram, context


def moving_coordinates(diagram: Diagram, context: Context) -> Coordinates:
    """Return the states that are moved: all but those of the plan and the switches."""
    wiring = Wiring(diagram)
    paths = [path for path, block in wiring.blocks.items() if not is_held(block)]
    return coordinates(wiring, context, paths)


def typical(frame: Coordinates) -> np.ndarray:
    """Return what is a lot in a gait: 1 rad or m, 10 rad/s or m/s, and 10 kN or kNm."""
    forces = frame.scales > 1
    fast = np.array([bool(_FAST.search(name)) for name in frame.names])
    return np.where(forces, 1e4, np.where(fast, 10.0, 1.0))


def _walk_to_swing(ticks: TickLoop) -> None:
    """Advance to the middle of the right foot's support in the third step."""
    phase = GAIT_PHASE
    for _ in range(20000):
        row = ticks.run(["gait_phase"], 1)[0]
        left, right = row[phase.slice("support")]
        if row[phase.index("step_index")] >= 3 and right > 0.5 > left:
            break
    else:
        raise AnalysisError("the scenario does not walk")
    for _ in range(round(INTO_SWING / PERIOD)):
        ticks.advance()


def _without_end(scenario: Scenario) -> Scenario:
    if not scenario.walk.steps:
        raise AnalysisError(f"{scenario.name} has no steps: its gait has no stride")
    count = 10 + STEPS_PER_STRIDE * (MOST_STRIDES + 2)
    return override(scenario, {"walk.steps": scenario.walk.steps[:1], "walk.steps.0.count": count})


def _fallen(diagram: Diagram, context: Context) -> bool:
    plant = diagram.GetSubsystemByName("plant")
    return has_fallen(plant.GetPositions(plant.GetMyContextFromRoot(context)))
