"""The `lola` command: arguments in, calls the rest, prints.

What a user should read goes to stderr, except for results asked for: with `--json` stdout holds
one JSON document and nothing else. Drake is imported by the commands that need it, so that the
others answer at once.
"""

import typer

from lola_drake.cli import benchmarks, keys, linear, pictures, simulate, studies

app = typer.Typer(
    help="Walk the humanoid LOLA in simulation, look into its controller, and analyse it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for theme in (simulate, keys, pictures, studies, benchmarks, linear):
    app.add_typer(theme.app)
