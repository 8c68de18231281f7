"""What the commands of `lola` share."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells give it."""

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, and nothing else.")]

Host = Annotated[
    str, typer.Option(help="Where a browser may be; * lets everybody in who reaches this machine.")
]


@contextmanager
def errors_in_one_line() -> Iterator[None]:
    """Exit with code 2 and one line on stderr where a user's input cannot be used."""
    from lola_drake.analysis.linear.errors import AnalysisError
    from lola_drake.analysis.picture_file import PictureError
    from lola_drake.results import ResultError
    from lola_drake.scenario import ScenarioError

    try:
        yield
    except (ScenarioError, ResultError, PictureError, AnalysisError) as error:
        typer.echo(f"lola: {error}", err=True)
        raise typer.Exit(2) from None
