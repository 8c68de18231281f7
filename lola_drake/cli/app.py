"""The `lola` command: arguments in, calls the rest, prints.

What a user should read goes to stderr, except for results asked for: with `--json` stdout holds
one JSON document and nothing else. Drake is imported by the commands that need it, so that the
others answer at once.
"""

from importlib.metadata import PackageNotFoundError, version
from typing import Annotated

import typer
from typer.core import TyperGroup

from lola_drake.cli import benchmarks, keys, linear, pictures, simulate, studies, study
from lola_drake.cli.common import fail
from lola_drake.cli.terminal import any_terminal


class _Lola(TyperGroup):
    """The command with all below it; says in one line what is wrong with an option."""

    def main(self, *args, standalone_mode: bool = True, **extra):
        """Run the command, see `TyperGroup.main`."""
        any_terminal()
        try:
            code = super().main(*args, standalone_mode=False, **extra)
        except Exception as error:
            if not (standalone_mode and hasattr(error, "format_message")):
                raise
            # Without any arguments the message is the help itself.
            text = error.format_message()
            fail(" ".join(text.split())) if text else None
            code = error.exit_code
        if not standalone_mode:
            return code
        raise SystemExit(code if isinstance(code, int) else 0)


app = typer.Typer(
    cls=_Lola,
    help="Walk the humanoid LOLA in simulation, look into its controller, and analyse it.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for theme in (simulate, keys, pictures, studies, benchmarks, linear):
    app.add_typer(theme.app)
app.add_typer(study.app, name="study")


def _version(asked: bool) -> None:
    if asked:
        try:
            print(f"lola_drake {version('lola_drake')}")
        except PackageNotFoundError:
            print("lola_drake, not installed")
        raise typer.Exit


@app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Tell the version."),
    ] = False,
) -> None:
    """Walk the humanoid LOLA in simulation, look into its controller, and analyse it."""
