"""The commands of `lola` around one run: simulate, list."""

import json
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import ProgressColumn, Task, TextColumn
from rich.table import Table
from rich.text import Text

from lola_drake.cli.common import (
    Blocks,
    Changes,
    Engine,
    Force,
    Host,
    Json,
    Plant,
    ScenarioName,
    Seed,
    changed,
    drawn,
    errors_in_one_line,
    exit_for,
    progress_bar,
)
from lola_drake.cli.pictures import live_view, write_views
from lola_drake.cli.terminal import show
from lola_drake.paths import list_scenarios

if TYPE_CHECKING:
    from lola_drake.results import Result

app = typer.Typer()


@app.command()
def simulate(
    scenario: ScenarioName,
    changes: Changes = None,
    seed: Seed = None,
    variant: Annotated[str | None, typer.Option(help="ref, dyn or original.")] = None,
    blocks: Blocks = None,
    engine: Engine = "fused",
    plant: Plant = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the run (runs/SCENARIO).")
    ] = None,
    force: Force = False,
    pictures: Annotated[
        bool, typer.Option(help="Write figures, a replay and a report into the folder.")
    ] = True,
    video: Annotated[
        bool, typer.Option("--video", help="Write a film, too; it takes its time.")
    ] = False,
    meshcat: Annotated[
        bool, typer.Option("--meshcat", help="Watch it in a browser, and take part.")
    ] = False,
    diagram: Annotated[
        bool,
        typer.Option("--diagram", help="The same, beginning with values in the block diagram."),
    ] = False,
    host: Host = "localhost",
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress, no table.")] = False,
) -> None:
    """Run a scenario; write its signals, metrics and pictures into a folder."""
    from lola_drake.interruption import interruption
    from lola_drake.results import check_folder
    from lola_drake.scenario import load_scenario
    from lola_drake.simulation import simulate as run

    live = meshcat or diagram
    if host != "localhost" and not live:
        raise typer.BadParameter("--host is where the page of --meshcat or --diagram is")
    with errors_in_one_line():
        options = {"seed": seed, "variant": variant, "plant": plant}
        chosen = load_scenario(scenario, changed(changes, blocks, **options))
        folder = output or Path("runs") / chosen.name
        check_folder(folder, force=force)
        kept = folder.with_name(f"{folder.name}_kept")
        view = live_view(chosen, host, kept, diagram=diagram) if live else None
        with _simulated(chosen.name, chosen.duration, show=not quiet) as advance:
            result = run(chosen, advance, attend=view, engine=engine, folder=folder, force=force)
        if view and view.interfered:
            result = view.signed(result)
            with interruption():
                result.save(folder, force=True)
        if result.error is None:
            with _status("drawing pictures", show=not quiet), drawn(folder):
                write_views(result, folder, pictures=pictures, video=video)
    if as_json:
        print(json.dumps(result.summary, indent=2))
    elif not quiet:
        show(_summary_table(result))
        print(f"written to {folder}")
    exit_for([result], folder)


@app.command("list")
def list_(as_json: Json = False) -> None:
    """List the scenarios, with one line each."""
    scenarios = list_scenarios()
    if as_json:
        print(json.dumps(scenarios, indent=2))
        return
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:{width}}  {description}")


class _RealTimeRate(ProgressColumn):
    """Simulated time over elapsed time."""

    def render(self, task: Task) -> Text:
        """Return the rate since the beginning, such as 2.1x."""
        rate = task.completed / task.elapsed if task.elapsed else 0.0
        return Text(f"{rate:.1f}x real time")


def _simulated(name: str, duration: float, *, show: bool) -> AbstractContextManager:
    """Show how much of a run's duration (s) is simulated."""
    if not show:
        return nullcontext()
    time = TextColumn("{task.completed:.1f} of {task.total:.1f} s")
    return progress_bar(name, duration, time, _RealTimeRate(), thread=False)


def _status(text: str, *, show: bool) -> AbstractContextManager:
    """Show on stderr what takes a moment."""
    return Console(stderr=True).status(Text(text)) if show else nullcontext()


def _summary_table(result: "Result") -> Table:
    """Return the outcome of a run as a table."""
    table = Table(title=f"{result.scenario.name} ({result.scenario.variant})", show_header=False)
    for name, value in result.summary.items():
        if name not in ("scenario", "variant", "versions") and value != {}:
            table.add_row(name, _readable(value))
    return table


def _readable(value: object) -> str:
    """Return a metric as a short text."""
    if isinstance(value, list):
        return "; ".join(map(_readable, value))
    if isinstance(value, dict):
        return ", ".join(f"{key} {_readable(entry)}" for key, entry in value.items())
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
