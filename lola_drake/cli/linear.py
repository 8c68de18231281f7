"""The commands of `lola` for linear analysis: models, stability maps, the gait's own stability."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lola_drake.cli.common import (
    COUNT,
    MOST_JOBS,
    Blocks,
    Changes,
    Force,
    Json,
    ScenarioName,
    changed,
    errors_in_one_line,
    progress_bar,
)

if TYPE_CHECKING:
    from lola_drake.linear.studies.analyses import Analysis

app = typer.Typer()

Scenario = Annotated[
    str, typer.Option("--scenario", "-s", help="Whose parameters; a name from `lola list`.")
]
At = Annotated[
    str | None,
    typer.Option(help="stand, left, right, t=3.2, or a pose such as 'load=0.7 stride=0.2'."),
]
Jobs = Annotated[int, typer.Option(min=1, max=MOST_JOBS, help="Number of processes.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder of the pictures.")]


@app.command()
def linearize(
    name: Annotated[
        str,
        typer.Argument(help="contact, servo, force_loop, com_dynamics, stabilizer or full."),
    ],
    scenario: Scenario = "stand",
    at: At = None,
    changes: Changes = None,
    blocks: Blocks = None,
    locus: Annotated[bool, typer.Option(help="Draw a root locus, too.")] = True,
    measured: Annotated[
        bool, typer.Option("--measured", help="Measure the responses in the simulation, too.")
    ] = False,
    output: Output = Path("runs/linear"),
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Linearise a part of the loop: poles, margins, Bode, root locus."""
    from lola_drake.linear.presentation.analysis_figures import analysis_figure
    from lola_drake.linear.presentation.report import as_numbers, report
    from lola_drake.linear.studies.analyses import analyse
    from lola_drake.scenario import load_scenario

    with errors_in_one_line():
        more = [f"{name}_measured", f"{name}_steps"] if measured else []
        _check([name, *more], output, force)
        analysis = analyse(name, load_scenario(scenario, changed(changes, blocks)), at, locus=locus)
        numbers = as_numbers(analysis)
        text, figures = report(analysis), {name: analysis_figure(analysis)}
        if measured:
            table, figures[f"{name}_measured"] = _measure(analysis)
            figures[f"{name}_steps"] = _measure_steps(analysis)
            text, numbers["measured"] = f"{text}\n\n{table.as_text()}", table.rows
        paths = _save(figures, output)
    if as_json:
        print(json.dumps(numbers, indent=2))
    else:
        print(text, *paths, sep="\n")


@app.command("map")
def map_(
    name: Annotated[str, typer.Argument(help="gains, stiffness, latency or torso.")],
    scenario: Scenario = "stand",
    at: At = None,
    changes: Changes = None,
    torso: Annotated[
        float, typer.Option(min=0, max=500, help="Frequency of a flexible torso (Hz); 0: rigid.")
    ] = 0.0,
    torso_damping: Annotated[float, typer.Option(min=0, max=10, help="Its damping ratio.")] = 0.05,
    torso_share: Annotated[
        float, typer.Option(min=-10, max=10, help="Part of it that the IMU sees.")
    ] = 1.0,
    check: Annotated[
        bool, typer.Option("--check", help="Find the border by simulation, too.")
    ] = False,
    jobs: Jobs = 2,
    output: Output = Path("runs/linear"),
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Map the stability of the closed loop over two parameters."""
    from lola_drake.linear.presentation.study_figures import map_figure
    from lola_drake.linear.studies.flexible_torso import FlexibleTorso
    from lola_drake.linear.studies.map_kinds import map_kind
    from lola_drake.linear.studies.stability_border import compare_borders
    from lola_drake.linear.studies.stability_map import stability_map
    from lola_drake.scenario import load_scenario

    asked = FlexibleTorso(damping=torso_damping, share=torso_share)
    if not torso and asked != FlexibleTorso():
        raise typer.BadParameter("--torso-damping and --torso-share are those of a --torso HZ")
    mode = replace(asked, frequency=torso) if torso else None
    with errors_in_one_line():
        kind, chosen = map_kind(name), load_scenario(scenario, changes or [])
        file = f"map_{name}_flexible" if mode and name != "torso" else f"map_{name}"
        _check([file], output, force)
        with progress_bar(name, None, COUNT) as advance:
            result = stability_map(kind, chosen, at, mode, jobs, advance)
        borders = compare_borders(chosen, result.at) if check else None
        paths = _save({file: map_figure(result)}, output)
    if as_json:
        print(json.dumps(result.as_numbers() | {"borders": borders}, indent=2))
        return
    print(result.as_text())
    if borders:
        print(
            f"smallest stable delta at {result.at}: {1e3 * borders['predicted_s']:.2f} ms "
            f"predicted, {1e3 * borders['simulated_s']:.2f} ms in the simulation"
        )
    print(*paths, sep="\n")


@app.command()
def poincare(
    scenario: ScenarioName = "walk_flat",
    variants: Annotated[
        list[str] | None, typer.Option("--variant", help="ref or dyn; may be repeated.")
    ] = None,
    changes: Changes = None,
    jobs: Jobs = 2,
    output: Output = Path("runs/linear"),
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Find the Floquet multipliers of a gait, from stride to stride."""
    from lola_drake.linear.presentation.study_figures import multipliers_figure
    from lola_drake.linear.studies.poincare import stride_map
    from lola_drake.scenario import load_scenario

    maps = {}
    with errors_in_one_line():
        file = f"poincare_{load_scenario(scenario, changes or []).name}"
        _check([file], output, force)
        for variant in variants or ["ref", "dyn"]:
            chosen = load_scenario(scenario, [*(changes or []), f"variant={variant}"])
            with progress_bar(f"{scenario} {variant}", None, COUNT) as advance:
                maps[variant] = stride_map(chosen, jobs, advance)
        paths = _save({file: multipliers_figure(maps)}, output)
    if as_json:
        print(json.dumps({name: stride.as_numbers() for name, stride in maps.items()}, indent=2))
        return
    for variant, stride in maps.items():
        print(f"{scenario} ({variant})", stride.as_text(), sep="\n", end="\n\n")
    print(*paths, sep="\n")


def _measure(analysis: "Analysis"):
    from lola_drake.linear.presentation.study_figures import measured_figure
    from lola_drake.linear.studies.measured_response import compare

    models, measured, table = compare(analysis)
    title = f"{analysis.name}: linear model (line) and nonlinear simulation (dots)"
    return table, measured_figure(title, models, measured)


def _measure_steps(analysis: "Analysis"):
    from lola_drake.linear.presentation.study_figures import steps_figure
    from lola_drake.linear.studies.measured_steps import measured_steps

    title = f"{analysis.name}: steps in the nonlinear simulation, over their height"
    return steps_figure(title, measured_steps(analysis))


def _check(names: list[str], folder: Path, force: bool) -> None:
    """Refuse what `_save` would replace, before there is anything to save."""
    from lola_drake.atomic_file import check_file

    for name in names:
        for kind in ("svg", "png"):
            check_file(folder / f"{name}.{kind}", force=force)


def _save(figures: dict, folder: Path) -> list[Path]:
    """Write figures as SVG and PNG into a folder, and return their paths."""
    from lola_drake.figures.run_figures import save_figure

    for name, figure in figures.items():
        save_figure(figure, folder, name)
    return [folder / f"{name}.{kind}" for name in figures for kind in ("svg", "png")]
