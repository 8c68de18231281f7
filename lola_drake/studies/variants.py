"""One scenario in several variants, side by side."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lola_drake.atomic_file import growing_folder, write_json
from lola_drake.errors import ResultError
from lola_drake.figures.run_figures import save_figure
from lola_drake.figures.variants_figure import variants_figure
from lola_drake.record import RecordedSignals
from lola_drake.results import Result
from lola_drake.scenario import Scenario, ScenarioError, as_scenario, override
from lola_drake.studies.row import Summary, survived
from lola_drake.workers import Processes, inline

COMPARISON = "compare.json"
COMPARISON_FILES = frozenset({COMPARISON})

COMPARED = {
    "max_inclination_deg": ("x", "y"),
    "rms_torque_error_Nm": ("x", "y"),
    "settling_time_s": (),
    "max_com_vertical_acceleration_m_per_s2": (),
    "max_foot_force_N": (),
    "max_slip_m": (),
}
"""The metrics of which changes are stated, with their axes; from all of them, less is better."""


def compare(
    scenario: Scenario | str | Path,
    variants: Sequence[str] = ("ref", "dyn"),
    jobs: int = 2,
    folder: str | Path | None = None,
    *,
    force: bool = False,
) -> list[Result]:
    """Return the runs of a scenario in every variant; several run at a time.

    Ctrl-C ends all of them; what was recorded is returned, as `simulate` does.

    Args:
        scenario: What to run: a scenario, its name, or the path of its file.
        variants: Of the controller, at least two; the first is what the others are compared with.
        jobs: Number of processes.
        folder: Where to save the runs while they go on, with all summaries in compare.json. Until
            the end of all it is called FOLDER.part.
        force: Replace the comparison that the folder holds.

    Raises:
        ScenarioError: If there are not at least two variants, or there is no such one.
        ResultError: If the folder cannot be used or written, or the processes of all runs were
            killed.
    """
    if len(set(variants)) < max(2, len(variants)):
        raise ScenarioError(f"variants {', '.join(variants)}: at least two, all different")
    base = as_scenario(scenario)
    chosen = [override(base, {"variant": variant}) for variant in variants]
    if folder is None:
        return _runs(chosen, jobs, None)
    with growing_folder(folder, force=force, files=COMPARISON_FILES, what="comparison") as part:
        results = _runs(chosen, jobs, part)
    for result in results:
        if isinstance(result.signals, RecordedSignals):
            result.signals.move(Path(folder).resolve() / result.scenario.variant)
    return results


def _runs(scenarios: Sequence[Scenario], jobs: int, folder: Path | None) -> list[Result]:
    workers = Processes(jobs) if jobs > 1 else inline
    results: dict[int, Result] = {}
    orders = [(s, folder and folder / s.variant) for s in scenarios]
    try:
        for done in workers(_simulated, orders):
            if isinstance(done.answer, Result):
                results[done.index] = done.answer
                if folder:
                    write_json({"variants": _summaries(results.values())}, folder / COMPARISON)
    except KeyboardInterrupt:
        if not results:
            raise
    else:
        if not results:
            raise ResultError(f"{scenarios[0].name}: all processes were killed")
    return [results[i] for i in sorted(results)]


def _simulated(order: tuple[Scenario, Path | None]) -> Result:
    from lola_drake.simulation import simulate

    scenario, folder = order
    return simulate(scenario, folder=folder)


def _summaries(results: Iterable[Result]) -> dict[str, Summary]:
    return {result.scenario.variant: result.summary for result in results}


def comparison(results: Sequence[Result]) -> dict[str, object]:
    """Return the content of compare.json: every variant, and the second one against the first."""
    first, second, *_ = summaries = [result.summary for result in results]
    return {
        "scenario": first["scenario"],
        "variants": {summary["variant"]: summary for summary in summaries},
        "change_percent": change_percent(first, second),
    }


def change_percent(first: Summary, second: Summary) -> dict[str, Any]:
    """Return by how many percent each compared metric of the second run differs from the first's.

    None where there is nothing to compare: one of them has no value, the first is zero, or one of
    the runs ended in a fall or an error, so that they tell of different times.
    """
    if not (survived(first) and survived(second)):
        return {metric: dict.fromkeys(axes) if axes else None for metric, axes in COMPARED.items()}
    return {metric: _change(first[metric], second[metric]) for metric in COMPARED}


def _change(first: Any, second: Any) -> Any:
    if isinstance(first, Mapping):
        return {axis: _change(first[axis], second[axis]) for axis in first}
    if first is None or second is None or first == 0:
        return None
    return 100.0 * (second - first) / first


def write_comparison(results: Sequence[Result], folder: str | Path) -> None:
    """Write what is made of at least two runs, compare.json and the figure, to them."""
    write_json(comparison(results), Path(folder) / COMPARISON)
    save_figure(variants_figure(results), Path(folder), "comparison")
