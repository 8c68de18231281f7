"""The worst runs of a study, each with the command that simulates it again."""

import math
from collections.abc import Sequence

from lola_drake.scenario import Scenario
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.run_key import run_key
from lola_drake.studies.study import Study


def worst(
    study: Study, scenarios: Sequence[Scenario], summaries: Sequence[Summary], count: int
) -> list[dict[str, object]]:
    """Return the runs that failed, then the falls, the earliest first, then the most inclined.

    Args:
        study: where they are kept.
        scenarios: what was run.
        summaries: of each.
        count: the most of them.
    """
    pairs = sorted(zip(scenarios, summaries, strict=True), key=lambda pair: _goodness(pair[1]))
    keys = [run_key(scenario) for scenario, _ in pairs[:count]]
    numbers = study.store.numbers(keys)
    return [
        {
            "run": numbers[key],
            "variant": summary["variant"],
            "seed": summary["seed"],
            "fall_time_s": summary["fall_time_s"],
            "fall_events": summary.get("fall_events", []),
            "error": summary["error"],
            "max_inclination_deg": summary.get("max_inclination_deg"),
            "command": f"lola study replay {study.store.file} {numbers[key]}",
        }
        for key, (_, summary) in zip(keys, pairs, strict=False)
    ]


def _goodness(summary: Summary) -> tuple[float, float]:
    if summary["error"]:
        return 0.0, 0.0
    if not survived(summary):
        return 1.0, float(summary["fall_time_s"])
    inclined = summary["max_inclination_deg"].values()
    return 2.0, -math.hypot(*(value or 0.0 for value in inclined))
