"""Laws in the arena beside each other, as rows of text: what table and page have in common.

What was kept of a law stands beside a new one wherever both took part in a trial.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from math import inf
from pathlib import Path

from rich.table import Table

from lola_drake.atomic_file import reason
from lola_drake.errors import ResultError

MARGIN_COLUMNS = ("disk", "phase (deg)", "delay (ms)")

Reach = tuple[float, float]
"""By which contenders are ranked: where half fall, and the share that stays up beyond what was
tried. Records may have tried other sizes, so what lies beyond these is infinitely far, or near."""


def contenders(evaluations: Sequence[Mapping]) -> Iterator[tuple[str, str, str]]:
    """Yield name, law and variant of every contender."""
    for evaluation in evaluations:
        for variant in evaluation["margins"]:
            yield f"{evaluation['law']}, {variant}", evaluation["law"], variant


def worlds_told(evaluations: Sequence[Mapping]) -> str:
    """Return in how many worlds each law was, which may differ."""
    counts = (f"{evaluation['law']} {evaluation['worlds']}" for evaluation in evaluations)
    return f"worlds at each size: {', '.join(counts)}"


def load_evaluation(file: str | Path) -> Mapping:
    """Return what `evaluate` has written.

    Raises:
        ResultError: If the file cannot be read, or is something else.
    """
    try:
        content = json.loads(Path(file).read_text(encoding="utf-8"))
        list(half_rows([content]))
        margin_rows([content])
    except OSError as error:
        raise ResultError(f"{file}: cannot be read, {reason(error)}") from None
    except (ValueError, KeyError, TypeError, AttributeError, IndexError):
        raise ResultError(f"{file}: not an evaluation.json of lola evaluate") from None
    return content


def with_others(evaluation: Mapping, others: Sequence[Mapping]) -> list[Mapping]:
    """Return an evaluation and those of other laws."""
    return [evaluation, *(other for other in others if other["law"] != evaluation["law"])]


def evaluation_table(evaluations: Sequence[Mapping]) -> Table:
    """Return evaluations as a table; the first one is what it is about.

    A row for every trial: the size at which half of the worlds fall.
    """
    first = evaluations[0]
    table = Table(title=f"half of the worlds fall at ({worlds_told(evaluations)})")
    table.add_column("")
    for name, _, _ in contenders(evaluations):
        table.add_column(name, justify="right")
    for title, unit, texts, _ in half_rows(evaluations):
        table.add_row(f"{title} ({unit})", *texts)
    table.add_section()
    for loop in next(iter(first["margins"].values())):
        texts = [
            _margins(loops[loop])[0]
            for evaluation in evaluations
            for loops in evaluation["margins"].values()
        ]
        table.add_row(f"{loop}, disk margin", *texts)
    return table


def half_rows(
    evaluations: Sequence[Mapping],
) -> Iterator[tuple[str, str, list[str], list[Reach | None]]]:
    """Yield of every trial its title, its unit, and of every contender where half fall.

    As text, and as what ranks contenders; None where one did not take part.
    """
    for title, trial in evaluations[0]["trials"].items():
        texts, reaches = [], []
        for evaluation in evaluations:
            for variant in evaluation["margins"]:
                text, reach = "", None
                if took_part(evaluation, title, variant):
                    text, reach = _half(evaluation["trials"][title], variant)
                texts.append(text)
                reaches.append(reach)
        yield title, trial["unit"], texts, reaches


def took_part(evaluation: Mapping, title: str, variant: str) -> bool:
    """Return whether a law was in a trial, in this variant."""
    return variant in evaluation["trials"].get(title, {"half": {}})["half"]


def _half(trial: Mapping, variant: str) -> tuple[str, Reach]:
    size, curve = trial["half"][variant], trial["curves"][variant]
    if size is None:
        return f"> {curve[-1]['size']:g}", (inf, curve[-1]["share"])
    if size == curve[0]["size"]:
        return f"< {size:g}", (-inf, curve[0]["share"])
    return f"{size:.3g}", (size, 0.0)


def best(reaches: Sequence[Reach | None]) -> set[int]:
    """Return which contenders come farthest in a trial; nobody where all come equally far."""
    there = [reach for reach in reaches if reach is not None]
    if not there or min(there) == max(there):
        return set()
    return {i for i, reach in enumerate(reaches) if reach == max(there)}


def margin_rows(evaluations: Sequence[Mapping]) -> list[list[str]]:
    """Return a row for every loop of every contender."""
    return [
        [f"{evaluation['law']}, {variant}: {loop}", *_margins(margins)]
        for evaluation in evaluations
        for variant, loops in evaluation["margins"].items()
        for loop, margins in loops.items()
    ]


def _margins(margins: Mapping) -> list[str]:
    if not margins["stable"]:
        return ["unstable", "", ""]
    disk, phase, delay = (margins[key] for key in ("disk", "phase_deg", "delay_s"))
    texts = ((disk, "{:.2f}", 1), (phase, "{:.0f}", 1), (delay, "{:.1f}", 1e3))
    return ["any" if v is None else form.format(scale * v) for v, form, scale in texts]
