"""The commands `lola study …`: look into the file of a study."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from rich.table import Table

from lola_drake.cli.common import Force, Json, errors_in_one_line
from lola_drake.cli.terminal import show

app = typer.Typer(help="Look into the file of a study, also while it runs.", no_args_is_help=True)

StudyFile = Annotated[Path, typer.Argument(help="The file of a study, or its folder.")]


def _store(path: Path):
    from lola_drake.studies.store import Store
    from lola_drake.studies.study import FILE

    return Store(path / FILE if path.is_dir() else path, must_exist=True)


@app.command()
def status(study: StudyFile, as_json: Json = False) -> None:
    """Tell how much of a study is done, how the runs ended, and how many come in an hour."""
    from lola_drake.studies.status import status as found

    with errors_in_one_line():
        content = found(_store(study))
    if as_json:
        print(json.dumps(content, indent=2))
        return
    for line in _status_lines(content):
        print(line)


def _status_lines(content: dict) -> list[str]:
    ends = ", ".join(f"{count} {name}" for name, count in content["outcomes"].items() if count)
    lines = [f"{content['runs']} runs{': ' + ends if ends else ''}"]
    last = content["last_order"]
    if last:
        lines.append(f"last started {last['began']}: {last['done']} of {last['wanted']} done")
    if content["runs_per_hour"]:
        lines.append(f"{content['runs_per_hour']:.0f} runs an hour since then")
    return lines


@app.command("show")
def show_(
    study: StudyFile,
    rows: Annotated[int, typer.Option(min=1, max=10**9, help="So many runs, the last ones.")] = 20,
    outcome: Annotated[
        str | None, typer.Option(help="Only those that completed, fell, failed, or were lost.")
    ] = None,
    worst: Annotated[
        bool,
        typer.Option("--worst", help="The worst ones: failures, early falls, great inclinations."),
    ] = False,
    as_json: Json = False,
) -> None:
    """Show the last runs of a study, or the worst: what was run, where, and how it ended."""
    from lola_drake.studies.status import listed_runs

    with errors_in_one_line():
        found = listed_runs(_store(study), rows, outcome, worst=worst)
    if as_json:
        print(json.dumps(found, indent=2))
        return
    table = Table("run", "scenario", "variant", "seed", "end", "inclination")
    for run in found:
        told = (run["run"], run["scenario"], run["variant"], run["seed"], _end(run), _inclined(run))
        table.add_row(*map(str, told))
    show(table)
    if found:
        print(f"again, with signals and pictures: {found[0]['command']}")


def _end(run: dict) -> str:
    """Return how a run ended, in a few words."""
    if run["error"]:
        return f"{run['outcome']}: {run['error']}"
    if run["fall_time_s"] is None:
        return run["outcome"]
    first = f", first: {run['fall_events'][0]['event']}" if run["fall_events"] else ""
    return f"fell at {run['fall_time_s']:.2f} s{first}"


def _inclined(run: dict) -> str:
    """Return the largest inclination about x and y."""
    found = (run["max_inclination_deg"] or {}).values()
    return ", ".join("-" if value is None else f"{value:.1f}°" for value in found)


@app.command()
def export(
    study: StudyFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="FILE.csv or FILE.parquet.")],
    force: Force = False,
) -> None:
    """Write all runs of a study as one table: CSV, or Parquet."""
    from lola_drake.atomic_file import check_file
    from lola_drake.studies.export import export as write

    with errors_in_one_line():
        store = _store(study)
        count = write(store, check_file(output, force=force))
    print(f"{count} runs written to {output}")


@app.command()
def replay(
    study: StudyFile,
    run: Annotated[int, typer.Argument(help="Number of a run, see `lola study show`.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the run (runs/SCENARIO_RUN).")
    ] = None,
    force: Force = False,
) -> None:
    """Simulate a run of a study once more, with its signals and pictures."""
    from lola_drake.cli.simulate import simulate
    from lola_drake.scenario import dump_scenario

    with errors_in_one_line(), TemporaryDirectory() as folder:
        scenario = _store(study).row(run).scenario()
        file = Path(folder) / f"{scenario.name}_{run}.yaml"
        file.write_text(dump_scenario(scenario), encoding="utf-8")
        simulate(str(file), output=output or Path("runs") / file.stem, force=force)
