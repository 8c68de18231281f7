"""One page about one run, or about several beside each other: to look at, keep and mail."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from lola_drake.diagram.block_diagram import block_diagram
from lola_drake.diagram.drawing import to_svg
from lola_drake.figures.comparison import COMPARISONS, labels
from lola_drake.figures.run_figures import figure_bytes
from lola_drake.figures.style import look
from lola_drake.results import Result
from lola_drake.scenario import Scenario, differences
from lola_drake.typed_yaml import leaves, plain
from lola_drake.view3d.replay import UNPACK
from lola_drake.world import build_simulation

STYLE = """
:root { color-scheme: light dark; --ink: #1f2328; --faint: #5f6873; --page: #fff; --card: #f6f8fa;
  --line: #d8dee4; --bad: #b00020; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --faint: #98a2ad; --page: #0d1117;
  --card: #161b22; --line: #30363d; --bad: #ff8a8a; } }
body { font: 15px/1.5 system-ui, "Helvetica Neue", Arial, sans-serif; color: var(--ink);
  background: var(--page); max-width: 1080px; margin: 0 auto; padding: 24px; }
h1 { margin: 0; font-size: 26px; } h2 { margin: 36px 0 8px; font-size: 19px; }
p { margin: 4px 0; color: var(--faint); }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 3px 14px 3px 0; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
td:first-child { font-family: ui-monospace, Menlo, Consolas, monospace; font-size: 13px; }
img, object { display: block; width: 100%; margin: 12px 0; border-radius: 6px;
  background: #fff; }
object { background: var(--page); }
.replay { background: var(--card); border: 1px solid var(--line); border-radius: 6px;
  height: 520px; margin: 8px 0; display: flex; align-items: center; justify-content: center; }
iframe { border: 0; width: 100%; height: 100%; border-radius: 6px; }
button { font: inherit; padding: 10px 18px; border-radius: 6px; border: 1px solid var(--line);
  background: var(--page); color: var(--ink); cursor: pointer; }
.fell { color: var(--bad); font-weight: 600; }
@media print { .replay { display: none; } }
"""

SCRIPT = (
    UNPACK
    + """
for (const place of document.querySelectorAll(".replay")) {
  place.querySelector("button").addEventListener("click", async () => {
    const frame = document.createElement("iframe");
    frame.srcdoc = await unpack(place.querySelector("script").textContent);
    place.replaceChildren(frame);
  });
}
"""
)


@dataclass(frozen=True)
class RunPictures:
    """What a report shows of one run.

    Attributes:
        figures: SVG by the figures' names.
        replay: From `packed_replay`.
    """

    figures: dict[str, bytes]
    replay: str


def report_page(results: Sequence[Result], pictures: Sequence[RunPictures]) -> str:
    """Return one page about some runs; the first is what the others are compared with."""
    first = results[0].scenario
    names = labels(results) if len(results) > 1 else [first.variant]
    title = " and ".join(dict.fromkeys(result.scenario.name for result in results))
    replays = [picture.replay for picture in pictures]
    parts = [
        f"<h1>{escape(title)}</h1>",
        f"<p>{escape(first.description)}</p>",
        f"<p>{escape(_versions(results[0]))}</p>",
        "<h2>Metrics</h2>",
        _metrics_table(results, names),
        "<h2>Replay</h2>",
        *(_replay(*each) for each in zip(results, names, replays, strict=True)),
        "<h2>Figures</h2>",
        *_figures(results, names, pictures),
        "<h2>Settings that differ from the defaults</h2>",
        _settings_table(results, names),
        "<h2>Block diagram of the controller</h2>",
        _diagram(first),
    ]
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
        f"</title>\n<style>{STYLE}</style></head>\n<body>\n{body}\n<script>{SCRIPT}</script>\n"
        "</body></html>\n"
    )


def _versions(result: Result) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in result.versions.items())
    return f"seed {result.scenario.seed}; {versions}"


def _metrics_table(results: Sequence[Result], names: list[str]) -> str:
    rows = [_flat(result.summary) for result in results]
    compared = len(rows) == 2
    head = ["metric", *names, *(["change"] if compared else [])]
    lines = [_row("th", head)]
    for key in rows[0]:
        cells = [key, *(_number(row[key]) for row in rows)]
        if compared:
            cells.append(_change(rows[0][key], rows[1][key]))
        lines.append(_row("td", cells))
    return f"<table>{''.join(lines)}</table>"


def _flat(summary: dict) -> dict[str, object]:
    """Return the metrics of a summary without nesting."""
    told = {"scenario", "variant", "seed", "versions"}
    return {key: value for key, value in leaves(summary).items() if key.split(".")[0] not in told}


def _number(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}"


def _change(before: object, after: object) -> str:
    numbers = all(isinstance(v, float) and not isinstance(v, bool) for v in (before, after))
    return f"{100 * (after / before - 1):+.0f} %" if numbers and before else ""


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
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _replay(result: Result, name: str, replay: str) -> str:
    label = escape(f"Play {result.scenario.name} ({name})")
    fall = ""
    if result.fall_time is not None:
        fall = f'<p class="fell">{escape(name)}: fell at {result.fall_time:.2f} s</p>'
    return (
        f'{fall}<div class="replay"><button>▶ {label}</button>'
        f'<script type="text/plain">{replay}</script></div>'
    )


def _figures(
    results: Sequence[Result], names: list[str], pictures: Sequence[RunPictures]
) -> list[str]:
    galleries = [
        "\n".join(_image(name, svg) for name, svg in picture.figures.items())
        for picture in pictures
    ]
    if len(results) == 1:
        return galleries
    with look():
        together = {name: draw(results) for name, draw in COMPARISONS.items()}
    return [
        *(_image(name, figure_bytes(figure, "svg")) for name, figure in together.items()),
        *(
            f"<details><summary>{escape(name)}</summary>{gallery}</details>"
            for name, gallery in zip(names, galleries, strict=True)
        ),
    ]


def _image(name: str, svg: bytes) -> str:
    return f'<img alt="{escape(name)}" src="{_data(svg)}">'


def _diagram(scenario: Scenario) -> str:
    drawing = block_diagram(build_simulation(scenario), system="controller")
    data = _data(to_svg(drawing).encode())
    return f'<object type="image/svg+xml" data="{data}" aria-label="controller"></object>'


def _data(svg: bytes) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode()}"
