"""Closed loops, each run once per worker however many tests look at it."""

import functools

import pytest

from lola_drake.results import Result
from lola_drake.scenario import load_scenario
from lola_drake.simulation import simulate


@functools.cache
def _run(name: str, overrides: tuple[str, ...]) -> Result:
    return simulate(load_scenario(name, overrides))


@pytest.fixture
def run():
    """Return a function that runs a scenario with overrides such as "duration=2"."""
    return lambda name, *overrides: _run(name, overrides)
