"""The `lola` command: arguments in, calls the rest, prints.

What a user should read goes to stderr, except for results asked for: with `--json` stdout holds
one JSON document and nothing else. Drake is imported by the commands that need it, so that the
others answer at once.
"""

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from lola_drake.cli import (
    benchmarks,
    claims,
    evaluate,
    keys,
    linear,
    pictures,
    simulate,
    studies,
    study,
    sweep,
)
from lola_drake.cli.common import INTERRUPTED, fail
from lola_drake.cli.terminal import any_terminal, keep_brackets


class _Lola(TyperGroup):
    """The command with all below it; says in one line what is wrong with an option."""

    def __init__(self, *args: Any, **extra: Any):
        """Make the command, see `TyperGroup`."""
        super().__init__(*args, **extra)
        keep_brackets(self)

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """Run the command, see `TyperGroup.main`."""
        any_terminal()
        run: Callable[..., Any] = super().main
        try:
            code = run(*args, standalone_mode=False, **extra)
        except Exception as error:
            message = getattr(error, "format_message", None)
            if not standalone_mode or message is None:
                raise
            # Without any arguments the message is the help itself.
            if text := message():
                fail(" ".join(text.split()))
            code = getattr(error, "exit_code", 1)
        if not standalone_mode:
            return code
        raise SystemExit(code if isinstance(code, int) else 0)

    def invoke(self, ctx):
        """Call what was asked for; who is stopped says so, once."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            fail("stopped")
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(
    cls=_Lola,
    help="Walk the humanoid LOLA in simulation, look into its controller, and analyse it.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for theme in (
    simulate,
    keys,
    claims,
    pictures,
    studies,
    sweep,
    evaluate,
    benchmarks,
    linear,
):
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
