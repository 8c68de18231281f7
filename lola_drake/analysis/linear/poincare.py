"""The gait's own stability: the stride-to-stride map and its Floquet multipliers.

A gait is a motion that repeats itself from stride to stride, relative to where the robot is. In
the middle of a swing the state (robot, sensors, filters, controllers) is moved by a little, in one
direction after the other, both ways, and each time a whole stride of two steps is simulated:
contact, ground and plan as they are. What is left of the motions after the stride is the Poincare
map's derivative; its eigenvalues, the multipliers, say how fast a disturbance dies out. The sensors
are quiet, for noise would make every stride another one.

Many states (delay lines, filters) forget within a few ticks. The stride's first ticks, in which no
contact changes, are therefore taken by their exact linear maps, and only the directions that
survive them are flown.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from joblib import Parallel, delayed
from pydrake.systems.framework import Context, Diagram

from lola_drake.analysis.linear.coordinates import Coordinates, coordinates
from lola_drake.analysis.linear.cut_blocks import discrete_state, set_discrete_state
from lola_drake.analysis.linear.errors import AnalysisError
from lola_drake.analysis.linear.linear_blocks import FROZEN, SWITCHING, linear_blocks
from lola_drake.analysis.linear.operating_points import quiet
from lola_drake.analysis.linear.poles import neutral
from lola_drake.analysis.linear.ticks import Ticks
from lola_drake.analysis.linear.wiring import Wiring
from lola_drake.controller import PERIOD
from lola_drake.scenario import Scenario, override
from lola_drake.signals import GAIT_PHASE
from lola_drake.simulation import build_simulation, has_fallen

STEPS_PER_STRIDE = 2
SETTLED = 1e-6
"""How far a stride may miss its own beginning, relative to what is a lot."""

MOST_STRIDES = 12
"""After how many strides the gait must have settled."""

TRIED = (3e-4, 1e-4, 3e-5, 1e-5)
"""Steps among which the convergence check chooses, relative to what is a lot."""

PROBES = 3
"""Number of random directions of the convergence check."""

FORGETTING, FORGOTTEN = 40, 1e-6
"""Ticks that are taken by their linear maps, and what part of a motion then counts as forgotten."""

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
        strides: walked before.
    """

    scenario: Scenario
    time: float
    state: np.ndarray
    ticks: int
    miss: float
    strides: int


@dataclass(frozen=True)
class Multiplier:
    """One Floquet multiplier, or one of a conjugate pair.

    Attributes:
        value: by which a motion is multiplied in a stride.
        dominating: the state that takes part in it most.
        neutral: whether it is the robot's place or heading, which nothing pulls back.
    """

    value: complex
    dominating: str
    neutral: bool


@dataclass(frozen=True)
class StrideMap:
    """The derivative of the stride-to-stride map.

    Attributes:
        section: where it is taken.
        matrix: the derivative, in coordinates of small motions over what is a lot for each.
        names: of the states.
        step: of the differences, relative to what is a lot.
        convergence: for each step tried, the relative change of the probes to the next one.
    """

    section: Section
    matrix: np.ndarray
    names: list[str]
    step: float
    convergence: dict[float, float]

    def multipliers(self) -> list[Multiplier]:
        """Return the multipliers, largest first; pairs appear once."""
        values, left, right = scipy.linalg.eig(self.matrix, left=True, right=True)
        part = np.abs(left.conj() * right)
        place = neutral(self.names)
        order = [i for i in np.argsort(-np.abs(values)) if values[i].imag >= 0]
        found = []
        for i in order:
            share = part[place, i].sum() / max(part[:, i].sum(), 1e-300)
            name = self.names[int(part[:, i].argmax())]
            found.append(Multiplier(complex(values[i]), name, bool(share > 0.5)))
        return found

    @property
    def radius(self) -> float:
        """Return the largest magnitude of a multiplier that is not neutral."""
        return max(abs(m.value) for m in self.multipliers() if not m.neutral)


def stride_map(
    scenario: Scenario, jobs: int = 2, done: Callable[[int, int], None] | None = None
) -> StrideMap:
    """Return the stride-to-stride map of a scenario's gait.

    Args:
        scenario: walks straight or in a curve with equal steps; its first group of steps is what
            it does without end.
        jobs: number of processes.
        done: called with the number of finished runs, and of all.

    Raises:
        AnalysisError: if the scenario does not walk, or the gait does not settle.
    """
    section = find_section(scenario)
    later, lasting, forgetting = forget(section)
    step, convergence = converged_step(later, lasting, jobs)
    flown = fly(later, step * lasting.T, jobs, done) / step
    names = moving_coordinates(*section_context(section)).names
    return StrideMap(section, flown @ forgetting, names, step, convergence)


