"""One scenario in several variants, side by side."""

from collections.abc import Mapping, Sequence

from joblib import Parallel, delayed

from lola_drake.results import Result
from lola_drake.scenario import Scenario, override

COMPARISON = "compare.json"

COMPARED = (
    "max_inclination_deg",
    "rms_torque_error_Nm",
    "settling_time_s",
    "max_com_vertical_acceleration_m_per_s2",
    "max_foot_force_N",
    "max_slip_m",
)
"""The metrics of which changes are stated; from all of them, less is better."""

Summary = Mapping[str, object]


def in_variant(scenario: Scenario, variant: str) -> Scenario:
    """Return the scenario in another variant of the controller; ScenarioError if there is none."""
    return override(scenario, {"variant": variant})


def run_variants(scenario: Scenario, variants: Sequence[str], jobs: int = 2) -> list[Result]:
    """Run a scenario in every variant, several at a time."""
    from lola_drake.simulation import simulate

    chosen = [in_variant(scenario, variant) for variant in variants]
    return Parallel(n_jobs=jobs)(delayed(simulate)(scenario) for scenario in chosen)


def comparison(results: Sequence[Result]) -> dict[str, object]:
    """Return the content of compare.json: every variant, and the second one against the first."""
    summaries = {result.scenario.variant: result.summary for result in results}
    first, second, *_ = summaries.values()
    return {
        "scenario": results[0].scenario.name,
        "variants": summaries,
        "change_percent": change_percent(first, second),
    }


def change_percent(first: Summary, second: Summary) -> dict[str, object]:
    """Return by how many percent each compared metric of the second run differs from the first's.

    None where one of them has no value, or the first is zero.
    """
    return {metric: _change(first[metric], second[metric]) for metric in COMPARED}


def _change(first: object, second: object) -> object:
    if isinstance(first, Mapping):
        return {axis: _change(first[axis], second[axis]) for axis in first}
    if first is None or second is None or first == 0:
        return None
    return 100.0 * (second - first) / first
