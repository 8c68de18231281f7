"""What the commands of `lola` share."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:
    from lola_drake.results import Result

FAILED = 1
"""Exit code where the simulation itself went wrong."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells give it."""

MOST = 100_000
"""Of worlds, or of what else is counted: more is a slip of the finger."""

MOST_JOBS = 1000
"""Of processes."""

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, and nothing else.")]

ScenarioName = Annotated[str, typer.Argument(help="A name from `lola list`, or a YAML file.")]

Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value; may be repeated."),
]

Engine = Annotated[
    str, typer.Option(help="fused: all laws in one system; diagram: block by block, slower.")
]

Blocks = Annotated[
    list[str] | None,
    typer.Option(
        "--block", metavar="NAME=FILE.py:CLASS", help="A law of your own; may be repeated."
    ),
]

Host = Annotated[
    str,
    typer.Option(
        help="Where the page is: localhost, another address of this machine, or * for all of them. "
        "Whoever has the link, and the browser can reach it, may watch and steer."
    ),
]

Seed = Annotated[int | None, typer.Option(help="Seed of all random numbers.")]

Plant = Annotated[
    str | None,
    typer.Option(help="The engine of robot and ground: drake, or mujoco (extra [bench])."),
]

Force = Annotated[bool, typer.Option("--force", help="Replace what is there already.")]


def changed(
    changes: Sequence[str] | None, blocks: Sequence[str] | None = None, **options: object
) -> list[str]:
    """Return all changes of a scenario: of `--set`, of `--block`, and of options of their own."""
    given = [f"{name}={value}" for name, value in options.items() if value is not None]
    return [*(changes or []), *_own_laws(blocks or []), *given]


def _own_laws(blocks: Sequence[str]) -> list[str]:
    """Return the change of a scenario that `--block` means.

    Files are named from the root on, so that the scenario of a record can be run from anywhere.
    """
    if not blocks:
        return []
    pairs = ((name, str(Path.cwd() / law)) for name, _, law in (t.partition("=") for t in blocks))
    laws = (f"{{name: {json.dumps(name)}, law: {json.dumps(law)}}}" for name, law in pairs)
    return [f"blocks=[{', '.join(laws)}]"]


def fail(message: str) -> None:
    """Say on stderr, in one line, what is wrong."""
    typer.echo(f"lola: {message}", err=True)


@contextmanager
def errors_in_one_line() -> Iterator[None]:
    """Exit with code 2 and one line on stderr where a user's input cannot be used."""
    from lola_drake.errors import LolaError
    from lola_drake.linear.errors import AnalysisError

    try:
        yield
    except (LolaError, AnalysisError) as error:
        fail(str(error))
        raise typer.Exit(2) from None


@contextmanager
def drawn(folder: Path) -> Iterator[None]:
    """Say where the record is, when something goes wrong with what is made of it."""
    from lola_drake.atomic_file import reason
    from lola_drake.errors import LolaError, OutputError

    try:
        yield
    except Exception as error:
        kind = "" if isinstance(error, LolaError) else f"{type(error).__name__}: "
        text = f"{kind}{reason(error)}; what was recorded is kept in {folder}"
        raise OutputError(text) from None


def exit_for(results: "Sequence[Result]", folder: Path) -> None:
    """Exit where a run has not come to its end, and say why if nobody has asked for that."""
    for result in results:
        if result.error is not None:
            scenario = result.scenario
            told = f"{scenario.name} ({scenario.variant}) {result.end}"
            fail(f"{told}; what was recorded is kept in {folder}")
    if any(result.error is not None for result in results):
        raise typer.Exit(FAILED)
    if any(result.interrupted for result in results):
        raise typer.Exit(INTERRUPTED)


COUNT = TextColumn("{task.completed} of {task.total}")
"""How much is done, in a progress bar of things that are counted."""


_REDRAWN = 0.2
"""Least time between two pictures of a progress bar that has no thread of its own (s)."""


@contextmanager
def progress_bar(
    name: str, total: float | None, *columns: ProgressColumn, thread: bool = True
) -> Iterator[Callable[..., None]]:
    """Show a progress bar on stderr; gives the function that takes what is done, and of how much.

    Args:
        name: what is going on.
        total: how much there is to do; None if that is not known yet.
        columns: what to show behind the bar.
        thread: whether the bar's clock goes on by itself. The thread for it slows a simulation in
            the same process by 2 %; without one the bar is drawn when something is done.
    """
    # A name may have brackets in it, of any kind.
    title = TextColumn("{task.description}", markup=False)
    columns = title, BarColumn(), *columns, TimeElapsedColumn()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, auto_refresh=thread) as progress:
        task, drawn = progress.add_task(name, total=total), 0.0

        def advance(done: float, of: float | None = total) -> None:
            nonlocal drawn
            now = monotonic()
            due = not thread and now - drawn >= _REDRAWN
            if due:
                drawn = now
            progress.update(task, completed=done, total=of, refresh=due)

        yield advance
