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

Contact switches change by whole ticks. Where something hangs on them, as the CoM's dynamics do, a
motion that moves a switch by a tick jumps; the step is small enough for that not to happen, so
the derivative is that between the jumps.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.linalg
from pydrake.systems.framework import Context, Diagram

from lola_drake.linear.coordinates import Coordinates
from lola_drake.linear.isolated import discrete_state
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.linear.poles import neutral
from lola_drake.linear.studies.gait_section import (
    INTO_SWING,
    Section,
    find_section,
    moving_coordinates,
    section_context,
    typical,
)
from lola_drake.linear.text_table import Table
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.scenario import Scenario
from lola_drake.signals import PERIOD
from lola_drake.workers import in_order

TRIED = (1e-4, 1e-5, 3e-6, 1e-6)
"""Steps among which the convergence check chooses, relative to what is a lot."""

CONVERGED = 1e-2
"""Largest change from one step to the next that is let pass without a word."""

PROBES = 3
"""Number of random directions of the convergence check."""

FORGETTING, FORGOTTEN = 0.5, 1e-5
"""Part of what is left of the swing that is taken by linear maps, and what part of a motion then
counts as forgotten: the differences that are flown are not more exact."""

SHOWN = 12
"""How many multipliers are listed."""

PLACE, POSTURE, MOTION = "place and heading", "posture", "motion"
"""Kinds of multipliers: of the robot's place and heading, which nothing pulls back; of the posture
that the inverse kinematics forgets by its own law, whatever the robot does; and of the rest, torso,
CoM and legs, whose motion is what a gait's stability is about."""


@dataclass(frozen=True)
class Multiplier:
    """One Floquet multiplier, or one of a conjugate pair.

    Attributes:
        value: by which a motion is multiplied in a stride.
        dominating: the state that takes part in it most.
        kind: `PLACE`, `POSTURE` or `MOTION`.
    """

    value: complex
    dominating: str
    kind: str


