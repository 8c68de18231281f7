"""The command of `lola` that puts a law of the feet's forces through the arena."""

from pathlib import Path
from typing import Annotated

import typer

from lola_drake.cli.common import MOST, Changes, Json, drawn, errors_in_one_line
from lola_drake.cli.studying import Cluster, Folder, Jobs, conclude, studying

app = typer.Typer()


@app.command()
def evaluate(
    law: Annotated[str, typer.Argument(help="One of control.law, or FILE.py:CLASS.")],
    quick: Annotated[bool, typer.Option("--quick", help="A part of it, in two minutes.")] = False,
    worlds: Annotated[
        int | None,
        typer.Option(min=1, max=MOST, help="At every size of a trial: 10, or 4 if quick."),
    ] = None,
    trial: Annotated[
        list[str] | None,
        typer.Option(help="Only trials whose title begins so, such as push; may be repeated."),
    ] = None,
    variant: Annotated[
        list[str] | None, typer.Option(help="ref or dyn; may be repeated. Else both.")
    ] = None,
    bisect: Annotated[
        bool, typer.Option("--bisect", help="Only the sizes that tell where half of them fall.")
    ] = False,
    changes: Changes = None,
    against: Annotated[
        list[Path] | None,
        typer.Option(help="evaluation.json of another law; may be repeated. Else those kept."),
    ] = None,
    output: Folder = None,
    jobs: Jobs = 2,
    cluster: Cluster = None,
    as_json: Json = False,
) -> None:
    """Find up to which size of edges, boards, slopes, pushes a force law stays up.

    Without and with the CoM dynamics, beside the other laws. An evaluation that was stopped goes on
    where it was when it is started again.
    """
    from lola_drake.atomic_file import whole_file
    from lola_drake.paths import arena_records
    from lola_drake.reports.evaluation_page import evaluation_page
    from lola_drake.studies.arena import QUICK, TRIALS
    from lola_drake.studies.evaluation import (
        VARIANTS,
        bisecting,
        chosen,
        law_name,
        law_settings,
        upward,
    )
    from lola_drake.studies.evaluation import evaluate as found
    from lola_drake.studies.push_figure import push_figure
    from lola_drake.studies.ranking import evaluation_table, load_evaluation, with_others

    changed, variants = changes or [], variant or VARIANTS
    whole, count = (QUICK, worlds or 4) if quick else (TRIALS, worlds or 10)
    with errors_in_one_line():
        law_settings(law, changed)
        trials = chosen(whole, trial or [])
        others = [load_evaluation(file) for file in (against or arena_records())]
    name, following = law_name(law, changed), bisecting if bisect else upward
    folder = output or Path("runs") / f"evaluate_{law_name(law)}"
    total = count * len(variants) * sum(len(each.sizes) for each in trials)
    with studying(folder, jobs, cluster, name, total) as (study, advance):
        content = found(law, study, count, advance, trials, changed, variants, following)
    evaluations = with_others(content, others)
    with errors_in_one_line(), drawn(folder), whole_file(folder / "evaluation.html") as page:
        page.write_text(evaluation_page(evaluations), encoding="utf-8")
    conclude(
        folder,
        "evaluation",
        lambda: content,
        lambda _: evaluation_table(evaluations),
        lambda _: push_figure(evaluations),
        as_json=as_json,
    )
