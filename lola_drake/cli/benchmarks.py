"""The command of `lola` that measures how long a tick takes."""

import json
from pathlib import Path
from typing import Annotated

import typer

from lola_drake.cli.common import COUNT, Engine, Force, Json, errors_in_one_line, progress_bar
from lola_drake.cli.terminal import show

app = typer.Typer()


@app.command()
def bench(
    repeats: Annotated[int, typer.Option(min=1, max=1000, help="Strides that are measured.")] = 5,
    vs_mujoco: Annotated[
        bool, typer.Option("--vs-mujoco", help="Compare the plant with the same robot in MuJoCo.")
    ] = False,
    scaling: Annotated[
        bool, typer.Option("--scaling", help="Compare long runs with short ones, and two with one.")
    ] = False,
    engine: Engine = "fused",
    output: Annotated[Path, typer.Option("--output", "-o", help="File of the result.")] = Path(
        "bench.json"
    ),
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Measure how long a tick takes: closed loop, bare plant and every block, in turns."""
    from lola_drake.atomic_file import check_file, write_json
    from lola_drake.benchmarks.bench import bench as measure
    from lola_drake.benchmarks.bench_tables import bench_table, mujoco_tables, scaling_table

    more = {}
    with errors_in_one_line():
        check_file(output, force=force)
        if vs_mujoco:
            from lola_drake.benchmarks.bench_mujoco import bench_mujoco

            more["mujoco"] = bench_mujoco
        if scaling:
            from lola_drake.benchmarks.bench_scaling import bench_scaling

            more["scaling"] = bench_scaling
        with progress_bar("strides", repeats, COUNT) as advance:
            content = measure(repeats, advance, engine)
        for name, measure_more in more.items():
            with progress_bar(name, repeats, COUNT) as advance:
                content[name] = measure_more(repeats, advance)
        write_json(content, output)
    if as_json:
        print(json.dumps(content, indent=2))
        return
    show(bench_table(content))
    for table in mujoco_tables(content["mujoco"]) if vs_mujoco else ():
        show(table)
    if scaling:
        show(scaling_table(content["scaling"]))
    print(f"written to {output}")
