"""What the commands of `lola` share."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells give it."""

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, and nothing else.")]

ScenarioName = Annotated[str, typer.Argument(help="A name from `lola list`, or a YAML file.")]

Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value; may be repeated."),
]

Host = Annotated[
    str, typer.Option(help="Where a browser may be; * lets everybody in who reaches this machine.")
]


@contextmanager
def errors_in_one_line() -> Iterator[None]:
    """Exit with code 2 and one line on stderr where a user's input cannot be used."""
    from lola_drake.analysis.linear.errors import AnalysisError
    from lola_drake.analysis.picture_file import PictureError
    from lola_drake.results import ResultError
    from lola_drake.scenario import ScenarioError

    try:
        yield
    except (ScenarioError, ResultError, PictureError, AnalysisError) as error:
        typer.echo(f"lola: {error}", err=True)
        raise typer.Exit(2) from None


COUNT = TextColumn("{task.completed} of {task.total}")
"""How much is done, in a progress bar of things that are counted."""


@contextmanager
def progress_bar(
    name: str, total: float | None, *columns: ProgressColumn
) -> Iterator[Callable[..., None]]:
    """Show a progress bar on stderr; gives the function that takes what is done, and of how much.

    Args:
        name: what is going on.
        total: how much there is to do; None if that is not known yet.
        columns: what to show behind the bar.
    """
    columns = TextColumn(name), BarColumn(), *columns, TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(name, total=total)
        yield lambda done, of=total: progress.update(task, completed=done, total=of)