@dataclass(frozen=True)
class StrideMap:
    """The derivative of the stride-to-stride map.

    Attributes:
        section: where it is taken.
        matrix: the derivative, in coordinates of small motions over what is a lot for each.
        names: of the states.
        step: of the differences, relative to what is a lot.
        convergence: for each step tried, the relative change of the probes from the one before.
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
        kinds = {
            PLACE: neutral(self.names),
            POSTURE: np.array(["/inverse_kinematics/" in f"/{name}" for name in self.names]),
        }
        order = [i for i in np.argsort(-np.abs(values)) if values[i].imag >= 0]
        found = []
        for i in order:
            half = 0.5 * part[:, i].sum()
            kind = next((k for k, of in kinds.items() if part[of, i].sum() > half), MOTION)
            name = self.names[int(part[:, i].argmax())]
            found.append(Multiplier(complex(values[i]), name, kind))
        return found

    def as_text(self) -> str:
        """Return how it was found, and the largest multipliers."""
        section, tried = self.section, self.convergence.items()
        rows = tuple(
            (f"{m.value:.4f}", f"{abs(m.value):.4f}", m.kind, m.dominating)
            for m in self.multipliers()[:SHOWN]
        )
        table = Table("Floquet multipliers", ("value", "magnitude", "of", "dominated by"), rows)
        checks = ", ".join(f"{step:g}: {change:.1e}" for step, change in tried)
        converged = self.convergence[self.step] <= CONVERGED
        return "\n".join(
            [
                f"section in mid-swing at {section.time:.3f} s; the stride of {section.ticks} "
                f"ticks misses its beginning by {section.miss:.1e}",
                f"change of the differences from step to step: {checks}; step {self.step:g} taken"
                + ("" if converged else "; NOT converged, the multipliers are a guess"),
                table.as_text(),
                f"largest multiplier of torso, CoM and legs: {self.radius:.2g}; "
                f"of the inverse kinematics' own posture: {self.largest(POSTURE):.2g}",
            ]
        )

    def as_numbers(self) -> dict[str, object]:
        """Return the multipliers and how they were found as what JSON can hold."""
        return {
            "time_s": self.section.time,
            "stride_ticks": self.section.ticks,
            "miss": self.section.miss,
            "step": self.step,
            "convergence": {str(step): change for step, change in self.convergence.items()},
            "radius": self.radius,
            "posture_radius": self.largest(POSTURE),
            "multipliers": [
                {
                    "value": [m.value.real, m.value.imag],
                    "dominating": m.dominating,
                    "kind": m.kind,
                }
                for m in self.multipliers()
            ],
        }

    @property
    def radius(self) -> float:
        """Return the largest magnitude of a multiplier of torso, CoM and legs."""
        return self.largest(MOTION)

    def largest(self, kind: str) -> float:
        """Return the largest magnitude of a multiplier of a kind; 0 without any."""
        return max((abs(m.value) for m in self.multipliers() if m.kind == kind), default=0.0)


def stride_map(
    scenario: Scenario, jobs: int = 2, done: Callable[[int, int], None] | None = None
) -> StrideMap:
    """Return the stride-to-stride map of a scenario's gait.

    Args:
        scenario: walks straight or in a curve with equal steps; its first group of steps is what
            it does without end.
        jobs: number of processes.
        done: called with the number of finished batches of runs, and of all.

    Raises:
        AnalysisError: if the scenario does not walk, or the robot falls before its gait has
            settled; how well it has is said by `Section.miss`.
    """
    section = find_section(scenario)
    swing = scenario.pattern.step_time - scenario.pattern.double_support - INTO_SWING
    count = max(round(FORGETTING * swing / PERIOD), 0)
    later, lasting, forgetting = forget(section, count)
    step, convergence = converged_step(later, lasting, jobs)
    flown = fly(later, step * lasting.T, jobs, done) / step
    names = moving_coordinates(*section_context(section)).names
    return StrideMap(section, flown @ forgetting, names, step, convergence)


def forget(section: Section, count: int) -> tuple[Section, np.ndarray, np.ndarray]:
    """Take the first ticks of a stride by their linear maps.

    Args:
        section: where the stride begins.
        count: of the ticks, in which no contact may change.

    Returns:
        Where they end, the directions that last until then as orthonormal columns, shape (n, r),
        and what motions at the section become along them, shape (r, n).
    """
    diagram, context = section_context(section)
    ticks = TickLoop(diagram, context)
    frame = moving_coordinates(diagram, context)
    scale, product = typical(frame), np.eye(len(frame.names))
    for _ in range(count):
        A = linear_blocks(diagram, ticks.context, [], []).interconnect([], []).A
        product = (A * scale / scale[:, None]) @ product
        ticks.advance()
    left, values, right = np.linalg.svd(product)
    lasting = values > FORGOTTEN * values[0]
    later = replace(
        section,
        time=ticks.context.get_time(),
        state=discrete_state(ticks.context),
        ticks=section.ticks - count,
    )
    return later, left[:, lasting], values[lasting, None] * right[lasting]


def converged_step(
    section: Section, lasting: np.ndarray, jobs: int = 2
) -> tuple[float, dict[float, float]]:
    """Return the step of the differences, and how they change from each step to the next.

    A few random directions out of the lasting ones are flown with every step. The step is the
    smaller one of the two between which they change least.
    """
    count = lasting.shape[1]
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (PROBES, count))
    directions = signs @ lasting.T / np.sqrt(count)
    motions = np.vstack([step * directions for step in TRIED])
    flown = fly(section, motions, jobs).T.reshape(len(TRIED), PROBES, -1)
    found = flown / np.array(TRIED)[:, None, None]
    changes = {
        step: float(np.linalg.norm(found[k + 1] - found[k]) / np.linalg.norm(found[k]))
        for k, step in enumerate(TRIED[1:])
    }
    return min(changes, key=changes.__getitem__), changes


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
        done: called with the number of finished batches of runs, and of all.

    Returns:
        One column per motion, relative to what is a lot; shape (n, k).
    """
    batches = np.array_split(motions, max(1, min(len(motions), 8 * jobs)))
    return np.vstack(in_order(jobs, partial(_fly_batch, section), batches, done)).T


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


def _flown(
    diagram: Diagram, frame: Coordinates, start: Context, motion: np.ndarray, count: int
) -> Context:
    ticks = TickLoop(diagram, start)
    frame.move(ticks.context, motion)
    for _ in range(count):
        ticks.advance()
    return ticks.context
