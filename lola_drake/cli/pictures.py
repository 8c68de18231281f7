"""The commands of `lola` that show something: diagrams, reports, films, the live robot, exports."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lola_drake.cli.common import (
    Blocks,
    Changes,
    Force,
    Host,
    ScenarioName,
    changed,
    errors_in_one_line,
    fail,
)

if TYPE_CHECKING:
    from lola_drake.results import Result
    from lola_drake.scenario import Scenario
    from lola_drake.view3d.live import LiveView

app = typer.Typer()


def live_view(
    scenario: "Scenario", host: str, folder: Path, *, diagram: bool = False
) -> "LiveView":
    """Return what shows a simulation in a browser, and say where.

    Args:
        scenario: what will be run.
        host: where the page may be.
        folder: in which the last seconds are kept when the user asks for that.
        diagram: whether the page begins with the block diagram.
    """
    from lola_drake.errors import OutputError
    from lola_drake.view3d.diagram_view import live_diagram
    from lola_drake.view3d.door import Door
    from lola_drake.view3d.live import LiveView
    from lola_drake.view3d.live_page import LivePage
    from lola_drake.view3d.scene import open_meshcat

    if scenario.plant != "drake":
        raise OutputError(
            f"plant: {scenario.plant!r} cannot be watched while it runs, only 'drake'"
        )
    meshcat = open_meshcat(hidden=True)
    page = LivePage(host, scenario.name, Door(host, meshcat.web_url()), live_diagram(scenario))
    typer.echo(f"waiting for a browser at {page.url}{'#diagram' if diagram else ''}", err=True)
    return LiveView(scenario, meshcat, page, lambda result: _keep(result, folder))


def _keep(result: "Result", folder: Path) -> str:
    """Write the last seconds of a run into a folder of their own; return where, or why not."""
    from lola_drake.errors import LolaError

    taken = (int(path.name) for path in folder.glob("*") if path.name.isdecimal())
    place = folder / str(1 + max(taken, default=0))
    try:
        result.save(place)
        write_views(result, place, pictures=True, video=False)
    except (LolaError, OSError) as error:
        return f"not kept: {error}"
    return f"kept in {place}"


def write_views(result: "Result", folder: Path, *, pictures: bool, video: bool) -> None:
    """Write what a run's user wants to see into its folder."""
    if pictures:
        from lola_drake.reports.run_report import write_pictures

        write_pictures(result, folder)
    if video:
        from lola_drake.view3d.video import save_video

        save_video(result, folder / "video.webp")


@app.command()
def diagram(
    scenario: ScenarioName = "walk_flat",
    changes: Changes = None,
    blocks: Blocks = None,
    depth: Annotated[
        int, typer.Option(min=0, help="Levels to open; 0 shows one block with all its signals.")
    ] = 1,
    system: Annotated[
        str | None, typer.Option(help="Only this system, by its name in the diagram.")
    ] = None,
    logging: Annotated[bool, typer.Option("--logging", help="Show the logs, too.")] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File ending in .svg, .png, .pdf or .dot."),
    ] = None,
    all_: Annotated[
        bool, typer.Option("--all", help="Write every picture, with an index, into a folder.")
    ] = False,
    force: Force = False,
) -> None:
    """Draw the block diagram of a simulation, or of one system in it."""
    from lola_drake.atomic_file import check_file
    from lola_drake.diagram.block_diagram import (
        block_diagram,
        save_diagram,
        write_all,
    )
    from lola_drake.diagram.paper import advice
    from lola_drake.scenario import load_scenario
    from lola_drake.world import build_simulation

    others = (scenario, depth) != ("walk_flat", 1) or any((changes, blocks, system, logging))
    if all_ and others:
        raise typer.BadParameter("--all draws every picture of walk_flat as it is, without others")
    with errors_in_one_line():
        if all_:
            folder = output or Path("diagrams")
            check_file(folder / "README.md", force=force)
            written = write_all(folder)
        else:
            path = check_file(output or Path(f"{system or 'simulation'}.svg"), force=force)
            simulation = build_simulation(load_scenario(scenario, changed(changes, blocks)))
            options: dict[str, Any] = {"system": system, "depth": depth, "logging": logging}
            written = [save_diagram(simulation, path, **options)]
            if path.suffix == ".svg" and (told := advice(block_diagram(simulation, **options))):
                fail(f"{path}: {told}")
    for path in written:
        print(path)


@app.command()
def report(
    runs: Annotated[list[Path], typer.Argument(help="Folders of runs; the first is the base.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="File ending in .html.")] = Path(
        "report.html"
    ),
    video: Annotated[
        Path | None, typer.Option(help="Also a film of the first run, .webp or .mp4.")
    ] = None,
    force: Force = False,
) -> None:
    """Write one page about some runs: metrics, one replay with ghosts, curves, settings."""
    from lola_drake.atomic_file import check_file
    from lola_drake.reports.run_report import write_report
    from lola_drake.results import load_result
    from lola_drake.view3d.video import save_video

    with errors_in_one_line():
        for path in (output, video) if video else (output,):
            check_file(path, force=force)
        results = [load_result(run) for run in runs]
        names = [run.resolve().name for run in runs]
        several = len(set(names)) == len(names) > 1
        print(write_report(results, output, names=names if several else ()))
        if video is not None:
            print(save_video(results[0], video))


@app.command()
def walk(
    scenario: Annotated[
        str, typer.Argument(help="Where to walk: a scenario without steps of its own.")
    ] = "stand",
    changes: Changes = None,
    host: Host = "localhost",
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for what you keep on the way.")
    ] = Path("runs/walk"),
) -> None:
    """Steer the robot in a browser: by sliders, keys or gamepad; the last 20 s can be kept."""
    from lola_drake.scenario import load_scenario
    from lola_drake.view3d.live import walk_live

    with errors_in_one_line():
        chosen = load_scenario(scenario, changes or [])
        walk_live(chosen, live_view(chosen, host, output))


@app.command()
def export(
    run: Annotated[Path, typer.Argument(help="Folder of a run.")],
    mcap: Annotated[
        bool, typer.Option("--mcap", help="As MCAP, for Foxglove and PlotJuggler.")
    ] = False,
    rate: Annotated[float, typer.Option(min=1, max=1000, help="Messages per second.")] = 1000.0,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File (RUN/signals.mcap).")
    ] = None,
    force: Force = False,
) -> None:
    """Write the signals of a run in the format of another tool."""
    from lola_drake.atomic_file import check_file
    from lola_drake.mcap_export import export_mcap
    from lola_drake.results import load_result

    if not mcap:
        raise typer.BadParameter("say in which format, there is --mcap")
    with errors_in_one_line():
        result = load_result(run)
        path = check_file(output or run / "signals.mcap", force=force)
        print(export_mcap(result, path, rate=rate))
