"""Fills the settings page of the docs with what `lola keys` knows."""

import json
from collections.abc import Iterator

from lola_drake.scenario_keys import Setting, settings

MARK = "<!-- settings -->"


def on_page_markdown(markdown: str, **_) -> str:
    """Put tables of all settings in the place of the mark, one for each section."""
    return markdown.replace(MARK, "\n".join(_tables())) if MARK in markdown else markdown


def _tables() -> Iterator[str]:
    sections: dict[str, list[Setting]] = {}
    for setting in settings():
        sections.setdefault(setting.key.rpartition(".")[0], []).append(setting)
    for section, found in sections.items():
        yield f"\n## {section or 'scenario'}\n"
        yield "| key | default | | what it is | allowed |"
        yield "|---|---|---|---|---|"
        yield from map(_row, found)


def _row(setting: Setting) -> str:
    default = json.dumps(setting.default, ensure_ascii=False)
    name = setting.key.rpartition(".")[2]
    cells = f"`{name}`", f"`{default}`", setting.unit, setting.doc, setting.allowed
    return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"
