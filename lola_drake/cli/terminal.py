"""Terminals of any kind: what cannot be shown as it is, is shown in ASCII."""

import codecs
import sys
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

ASCII = {
    "φ": "phi",
    "δ": "delta",
    "Δ": "Delta",
    "ω": "omega",
    "°": "deg",
    "µ": "u",
    "²": "2",
    "–": "-",
    "−": "-",
    "…": "..",
    "→": "->",
    "←": "<-",
    "↑": "^",
    "↓": "v",
}


def in_ascii(text: str) -> str:
    """Return a text in ASCII, as it would be written by hand."""
    return "".join(c if c.isascii() else ASCII.get(c, "?") for c in text)


def any_terminal() -> None:
    """Let stdout and stderr take any text, whatever their encoding is."""

    def spelled(error: UnicodeError) -> tuple[str, int]:
        if not isinstance(error, UnicodeEncodeError):
            raise error
        return in_ascii(error.object[error.start : error.end]), error.end

    codecs.register_error("spelled", spelled)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="spelled")


def show(table: Table) -> None:
    """Print a table: whole names in any width, in ASCII where the terminal has nothing else.

    Texts stay as they are, also where they look like markup.
    """
    console = Console(markup=False, emoji=False)
    for column in table.columns:
        column.overflow = "fold"
        if console.options.ascii_only:
            column.header = in_ascii(str(column.header))
            column._cells[:] = [in_ascii(str(cell)) for cell in column.cells]
    console.print(table)


def keep_brackets(command: Any) -> None:
    """Let the help of a command and of those below it show brackets: Typer takes them for markup.

    Args:
        command: of Click; must not have been treated before.
    """
    for part in (command, *command.params):
        if part.help:
            part.help = escape(part.help)
    for inner in getattr(command, "commands", {}).values():
        keep_brackets(inner)
