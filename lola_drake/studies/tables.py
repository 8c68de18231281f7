"""What the studies print: tables of comparisons, reproduction, and search for gains."""

from collections.abc import Mapping
from typing import Any

from rich.table import Table
from rich.text import Text

from lola_drake.studies.variants import COMPARED

SHOWN = (
    ("max_inclination_deg", "x", "max |φ_x|"),
    ("max_inclination_deg", "y", "max |φ_y|"),
    ("rms_torque_error_Nm", "x", "RMS e_Tx"),
    ("rms_torque_error_Nm", "y", "RMS e_Ty"),
)
"""The metrics of which the paper gives figures: name, axis, and the paper's symbol."""


def comparison_table(content: Mapping) -> Table:
    """Return the content of compare.json as a table."""
    variants, change = content["variants"], content["change_percent"]
    table = Table(title=content["scenario"])
    table.add_column("")
    for name in (*variants, "change (%)"):
        table.add_column(name, justify="right")
    falls = [summary["fall_time_s"] for summary in variants.values()]
    table.add_row("fell", *("no" if time is None else f"at {time:.2f} s" for time in falls), "")
    for metric, axes in COMPARED.items():
        for axis in axes or (None,):
            values = (number(_entry(summary[metric], axis)) for summary in variants.values())
            table.add_row(_name(metric, axis), *values, signed(_entry(change[metric], axis)))
    for kind in next(iter(variants.values()))["steps_beyond_limits"]:
        counts = (str(summary["steps_beyond_limits"][kind]) for summary in variants.values())
        table.add_row(f"steps at the limit of {kind.replace('_', ' ')}", *counts, "")
    return table


def reproduction_table(content: Mapping) -> Table:
    """Return the content of reproduction.json as a table, paper against simulation."""
    sampled = any(experiment["worlds"] > 1 for experiment in content["experiments"].values())
    table = Table(title="Change of the second variant against the first (%)", title_justify="left")
    table.add_column("")
    for name in ("paper", "median", "quartiles") if sampled else ("paper", "here"):
        table.add_column(name, justify="right")
    for name, experiment in content["experiments"].items():
        first, second = experiment["variants"]
        table.add_row(Text.assemble((name, "bold"), f": {first}, {second}"))
        for metric, axis, symbol in SHOWN:
            paper = experiment["paper"].get(metric, {}).get(axis)
            change = experiment["median_change_percent"][metric][axis]
            spread = experiment["quartiles"][metric][axis]
            cells = [signed(paper, digits=0), signed(change)]
            if sampled:
                cells.append("-" if spread is None else " … ".join(map(signed, spread)))
            table.add_row(f"  {symbol}", *cells)
        table.add_row(f"  falls: {_falls(experiment)}", end_section=True)
    return table


def _falls(experiment: Mapping) -> str:
    worlds, failures = experiment["worlds"], experiment["failures"]
    told = [f"{name} {count} of {worlds}" for name, count in experiment["falls"].items()]
    told += [f"{name} failed in {count}" for name, count in failures.items() if count]
    return ", ".join(told)


def survival_table(content: Mapping) -> Table:
    """Return the content of survival.json as a table: one row for each height."""
    table = Table(title=f"Survived of {content['worlds']} worlds (%)")
    table.add_column("height (cm)", justify="right")
    columns = [(name, v) for name, variants in content["survived"].items() for v in variants]
    for name, variant in columns:
        table.add_column(f"{name}, {variant}", justify="right")
    for k, height in enumerate(content["heights_m"]):
        points = (content["survived"][name][variant][k] for name, variant in columns)
        table.add_row(f"{100 * height:.0f}", *(f"{100 * p['share']:.0f}" for p in points))
    return table


def tuning_table(content: Mapping) -> Table:
    """Return the record of a search for gains as a table: where it began, and what it chose."""
    table = Table(title=f"gains of {content['variant']}, worlds: {len(content['seeds'])}")
    table.add_column("")
    for name in ("start", "chosen", "importance"):
        table.add_column(name, justify="right")
    start, chosen, importance = (content[name] for name in ("start", "chosen", "importance"))
    for key, unit in content["units"].items():
        values = (number(trial["values"][key]) for trial in (start, chosen))
        share = f"{100 * importance[key]:.0f} %" if key in importance else "-"
        table.add_row(f"{key} ({unit})", *values, share)
    table.add_section()
    for name in ("falls", "overloaded", "inclination_deg"):
        table.add_row(name, *(number(trial[name]) for trial in (start, chosen)))
    return table


def number(value: float | None) -> str:
    """Return a value in a few digits; a dash for none."""
    return "-" if value is None else f"{value:.4g}"


def signed(value: float | None, digits: int = 1) -> str:
    """Return a change with its sign; a dash for none."""
    return "-" if value is None else f"{value:+.{digits}f}"


def _entry(value: Any, axis: str | None) -> float | None:
    return value if axis is None else value[axis]


def _name(metric: str, axis: str | None) -> str:
    return metric if axis is None else f"{metric} {axis}"
