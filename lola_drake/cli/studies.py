"""The commands of `lola` that run many simulations: compare, reproduce, survival, tune."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from lola_drake.cli.common import (
    MOST,
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
)
from lola_drake.cli.studying import Cluster, Folder, Jobs, Until, conclude, studying
from lola_drake.cli.terminal import show

app = typer.Typer()


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
    from lola_drake.results import check_folder
    from lola_drake.scenario import load_scenario
    from lola_drake.studies.tables import comparison_table
    from lola_drake.studies.variants import (
        COMPARISON_FILES,
        comparison,
        write_comparison,
    )
    from lola_drake.studies.variants import compare as run

    with errors_in_one_line():
        chosen = load_scenario(scenario, changed(changes, blocks, seed=seed, plant=plant))
        folder = output or Path("runs") / f"compare_{chosen.name}"
        check_folder(folder, force=force, files=COMPARISON_FILES, what="comparison")
        names = [name.strip() for name in variants.split(",")]
        with Console(stderr=True).status(Text(f"{chosen.name}: {variants}")):
            results = run(chosen, names, jobs, folder, force=force)
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
        int, typer.Option(min=0, max=MOST, help="Sampled worlds; 0 for the scenarios as they are.")
    ] = 0,
    plant: Plant = None,
    extended: Annotated[
        bool, typer.Option("--extended", help="Draw all that worlds.extended means.")
    ] = False,
    until: Until = None,
    output: Folder = None,
    jobs: Jobs = 2,
    cluster: Cluster = None,
    as_json: Json = False,
) -> None:
    """Repeat all experiments of the paper; one table, paper against simulation.

    A study that was stopped goes on where it was when it is started again.
    """
    from lola_drake.studies.reproduction import EXPERIMENTS, reproduction, run_experiments
    from lola_drake.studies.reproduction_figure import reproduction_figure
    from lola_drake.studies.tables import reproduction_table

    folder = output or Path("runs") / "reproduction"
    experiments = [e.changed({"worlds.extended": extended}) if extended else e for e in EXPERIMENTS]
    total = 2 * len(EXPERIMENTS) * max(samples, 1)
    with studying(folder, jobs, cluster, "reproduction", total) as (study, advance):
        outcomes = run_experiments(
            study, samples, advance, experiments, plant=plant or "drake", width=until
        )
    conclude(
        folder,
        "reproduction",
        lambda: reproduction(outcomes),
        reproduction_table,
        lambda _: reproduction_figure(outcomes),
        as_json=as_json,
    )


@app.command()
def survival(
    samples: Annotated[
        int, typer.Option(min=1, max=MOST, help="Sampled worlds at each height.")
    ] = 20,
    until: Until = None,
    output: Folder = None,
    jobs: Jobs = 2,
    cluster: Cluster = None,
    as_json: Json = False,
) -> None:
    """Find from which height of an unseen edge or board on each variant falls.

    A study that was stopped goes on where it was when it is started again.
    """
    from lola_drake.studies.survival import HEIGHTS, OBSTACLES, VARIANTS
    from lola_drake.studies.survival import survival as found
    from lola_drake.studies.survival_figure import survival_figure
    from lola_drake.studies.tables import survival_table

    folder = output or Path("runs") / "survival"
    total = len(HEIGHTS) * len(OBSTACLES) * len(VARIANTS) * samples
    with studying(folder, jobs, cluster, "survival", total) as (study, advance):
        content = found(study, samples, advance, width=until)
    conclude(folder, "survival", lambda: content, survival_table, survival_figure, as_json=as_json)


@app.command()
def tune(
    samples: Annotated[
        int, typer.Option(min=1, max=MOST, help="Worlds in which gains are judged.")
    ] = 4,
    budget: Annotated[
        int, typer.Option(min=1, max=MOST, help="Number of gains that are tried.")
    ] = 30,
    law: Annotated[str, typer.Option(help="Tune this force law's own gains instead.")] = "",
    output: Folder = None,
    jobs: Jobs = 2,
    cluster: Cluster = None,
    as_json: Json = False,
) -> None:
    """Search for the gains with which the reference controller falls and inclines least.

    With `--law` it has that force law, and the law's own gains are what is tuned.
    A search that was stopped goes on where it was when it is started again.
    """
    from lola_drake.studies.tables import tuning_table
    from lola_drake.studies.tuning import GAINS, law_gains, record
    from lola_drake.studies.tuning import tune as search

    folder = output or Path("runs") / (f"tuning_{law}" if law else "tuning")
    with errors_in_one_line():
        what = (law_gains(law), law) if law else (GAINS, "hybrid")
    with studying(folder, jobs, cluster, "trials", budget) as (study, advance):
        found = search(study, samples, budget, advance, *what)
    conclude(folder, "tuning", lambda: record(found, samples, *what), tuning_table, as_json=as_json)
