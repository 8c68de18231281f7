"""What `lola bench` prints."""

from collections.abc import Mapping

from rich.table import Table

from lola_drake.studies.tables import number


def bench_table(content: Mapping) -> Table:
    """Return the content of bench.json as a table."""
    table = Table(
        title=f"A tick of {content['scenario']}, {content['repeats']} strides, {content['engine']}"
    )
    _add_columns(table, "min", "median")

    def add(name: str, spread: Mapping, **style) -> None:
        table.add_row(name, *_cells(spread), **style)

    add("closed loop / bare plant", content["closed_loop_over_plant"])
    add("bare plant / with implicit servos", content["plant_over_implicit"])
    add("real-time factor", content["real_time_factor"], end_section=True)
    tick = content["tick_us"]
    for name in ("closed_loop", "plant", "plant_implicit", "own_part", "all_blocks"):
        add(f"{name.replace('_', ' ')} (us)", tick[name])
    for name, spread in tick["blocks"].items():
        add(f"  {name}", spread)
    table.add_section()
    for name, spread in content["plan_ms"].items():
        add(f"{_words(name)} (ms)", spread)
    add("import (s)", content["import_s"])
    add("build the diagram (s)", content["build_s"])
    table.add_row("peak memory (MB)", number(content["peak_memory_mb"]), "")
    return table


def mujoco_tables(content: Mapping) -> list[Table]:
    """Return what bench.json has under "mujoco" as tables: times, standing, and torques."""
    return [_engines_table(content), _standing_table(content["statics"]), _torque_table(content)]


def scaling_table(content: Mapping) -> Table:
    """Return what bench.json has under "scaling" as a table."""
    table = Table(title="Long runs and many runs")
    _add_columns(table, "min", "median")
    table.add_row("a stride after 60 s / after 10 s", *_cells(content["cost_60_s_over_10_s"]))
    table.add_row("two processes / one", *_cells(content["two_processes_over_one"]))
    for name, memory in content["memory_mb"].items():
        table.add_row(f"memory {_words(name)} without logs (MB)", number(memory), "")
    return table


def _engines_table(content: Mapping) -> Table:
    table = Table(title=f"A step of Drake and of MuJoCo {content['version']}")
    _add_columns(table, "min", "median")
    upright = content["strides_upright"]
    for motion, times in content["step_us"].items():
        for engine, spread in times.items():
            fell = motion == "walking" and upright[engine] < upright["drake"]
            note = f", fell after {upright[engine]} strides" if fell else ""
            table.add_row(f"{motion}, {_words(engine)}{note} (us)", *_cells(spread))
        for engine, ratio in content["drake_over_mujoco"][motion].items():
            table.add_row(f"  drake / {_words(engine)}", *_cells(ratio))
        table.add_section()
    return table


def _standing_table(statics: Mapping) -> Table:
    engines = [name for name in statics if name != "joint_torque_Nm"]
    table, torque = Table(title="Standing"), statics["joint_torque_Nm"]
    _add_columns(table, *map(_words, engines))
    for name, digits in (("mass_kg", 3), ("com_height_m", 5)):
        table.add_row(name, *(f"{statics[engine][name]:.{digits}f}" for engine in engines))
    for foot in ("l", "r"):
        forces = (statics[engine]["vertical_force_N"][foot] for engine in engines)
        table.add_row(f"vertical_force_N {foot}", *(f"{force:.2f}" for force in forces))
    for name in ("difference_rms", "difference_worst"):
        values = (number(torque[name].get(engine)) for engine in engines)
        table.add_row(f"joint torques, {_words(name)} (of {number(torque['rms'])} Nm)", *values)
    return table


def _torque_table(content: Mapping) -> Table:
    title = "Joint torques of Drake's walk, by MuJoCo's inverse dynamics (Nm)"
    table = Table(title=title)
    _add_columns(table, "RMS", "RMS difference", "worst", "relative")
    for group, values in content["walk"]["joint_torque"].items():
        names = ("rms_Nm", "difference_rms_Nm", "difference_worst_Nm", "relative")
        table.add_row(group, *(f"{values[name]:.2g}" for name in names))
    return table


def _add_columns(table: Table, *names: str) -> None:
    table.add_column("")
    for name in names:
        table.add_column(name, justify="right")


def _cells(spread: Mapping | None) -> list[str]:
    return [number(None if spread is None else spread[key]) for key in ("min", "median")]


def _words(name: str) -> str:
    return name.replace("_", " ")
