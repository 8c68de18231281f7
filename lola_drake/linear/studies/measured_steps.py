"""Steps of several heights in the nonlinear simulation, and what the linear model says of them."""

from typing import NamedTuple

import numpy as np

from lola_drake.linear.studies.analyses import Analysis, settled_step
from lola_drake.linear.studies.operating_points import Situation
from lola_drake.linear.tick_loop import TickLoop

FACTORS = (1.0, 10.0, 40.0)
"""Heights of the steps over that of an analysis."""

LONGEST = 1.5
"""What is simulated after a step (s)."""


class Steps(NamedTuple):
    """One output after steps at one input, each over its height.

    Attributes:
        name: of input and output.
        times: after the step (s), shape (n,).
        linear: what the model says, shape (n,).
        simulated: what the simulation does, by the height of the step, each of shape (n,).
    """

    name: str
    times: np.ndarray
    linear: np.ndarray
    simulated: dict[float, np.ndarray]


def measured_steps(analysis: Analysis, factors: tuple[float, ...] = FACTORS) -> list[Steps]:
    """Return steps at each input of an analysis to the output of the same number."""
    found, definition = [], analysis.definition
    pairs = zip(definition.inputs, definition.outputs, definition.steps, strict=False)
    for k, (signal, output, height) in enumerate(pairs):
        times, outputs, _ = settled_step(analysis.model, k, height)
        times = times[: round(LONGEST / analysis.model.dt)]
        simulated = {
            factor * height: _simulated(
                analysis.workpoint.situation, signal, output, factor * height, len(times)
            )
            for factor in factors
        }
        linear = outputs[: len(times), k] / height
        found.append(Steps(f"{signal} -> {output}", times, linear, simulated))
    return found


def _simulated(
    situation: Situation, signal: str, output: str, height: float, count: int
) -> np.ndarray:
    """Return what a step changes, over its height, shape (count,)."""
    rows = []
    for added in (0.0, height):
        ticks = TickLoop(situation.diagram, situation.context)
        rows.append(ticks.run([output], count, signal, np.full((count, 1), added))[:, 0])
    return (rows[1] - rows[0]) / height
