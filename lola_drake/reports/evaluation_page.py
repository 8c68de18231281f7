"""One page about a law in the arena, beside those that were there before it."""

import json
import re
from collections.abc import Mapping, Sequence
from html import escape

from lola_drake.reports.assets import packed_plotly, page_asset
from lola_drake.studies.evaluation import MEASURED
from lola_drake.studies.ranking import (
    MARGIN_COLUMNS,
    best,
    contenders,
    half_rows,
    margin_rows,
    took_part,
    worlds_told,
)
from lola_drake.view3d.assets import asset
from lola_drake.view3d.replay import packed

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B58900", "#56A0D3", "#7A5BD0", "#5F6873")
"""Of the laws, in their order; `ref` is dashed."""


def evaluation_page(evaluations: Sequence[Mapping]) -> str:
    """Return one page about evaluations of laws; the first one is what it is about."""
    first = evaluations[0]
    laws = [evaluation["law"] for evaluation in evaluations]
    versions = (f"{name} {version}" for name, version in first["versions"].items())
    told = f"{worlds_told(evaluations)}; {', '.join(versions)}"
    content = {
        "contenders": [
            {
                "name": name,
                "colour": COLOURS[laws.index(law) % len(COLOURS)],
                "dash": "dash" if variant == "ref" else "solid",
            }
            for name, law, variant in contenders(evaluations)
        ],
        "trials": {title: _curves(evaluations, title) for title in first["trials"]},
    }
    measured = {key: measure.label for key, measure in MEASURED.items()}
    choices = {"share": "survived (%)", **measured}
    parts = {
        "TITLE": escape(f"{first['law']} in the arena"),
        "ABOUT": escape(told),
        "HALF": _half_table(evaluations),
        "MARGINS": _table(["", *MARGIN_COLUMNS], margin_rows(evaluations)),
        "CHOICES": "".join(f'<option value="{k}">{escape(v)}</option>' for k, v in choices.items()),
        "STYLE": page_asset("report.css"),
        "SCRIPT": asset("unpack.js") + page_asset("evaluation.js"),
        "CONTENT": packed(json.dumps(content).encode()),
        "PLOTLY": packed_plotly(),
    }
    # All at once, so that no part is looked for in another one.
    return re.sub("|".join(parts), lambda match: parts[match[0]], page_asset("evaluation.html"))


def _curves(evaluations: Sequence[Mapping], title: str) -> dict[str, object]:
    def of_contenders(key: str) -> dict[str, object]:
        return {
            name: evaluation["trials"][title][key][variant]
            for evaluation in evaluations
            for name, _, variant in contenders([evaluation])
            if took_part(evaluation, title, variant)
        }

    mine = evaluations[0]["trials"][title]
    return {
        "unit": mine["unit"],
        "direction": mine["direction_deg"],
        "curves": of_contenders("curves"),
        "halves": of_contenders("half"),
    }


def _half_table(evaluations: Sequence[Mapping]) -> str:
    rows = []
    for title, unit, cells, reaches in half_rows(evaluations):
        leading = best(reaches)
        shown = [f"<b>{escape(c)}</b>" if i in leading else escape(c) for i, c in enumerate(cells)]
        rows.append([f"{escape(title)} ({escape(unit)})", *shown])
    names = [escape(name) for name, _, _ in contenders(evaluations)]
    return _html_table(["", *names], rows)


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return _html_table(map(escape, header), [map(escape, row) for row in rows])


def _html_table(header, rows) -> str:
    def line(tag: str, cells) -> str:
        return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in cells)}</tr>"

    return f"<table>{line('th', header)}{''.join(line('td', row) for row in rows)}</table>"
