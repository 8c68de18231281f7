"""The walking controller of the humanoid LOLA as a Drake block diagram."""

from lola_drake.results import Result, load_result
from lola_drake.scenario import Scenario, ScenarioError, load_scenario
from lola_drake.simulation import build_simulation, simulate

__all__ = [
    "Result",
    "Scenario",
    "ScenarioError",
    "build_simulation",
    "load_result",
    "load_scenario",
    "simulate",
]
