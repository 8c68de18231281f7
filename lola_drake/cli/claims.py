"""The command of `lola` that shows what is claimed."""

import json

import typer
from rich.table import Table

from lola_drake.cli.common import Json, errors_in_one_line
from lola_drake.cli.terminal import show

app = typer.Typer()


@app.command()
def claims(as_json: Json = False) -> None:
    """Run the tests that show what README and docs claim (CLAIMS.md); minutes, in a checkout."""
    from lola_drake.claims import claims as all_claims
    from lola_drake.claims import run_tests

    with errors_in_one_line():
        chosen = all_claims()
        passed = run_tests(chosen)
    outcome = {
        claim.text: all(passed[test] for test in claim.tests) if claim.tests else None
        for claim in chosen
    }
    if as_json:
        print(json.dumps(outcome, indent=2, ensure_ascii=False))
    else:
        table = Table("claim", "holds", "by hand", "last measured")
        for claim in chosen:
            holds = {True: "yes", False: "NO", None: "-"}[outcome[claim.text]]
            table.add_row(claim.text, holds, "\n".join(claim.commands), claim.measured)
        show(table)
    if not all(passed.values()):
        raise typer.Exit(1)
