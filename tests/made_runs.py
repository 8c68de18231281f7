"""Rows of made-up runs, for tests of what is kept of studies."""

import dataclasses

from lola_drake.scenario import Scenario
from lola_drake.studies.row import row_of


def made(seed, scenario=None, **changes):
    """Return the row of a made-up run of a scenario, by default one that has but a seed."""
    summary = {
        "scenario": "made_up",
        "variant": "dyn",
        "seed": seed,
        "completed": True,
        "fell": False,
        "fall_time_s": None,
        "error": None,
        "max_inclination_deg": {"x": 1.0, "y": seed / 10},
        "wall_time_s": 2.0,
        "versions": {"drake": "1"},
    } | changes
    row = row_of(f"key {seed}", scenario or Scenario(seed=seed), summary, "1@here", 1)
    return dataclasses.replace(row, versions={"drake": "1"})
