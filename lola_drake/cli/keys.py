"""The command of `lola` that tells what can be set."""

import json
import shutil
import textwrap
from typing import Annotated

import typer

from lola_drake.cli.common import Json, errors_in_one_line

app = typer.Typer()


@app.command()
def keys(
    prefix: Annotated[str, typer.Argument(help="Of the keys, such as control.force.")] = "",
    as_json: Json = False,
) -> None:
    """List the settings of a scenario: default, range, unit, and what each is."""
    from lola_drake.scenario_keys import as_rows, settings

    with errors_in_one_line():
        found = settings(prefix)
    if as_json:
        print(json.dumps(as_rows(found), indent=2))
        return
    width = max(shutil.get_terminal_size().columns - 1, 40)
    for setting in found:
        default = json.dumps(setting.default, ensure_ascii=False)
        print(f"{setting.key}: {default}{' ' * bool(setting.unit)}{setting.unit}")
        text = f"{setting.doc}; {setting.allowed}"
        print(textwrap.fill(text, width, initial_indent="    ", subsequent_indent="    "))
