"""What the commands share that run many simulations: who runs them, and what becomes of them."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lola_drake.cli.common import (
    COUNT,
    INTERRUPTED,
    MOST_JOBS,
    drawn,
    errors_in_one_line,
    fail,
    progress_bar,
)
from lola_drake.cli.terminal import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

    from lola_drake.studies.study import Study

Jobs = Annotated[int, typer.Option(min=1, max=MOST_JOBS, help="Simulations that run at a time.")]
Cluster = Annotated[
    str | None,
    typer.Option(
        metavar="local|tcp://HOST:8786", help="Run on a Dask cluster (the extra [cluster])."
    ),
]


def _width(text: str) -> float:
    """Return the width of an interval (percentage points); say what is wrong with the option."""
    from lola_drake.errors import LolaError
    from lola_drake.studies.stopping import parse_width

    try:
        return parse_width(text)
    except LolaError as error:
        raise typer.BadParameter(str(error)) from None


Until = Annotated[
    float | None,
    typer.Option(
        metavar="WIDTH%",
        parser=_width,
        help="Fewer worlds, once all 95 % intervals of what is counted are so narrow (such as 5%).",
    ),
]
Folder = Annotated[Path | None, typer.Option("--output", "-o", help="Folder of what is written.")]


@contextmanager
def studying(
    folder: Path, jobs: int, cluster: str | None, what: str, total: int
) -> "Iterator[tuple[Study, Callable[[int], None]]]":
    """Give the study of a folder, and the function that is told how much of it is done.

    What cannot be used is said in one line; after Ctrl-C, that nothing is lost.

    Args:
        folder: holds the study's file.
        jobs: how many processes.
        cluster: a Dask cluster in their place.
        what: is counted.
        total: how much there is to do.
    """
    from lola_drake import workers
    from lola_drake.studies import cluster as on_cluster
    from lola_drake.studies.study import FILE, Study

    with errors_in_one_line():
        crew = on_cluster.Cluster(cluster, jobs) if cluster else workers.Processes(jobs)
        study = Study(folder / FILE, crew)
        try:
            with progress_bar(what, total, COUNT) as advance:
                yield study, advance
        except KeyboardInterrupt:
            fail(f"stopped; what is done is kept in {study.store.file}, start again")
            raise typer.Exit(INTERRUPTED) from None
    if study.failures:
        fail(f"{study.failures} runs failed: lola study show {study.store.file} --outcome failed")


def conclude(
    folder: Path,
    name: str,
    content: Callable[[], dict],
    table: "Callable[[dict], Table]",
    figure: "Callable[[dict], Figure | None] | None" = None,
    *,
    as_json: bool,
) -> None:
    """Write what a study has found into its folder, and print it.

    Args:
        folder: of the study.
        name: of what is written, NAME.json and the figure.
        content: makes what is found.
        table: shows it.
        figure: draws it, if there is anything to draw.
        as_json: whether to print it as JSON.
    """
    from lola_drake.atomic_file import write_json
    from lola_drake.figures.run_figures import save_figure

    with errors_in_one_line(), drawn(folder):
        found = content()
        write_json(found, folder / f"{name}.json")
        drawing = figure and figure(found)
        if drawing:
            save_figure(drawing, folder, name)
    if as_json:
        print(json.dumps(found, indent=2))
        return
    show(table(found))
    print(f"written to {folder}")
