"""One page about one run, or about several beside each other: to look at, keep and mail."""

import re
from collections.abc import Sequence
from html import escape

from lola_drake.diagram.block_diagram import block_diagram
from lola_drake.diagram.drawing import to_svg
from lola_drake.figures.comparison import labels
from lola_drake.reports.assets import packed_plotly, page_asset
from lola_drake.reports.payload import payload
from lola_drake.results import Result
from lola_drake.scenario import Scenario, differences
from lola_drake.typed_yaml import leaves, plain
from lola_drake.view3d.assets import asset
from lola_drake.view3d.markers import LEGEND, PUSH_LEGEND
from lola_drake.world import build_simulation

SCRIPTS = ("data.js", "plots.js", "report.js")

DARK = ':root[data-theme="dark"]'
"""The page is dark because of this, and its diagram with it."""

HEADLINES = {
    "largest inclination φ_x": ("max_inclination_deg.x", "°"),
    "largest inclination φ_y": ("max_inclination_deg.y", "°"),
    "RMS error of T_x": ("rms_torque_error_Nm.x", "Nm"),
    "RMS error of T_y": ("rms_torque_error_Nm.y", "Nm"),
    "largest force on a foot": ("max_foot_force_N", "N"),
}
"""The metrics that a report begins with: key in the summary, unit."""


def report_page(results: Sequence[Result], replay: str, names: Sequence[str] = ()) -> str:
    """Return one page about some runs; the first is what the others are compared with.

    Args:
        results: The runs.
        replay: From `packed_replay`.
        names: What they are called; unless given, what tells them apart.
    """
    first = results[0].scenario
    names = list(names) or (labels(results) if len(results) > 1 else [first.variant])
    title = " and ".join(dict.fromkeys(result.scenario.name for result in results))
    packed_curves = payload(results, names)
    parts = {
        "STYLE": page_asset("report.css"),
        "TITLE": escape(f"{title}: {', '.join(names)}"),
        "HEADER": _header(results, names),
        "TILES": _tiles(results),
        "LEGEND": _legend(results, names),
        "METRICS": _metrics_table(results, names),
        "SETTINGS": _settings_table(results, names),
        "DIAGRAM": _diagram(first),
        "SCRIPT": asset("unpack.js") + "".join(map(page_asset, SCRIPTS)),
        "SHAPE": packed_curves["shape"],
        "NUMBERS": packed_curves["numbers"],
        "PLOTLY": packed_plotly(),
        "SCENE": replay,
    }
    # All at once, so that no part is looked for in another one.
    return re.sub("|".join(parts), lambda match: parts[match[0]], page_asset("report.html"))


def _header(results: Sequence[Result], names: list[str]) -> str:
    told = [results[0].scenario.description, _versions(results[0])]
    falls = [
        f'<p class="fell">{escape(name)}: fell at {result.fall_time:.2f} s</p>'
        for result, name in zip(results, names, strict=True)
        if result.fall_time is not None
    ]
    return "\n".join([*(f"<p>{escape(text)}</p>" for text in told if text), *falls])


def _tiles(results: Sequence[Result]) -> str:
    """Return the few metrics that are asked for first; of two runs as first → second."""
    rows = [_flat(result.summary) for result in results]
    tiles = []
    for name, (key, unit) in HEADLINES.items():
        value = " → ".join(_number(row[key], 3) for row in rows)
        change = f" ({_change(*(row[key] for row in rows))})" if _comparable(results) else ""
        tiles.append(f"<div><b>{value} {unit}{change.replace(' ()', '')}</b>{name}</div>")
    return "".join(tiles)


def _legend(results: Sequence[Result], names: list[str]) -> str:
    entries = [*LEGEND]
    if any(result.scenario.pushes for result in results):
        entries.append(PUSH_LEGEND)
    if len(names) > 1:
        entries.insert(0, ("var(--ghost)", f"ghost: {', '.join(names[:-1])}; robot: {names[-1]}"))
    return "".join(
        f'<li><i style="background:{colour}"></i>{escape(text)}</li>' for colour, text in entries
    )


def _versions(result: Result) -> str:
    versions = ", ".join(
        f"{name} {version}"
        for name, version in result.versions.items()
        if version != "not installed"
    )
    return f"seed {result.scenario.seed}; {versions}"


def _metrics_table(results: Sequence[Result], names: list[str]) -> str:
    rows = [_flat(result.summary) for result in results]
    compared = _comparable(results)
    head = ["metric", *names, *(["change"] if compared else [])]
    lines = [_row("th", head)]
    for key in rows[0]:
        cells = [key, *(_number(row[key]) for row in rows)]
        if compared:
            cells.append(_change(rows[0][key], rows[1][key]))
        lines.append(_row("td", cells))
    return f"<table>{''.join(lines)}</table>"


def _comparable(results: Sequence[Result]) -> bool:
    """Return whether changes say something: after a fall two runs tell of different times."""
    return len(results) == 2 and all(result.fall_time is None for result in results)


def _flat(summary: dict) -> dict[str, object]:
    """Return the metrics of a summary without nesting."""
    told = {"scenario", "variant", "seed", "versions", "disturbances"}
    return {key: value for key, value in leaves(summary).items() if key.split(".")[0] not in told}


def _number(value: object, digits: int = 4) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else f"{value:.{digits}g}"


def _change(before: object, after: object) -> str:
    if not (isinstance(before, float) and isinstance(after, float) and before):
        return ""
    percent = round(100 * (after / before - 1))
    return f"{percent:+d} %" if percent else "±0 %"


def _settings_table(results: Sequence[Result], names: list[str]) -> str:
    default = leaves(plain(Scenario()))
    told = {"name", "description"}
    changed = [differences(result.scenario) for result in results]
    keys = [key for key in default if key not in told and any(key in c for c in changed)]
    if not keys:
        return "<p>None.</p>"
    lines = [_row("th", ["setting", "default", *names])]
    for key in keys:
        values = [leaves(plain(result.scenario))[key] for result in results]
        lines.append(_row("td", [key, _plain(default[key]), *map(_plain, values)]))
    return f"<table>{''.join(lines)}</table>"


def _plain(value: object) -> str:
    if isinstance(value, list):
        return "; ".join(map(_plain, value)) or "–"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_plain(entry)}" for key, entry in value.items())
    return str(value)


def _row(tag: str, cells: list[str]) -> str:
    """Return a row of a table; where it is narrow a key goes on after a dot or underscore."""
    key, *values = map(escape, cells)
    shown = re.sub(r"[._](?=\w)", r"\g<0><wbr>", key), *values
    return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in shown)}</tr>"


def _diagram(scenario: Scenario) -> str:
    drawing = block_diagram(build_simulation(scenario), system="controller")
    return to_svg(drawing, dark=DARK)
