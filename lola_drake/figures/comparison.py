"""How several runs in one figure are told apart: by colour and name."""

from collections.abc import Sequence

from lola_drake.figures.style import FIRST, INK, LEFT, RIGHT
from lola_drake.results import Result

RUN_COLOURS = (INK, RIGHT, LEFT, FIRST)
"""The first run is what the others are compared with: it is drawn in the colour of text."""


def labels(results: Sequence[Result]) -> list[str]:
    """Return short, different names for runs: what tells them apart."""
    scenarios = [result.scenario for result in results]
    for of in (
        lambda scenario: scenario.variant,
        lambda scenario: scenario.active_control().law,
        lambda scenario: f"{scenario.active_control().law} {scenario.variant}",
        lambda scenario: scenario.name,
        lambda scenario: f"{scenario.name} {scenario.variant}",
        lambda scenario: f"{scenario.name} {scenario.variant} seed {scenario.seed}",
    ):
        names = [of(scenario) for scenario in scenarios]
        if len(set(names)) == len(names):
            return names
    return [f"{name} ({i + 1})" for i, name in enumerate(names)]
