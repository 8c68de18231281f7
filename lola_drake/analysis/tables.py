"""What the studies print: tables of comparisons, of the reproduction, and of a search for gains."""

from collections.abc import Iterator, Mapping

from rich.table import Table

from lola_drake.analysis.variants import COMPARED

SHOWN = ("max_inclination_deg", "rms_torque_error_Nm")
"""The metrics of which the paper gives figures."""


def comparison_table(content: Mapping) -> Table:
    """Return the content of compare.json as a table."""
    variants, change = content["variants"], content["change_percent"]
    table = Table(title=content["scenario"])
    table.add_column("")
    for name in (*variants, "change"):
        table.add_column(name, justify="right")
    falls = [summary["fall_time_s"] for summary in variants.values()]
    table.add_row("fell", *("no" if time is None else f"at {time:.2f} s" for time in falls), "")
    for metric in COMPARED:
        for axis in _axes(change[metric]):
            values = (number(_entry(summary[metric], axis)) for summary in variants.values())
            table.add_row(_name(metric, axis), *values, percent(_entry(change[metric], axis)))
    for kind in next(iter(variants.values()))["steps_beyond_limits"]:
        counts = (str(summary["steps_beyond_limits"][kind]) for summary in variants.values())
        table.add_row(f"steps at the limit of {kind.replace('_', ' ')}", *counts, "")
    return table


def reproduction_table(content: Mapping) -> Table:
    """Return the content of reproduction.json as a table, paper against simulation."""
    table = Table(title="The paper's experiments: change of the second variant against the first")
    for name in ("experiment", "change of"):
        table.add_column(name)
    for name in ("paper", "here", "quartiles", "falls"):
        table.add_column(name, justify="right")
    for name, experiment in content["experiments"].items():
        for i, cells in enumerate(_change_rows(experiment)):
            first, second = experiment["variants"]
            heading = (f"{name}: {first} → {second}", *cells, _falls(experiment))
            table.add_row(*(heading if i == 0 else ("", *cells, "")))
        table.add_section()
    return table


def _change_rows(experiment: Mapping) -> Iterator[tuple[str, str, str, str]]:
    for metric in SHOWN:
        for axis in "xy":
            spread = experiment["quartiles"][metric][axis]
            yield (
                _name(metric, axis),
                percent(experiment["paper"].get(metric, {}).get(axis), digits=0),
                percent(experiment["median_change_percent"][metric][axis]),
                "-" if spread is None else f"{spread[0]:+.1f} … {spread[1]:+.1f}",
            )


def _falls(experiment: Mapping) -> str:
    worlds = experiment["worlds"]
    return ", ".join(f"{name} {count}/{worlds}" for name, count in experiment["falls"].items())


def tuning_table(content: Mapping) -> Table:
    """Return the record of a search for gains as a table: where it began, and what it chose."""
    table = Table(title=f"{content['variant']} in {len(content['seeds'])} worlds")
    table.add_column("")
    for name in ("start", "chosen"):
        table.add_column(name, justify="right")
    start, chosen = content["start"], content["chosen"]
    for key, unit in content["units"].items():
        values = (number(trial["values"][key]) for trial in (start, chosen))
        table.add_row(f"{key} ({unit})", *values)
    table.add_section()
    for name in ("falls", "inclination_deg"):
        table.add_row(name, *(number(trial[name]) for trial in (start, chosen)))
    return table


def number(value: float | None) -> str:
    """Return a value in a few digits; a dash for none."""
    return "-" if value is None else f"{value:.4g}"


def percent(value: float | None, digits: int = 1) -> str:
    """Return a change with its sign; a dash for none."""
    return "-" if value is None else f"{value:+.{digits}f} %"


def _axes(value: object) -> list[str | None]:
    return list(value) if isinstance(value, Mapping) else [None]


def _entry(value: object, axis: str | None) -> float | None:
    return value if axis is None else value[axis]


def _name(metric: str, axis: str | None) -> str:
    return metric if axis is None else f"{metric} {axis}"
