"""The command `lola sweep`: a scenario over some of its keys, in many worlds."""

from pathlib import Path
from typing import Annotated

import typer

from lola_drake.cli.common import (
    MOST,
    Blocks,
    Changes,
    Json,
    ScenarioName,
    changed,
    errors_in_one_line,
)
from lola_drake.cli.studying import Cluster, Folder, Jobs, Until, conclude, studying

app = typer.Typer()


@app.command()
def sweep(
    scenario: ScenarioName,
    vary: Annotated[
        list[str],
        typer.Option("--vary", metavar="KEY=FROM:TO:N", help="Or KEY=a,b,c; may be repeated."),
    ],
    worlds: Annotated[
        int, typer.Option(min=0, max=MOST, help="Sampled worlds; 0 for the scenario as it is.")
    ] = 0,
    variants: Annotated[str, typer.Option(help="Of the controller, the first is the base.")] = (
        "ref,dyn"
    ),
    design: Annotated[
        str, typer.Option(help="Of several keys: grid, latin (hypercube) or sobol.")
    ] = "grid",
    points: Annotated[int | None, typer.Option(help="Of a latin or sobol design.")] = None,
    metric: Annotated[
        str, typer.Option(help="What is looked at, by its name in summary.json.")
    ] = "max_inclination_deg.y",
    until: Until = None,
    changes: Changes = None,
    blocks: Blocks = None,
    output: Folder = None,
    jobs: Jobs = 2,
    cluster: Cluster = None,
    as_json: Json = False,
) -> None:
    """Run a scenario over some of its keys: who stays up, and how well, in a table and a figure.

    A sweep that was stopped goes on where it was when it is started again.
    """
    from lola_drake.scenario import load_scenario
    from lola_drake.studies.designs import points as chosen
    from lola_drake.studies.factors import parse_factors
    from lola_drake.studies.sweep import Sweep, run_sweep
    from lola_drake.studies.sweep_figure import sweep_figure
    from lola_drake.studies.sweep_table import sweep_table

    with errors_in_one_line():
        base = load_scenario(scenario, changed(changes, blocks))
        factors = parse_factors(vary, base)
        names = tuple(name.strip() for name in variants.split(","))
        at = chosen(factors, design, points, max(worlds, 1) * len(names))
        wanted = Sweep(base, factors, at, names, metric, design)
        wanted.check(worlds)
    folder = output or Path("runs") / f"sweep_{base.name}"
    total = wanted.runs_per_world * max(worlds, 1)
    with studying(folder, jobs, cluster, "sweep", total) as (study, advance):
        content = run_sweep(study, wanted, worlds, until, advance)
    conclude(folder, "sweep", lambda: content, sweep_table, sweep_figure, as_json=as_json)
