"""Everything there is to see of a run, into its folder; and reports about runs."""

from collections.abc import Sequence
from pathlib import Path

from lola_drake.atomic_file import whole_file
from lola_drake.errors import OutputError
from lola_drake.figures.run_figures import draw_figures, figure_bytes
from lola_drake.reports.report_page import report_page
from lola_drake.results import Result
from lola_drake.view3d.replay import loading_page, packed_replay

FIGURES, REPLAY, REPORT = "figures", "replay.html", "report.html"

LEAST_SAMPLES = 2
"""Of a run that can be drawn."""


def check_drawable(results: Sequence[Result]) -> None:
    """Refuse runs that ended before there was anything to draw."""
    for result in results:
        if len(result.times) < LEAST_SAMPLES:
            raise OutputError(f"{result.scenario.name}: too short for pictures, {result.end}")


def write_pictures(result: Result, folder: str | Path) -> None:
    """Write a run's figures, replay and report into its folder."""
    check_drawable([result])
    folder, replay = Path(folder), packed_replay(result)
    for name, figure in draw_figures(result).items():
        for kind in ("svg", "png"):
            with whole_file(folder / FIGURES / f"{name}.{kind}") as file:
                file.write_bytes(figure_bytes(figure, kind))
    title = f"{result.scenario.name} ({result.scenario.variant})"
    _write(folder / REPLAY, loading_page(title, replay))
    _write(folder / REPORT, report_page([result], replay))


def write_report(results: Sequence[Result], path: str | Path, *, names: Sequence[str] = ()) -> Path:
    """Write one page about some runs; the first is what the others are compared with.

    Args:
        results: The runs.
        path: Of the page, ends in .html.
        names: What the runs are called, one each; unless given, what tells them apart.

    Raises:
        OutputError: If there is no run, or nothing in one, or a name is missing or there twice, or
            the page cannot be written.
    """
    if not results:
        raise OutputError("a report needs at least one run")
    if names and not len(results) == len(names) == len(set(names)):
        raise OutputError(f"names: {list(names)!r} is not one name for each of {len(results)} runs")
    check_drawable(results)
    _write(Path(path), report_page(results, packed_replay(*results), names))
    return Path(path)


def _write(path: Path, text: str) -> None:
    with whole_file(path) as file:
        file.write_text(text, encoding="utf-8")