def forget(section: Section) -> tuple[Section, np.ndarray, np.ndarray]:
    """Take the first ticks of a stride by their linear maps.

    Returns:
        Where they end, the directions that last until then as orthonormal columns, shape (n, r),
        and what motions at the section become along them, shape (r, n).
    """
    diagram, context = section_context(section)
    ticks = Ticks(diagram, context)
    frame = moving_coordinates(diagram, context)
    scale, product = typical(frame), np.eye(len(frame.names))
    for _ in range(FORGETTING):
        A = linear_blocks(diagram, ticks.context, [], []).interconnect([], []).A
        product = (A * scale / scale[:, None]) @ product
        ticks.advance()
    left, values, right = np.linalg.svd(product)
    lasting = values > FORGOTTEN * values[0]
    later = replace(
        section,
        time=ticks.context.get_time(),
        state=discrete_state(ticks.context),
        ticks=section.ticks - FORGETTING,
    )
    return later, left[:, lasting], values[lasting, None] * right[lasting]


def find_section(scenario: Scenario) -> Section:
    """Walk until the gait repeats itself, and return the middle of a swing of the left foot."""
    endless = quiet(_without_end(scenario))
    diagram = build_simulation(endless)
    ticks = Ticks(diagram, diagram.CreateDefaultContext())
    frame = moving_coordinates(diagram, ticks.context)
    stride = round(STEPS_PER_STRIDE * endless.pattern.step_time / PERIOD)
    _walk_to_swing(ticks)
    for strides in range(1, MOST_STRIDES + 1):
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
    return Section(endless, time, state, stride, miss, strides)


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
    still = (*FROZEN, *SWITCHING)
    paths = [p for p, block in wiring.blocks.items() if type(block).__name__ not in still]
    return coordinates(wiring, context, paths)


def typical(frame: Coordinates) -> np.ndarray:
    """Return what is a lot in a gait: 1 rad or m, 10 rad/s or m/s, and 10 kN or kNm."""
    forces = frame.scales > 1
    fast = np.array([bool(_FAST.search(name)) for name in frame.names])
    return np.where(forces, 1e4, np.where(fast, 10.0, 1.0))


def converged_step(
    section: Section, lasting: np.ndarray, jobs: int = 2
) -> tuple[float, dict[float, float]]:
    """Return the step at which the differences change least from one step to the next.

    A few random directions out of the lasting ones are flown with every step.
    """
    count = lasting.shape[1]
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (PROBES, count))
    directions = signs @ lasting.T / np.sqrt(count)
    motions = np.vstack([step * directions for step in TRIED])
    flown = fly(section, motions, jobs).T.reshape(len(TRIED), PROBES, -1)
    found = flown / np.array(TRIED)[:, None, None]
    changes = {
        step: float(np.linalg.norm(found[k + 1] - found[k]) / np.linalg.norm(found[k]))
        for k, step in enumerate(TRIED[:-1])
    }
    return min(changes, key=changes.get), changes


def fly(
    section: Section,
    motions: np.ndarray,
    jobs: int = 2,
    done: Callable[[int, int], None] | None = None,
) -> np.ndarray:
    """Return half the difference of where motions to both sides lead in a stride.

    Args:
        section: where the stride begins.
        motions: one per row, relative to what is a lot; shape (k, n).
        jobs: number of processes.
        done: called with the number of finished runs, and of all.

    Returns:
        One column per motion, relative to what is a lot; shape (n, k).
    """
    batches = np.array_split(motions, max(1, min(len(motions), 8 * jobs)))
    columns, finished = [], 0
    runs = Parallel(n_jobs=jobs, return_as="generator")(
        delayed(_fly_batch)(section, batch) for batch in batches
    )
    for batch, result in zip(batches, runs, strict=True):
        columns.append(result)
        finished += len(batch)
        if done:
            done(finished, len(motions))
    return np.vstack(columns).T


def _fly_batch(section: Section, motions: np.ndarray) -> np.ndarray:
    diagram, start = section_context(section)
    frame = moving_coordinates(diagram, start)
    scale = typical(frame)
    found = []
    for motion in motions:
        ahead, behind = (
            _flown(diagram, frame, start, sign * motion * scale, section.ticks) for sign in (1, -1)
        )
        found.append(0.5 * frame.difference(ahead, behind) / scale)
    return np.array(found)


def _flown(diagram, frame: Coordinates, start: Context, motion: np.ndarray, count: int) -> Context:
    ticks = Ticks(diagram, start)
    frame.move(ticks.context, motion)
    for _ in range(count):
        ticks.advance()
    return ticks.context


def _walk_to_swing(ticks: Ticks) -> None:
    """Advance to the middle of the right foot's support in the third step."""
    phase = GAIT_PHASE
    for _ in range(20000):
        row = ticks.run(["gait_phase"], 1)[0]
        left, right = row[phase.slice("support")]
        if row[phase.index("step_index")] >= 3 and right > 0.5 > left:
            break
    else:
        raise AnalysisError("the scenario does not walk")
    for _ in range(200):
        ticks.advance()


def _without_end(scenario: Scenario) -> Scenario:
    if not scenario.walk.steps:
        raise AnalysisError(f"{scenario.name} has no steps: its gait has no stride")
    count = 10 + STEPS_PER_STRIDE * (MOST_STRIDES + 2)
    return override(scenario, {"walk.steps": scenario.walk.steps[:1], "walk.steps.0.count": count})


def _fallen(diagram: Diagram, context: Context) -> bool:
    plant = diagram.GetSubsystemByName("plant")
    return has_fallen(plant.GetPositions(plant.GetMyContextFromRoot(context)))
