"""Tables of text, for a terminal and for a notebook."""

from dataclasses import dataclass
from html import escape

WIDTH = 80
"""Columns of a terminal, into which a table fits (characters)."""


@dataclass(frozen=True)
class Table:
    """A titled table of text."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def as_text(self) -> str:
        """Return the table with aligned columns; one that is too wide comes in parts.

        Each part begins with the first column.
        """
        lines = [self.header, *self.rows]
        first, *others = [_column(cells) for cells in zip(*lines, strict=True)]
        space = next((n for n in (2, 1) if _width([first, *others], n) <= WIDTH), 2)
        parts = [[first]]
        for column in others:
            if _width([*parts[-1], column], space) > WIDTH:
                parts.append([first])
            parts[-1].append(column)
        texts = [(" " * space).join(cells) for part in parts for cells in zip(*part, strict=True)]
        return "\n".join([self.title, *(f"  {text.rstrip()}" for text in texts)])

    def as_html(self) -> str:
        """Return the table as notebooks show it."""
        rows = [_row("th", self.header), *(_row("td", row) for row in self.rows)]
        return f"<p><b>{escape(self.title)}</b></p><table>{''.join(rows)}</table>"


def _row(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag} align=left>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _column(cells: tuple[str, ...]) -> list[str]:
    """Return the cells, all as wide as the widest of them."""
    width = max(map(len, cells))
    return [cell.ljust(width) for cell in cells]


def _width(columns: list[list[str]], space: int) -> int:
    """Return how wide some columns are, indented and with spaces between them."""
    return 2 + sum(len(column[0]) + space for column in columns) - space
