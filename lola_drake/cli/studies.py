"""The commands of `lola` that run many simulations: compare, reproduce, tune."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from lola_drake.cli.common import (
    COUNT,
    INTERRUPTED,
    Blocks,
    Changes,
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
from lola_drake.cli.terminal import show

if TYPE_CHECKING:
    from lola_drake.studies.study import Study

app = typer.Typer()

Jobs = Annotated[int, typer.Option(min=1, help="Simulations that run at a time.")]
Folder = Annotated[Path | None, typer.Option("--output", "-o", help="Folder of what is written.")]


@app.command()
def compare(
    scenario: ScenarioName,
    variants: Annotated[str, typer.Option(help="Of the controller, the first is the base.")] = (
        "ref,dyn"
    ),
    changes: Changes = None,
    seed: Seed = None,
    blocks: Blocks = None,
    plant: Plant = None,
    output: Folder = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace the comparison in that folder.")
    ] = False,
    jobs: Jobs = 2,
    pictures: Annotated[
        bool, typer.Option(help="Write a report with both robots in one scene, too.")
    ] = True,
    as_json: Json = False,
) -> None:
    """Run a scenario in several variants; write a table, a figure and a report of them."""
    from lola_drake.errors import ResultError
    from lola_drake.interruption import interruption
    from lola_drake.results import check_folder
    from lola_drake.scenario import load_scenario
    from lola_drake.studies.tables import comparison_table
    from lola_drake.studies.variants import (
        COMPARISON_FILES,
        comparison,
        write_comparison,
        write_runs,
    )
    from lola_drake.studies.variants import compare as run

    with errors_in_one_line():
        chosen = load_scenario(scenario, changed(changes, blocks, seed=seed, plant=plant))
        folder = output or Path("runs") / f"compare_{chosen.name}"
        check_folder(folder, force=force, files=COMPARISON_FILES, what="comparison")
        names = [name.strip() for name in variants.split(",")]
        with Console(stderr=True).status(f"{chosen.name}: {variants}"):
            results = run(chosen, names, jobs)
        with interruption():
            write_runs(results, folder, force=force)
        exit_for(results, folder)
        if len(results) < len(names):
            raise ResultError(f"not all variants ran; what was recorded is kept in {folder}")
        with drawn(folder):
            write_comparison(results, folder)
            if pictures:
                from lola_drake.reports.run_report import REPORT, write_report

                write_report(results, folder / REPORT)
    if as_json:
        print(json.dumps(comparison(results), indent=2))
    else:
        show(comparison_table(comparison(results)))
        print(f"written to {folder}")


@app.command()
def reproduce(
    samples: Annotated[
        int, typer.Option(min=0, help="Sampled worlds; 0 for the scenarios as they are.")
    ] = 0,
    plant: Plant = None,
    output: Folder = None,
    jobs: Jobs = 2,
    as_json: Json = False,
) -> None:
    """Repeat all experiments of the paper; one table, paper against simulation.

    A study that was stopped goes on where it was when it is started again.
    """
    from lola_drake.figures.run_figures import save_figure
    from lola_drake.studies.reproduction import EXPERIMENTS, reproduction, run_experiments
    from lola_drake.studies.reproduction_figure import reproduction_figure
    from lola_drake.studies.study import Study, write_json
    from lola_drake.studies.tables import reproduction_table

    folder = output or Path("runs") / "reproduction"
    total = 2 * len(EXPERIMENTS) * max(samples, 1)
    with errors_in_one_line():
        study = Study(folder / "runs.jsonl")
        with _keeping(study), progress_bar("reproduction", total, COUNT) as advance:
            outcomes = run_experiments(study, samples, jobs, advance, plant=plant or "drake")
        with drawn(folder):
            content = reproduction(outcomes)
            write_json(content, folder / "reproduction.json")
            save_figure(reproduction_figure(outcomes), folder, "reproduction")
    if as_json:
        print(json.dumps(content, indent=2))
        return
    show(reproduction_table(content))
    print(f"written to {folder}")


@app.command()
def survival(
    samples: Annotated[int, typer.Option(min=1, help="Sampled worlds at each height.")] = 20,
    output: Folder = None,
    jobs: Jobs = 2,
    as_json: Json = False,
) -> None:
    """Find from which height of an unseen edge or board on each variant falls.

    A study that was stopped goes on where it was when it is started again.
    """
    from lola_drake.figures.run_figures import save_figure
    from lola_drake.studies.study import Study, write_json
    from lola_drake.studies.survival import HEIGHTS, OBSTACLES, VARIANTS
    from lola_drake.studies.survival import survival as study_survival
    from lola_drake.studies.survival_figure import survival_figure
    from lola_drake.studies.tables import survival_table

    folder = output or Path("runs") / "survival"
    total = len(HEIGHTS) * len(OBSTACLES) * len(VARIANTS) * samples
    with errors_in_one_line():
        study = Study(folder / "runs.jsonl")
        with _keeping(study), progress_bar("survival", total, COUNT) as advance:
            content = study_survival(study, samples, jobs, advance)
        with drawn(folder):
            write_json(content, folder / "survival.json")
            save_figure(survival_figure(content), folder, "survival")
    if as_json:
        print(json.dumps(content, indent=2))
        return
    show(survival_table(content))
    print(f"written to {folder}")


@app.command()
def tune(
    samples: Annotated[int, typer.Option(min=1, help="Worlds in which gains are judged.")] = 4,
    budget: Annotated[int, typer.Option(min=1, help="Number of gains that are tried.")] = 30,
    output: Folder = None,
    jobs: Jobs = 2,
    as_json: Json = False,
) -> None:
    """Search for the gains with which the reference controller falls and inclines least.

    A search that was stopped goes on where it was when it is started again.
    """
    from lola_drake.studies.study import Study, write_json
    from lola_drake.studies.tables import tuning_table
    from lola_drake.studies.tuning import record
    from lola_drake.studies.tuning import tune as search

    folder = output or Path("runs") / "tuning"
    with errors_in_one_line():
        study = Study(folder / "runs.jsonl")
        with _keeping(study), progress_bar("trials", budget, COUNT) as advance:
            trials = search(study, samples, budget, jobs, lambda trials: advance(len(trials)))
        with drawn(folder):
            content = record(trials, samples)
            write_json(content, folder / "tuning.json")
    if as_json:
        print(json.dumps(content, indent=2))
        return
    show(tuning_table(content))
    print(f"written to {folder}")


@contextmanager
def _keeping(study: "Study") -> Iterator[None]:
    """Say after Ctrl-C that nothing is lost."""
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"lola: stopped; what is done is kept in {study.file}, start again", err=True)
        raise typer.Exit(INTERRUPTED) from None
