"""A sweep as a table: one row for each point."""

from collections.abc import Mapping

from rich.table import Table

from lola_drake.studies.tables import number, signed


def sweep_table(content: Mapping) -> Table:
    """Return the content of sweep.json as a table, with causes of falls and the worst run below."""
    variants, worlds = content["variants"], content["worlds"]
    table = Table(
        title=f"{content['scenario']}: survived of {worlds} (%), and median {content['metric']}",
        title_justify="left",
        caption="\n".join(_notes(content)),
        caption_justify="left",
    )
    for key, factor in content["factors"].items():
        table.add_column(f"{key} ({factor['unit']})" if factor["unit"] else key, justify="right")
    for variant in variants:
        table.add_column(f"{variant} %", justify="right")
        table.add_column(f"{variant} median", justify="right")
    if len(variants) > 1:
        table.add_column(f"{variants[1]} against {variants[0]} (%)", justify="right")
    for point in content["points"]:
        cells = [_value(value) for value in point["values"].values()]
        for variant in variants:
            found = point["variants"][variant]
            cells += [f"{100 * found['survived']['share']:.0f}", _median(found["metric"])]
        if len(variants) > 1:
            cells.append(signed(point["change_percent"]["median"]))
        table.add_row(*cells)
    return table


def _notes(content: Mapping) -> list[str]:
    lines = [
        f"{variant} fell {count} times, first: {cause}"
        for variant, causes in content["causes"].items()
        for cause, count in causes.items()
    ]
    return [*lines, f"the worst run: {content['worst'][0]['command']}"]


def _median(found: Mapping) -> str:
    """Return a median with its interval."""
    interval = found["interval_95"]
    told = f" ({number(interval[0])} … {number(interval[1])})" if interval else ""
    return f"{number(found['median'])}{told}"


def _value(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)
