"""The evaluations of laws that come with the package, and what the docs say of them."""

import json
from pathlib import Path

import pytest

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.paths import arena_records
from lola_drake.studies.arena import FIRST_SEED, TRIALS
from lola_drake.studies.ranking import evaluation_table, half_rows, load_evaluation

DOCS = Path(__file__).resolve().parents[1] / "docs"
KEPT = {record["law"]: record for record in map(load_evaluation, arena_records())}
PUSHES = json.loads((DOCS / "experiments/pushes.json").read_text(encoding="utf-8"))["evaluations"]
COMPARED = ("edge", "board", "slope", "stairs", "push")
"""How the trials begin in which all laws have been."""


def rows_of(first_cell):
    """Return the rows of the table in docs/laws.md that begins so, as lists of cells."""
    lines = (DOCS / "laws.md").read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(f"| {first_cell}"))
    end = next(k for k in range(start, len(lines)) if not lines[k].startswith("|"))
    rows = [line.strip("| ").split(" | ") for line in lines[start:end]]
    return [[cell.strip() for cell in row] for row in rows[:1] + rows[2:]]


def test_every_law_of_the_package_has_been_in_the_arena():
    assert set(KEPT) == set(FORCE_LAWS)
    assert {record["worlds"] for record in KEPT.values()} == {4}
    assert {record["first_seed"] for record in KEPT.values()} == {FIRST_SEED}
    assert set(KEPT["hybrid"]["trials"]) == {trial.title for trial in TRIALS}
    compared = {trial.title for trial in TRIALS if trial.title.startswith(COMPARED)}
    assert all(compared <= set(record["trials"]) for record in KEPT.values())
    assert evaluation_table([KEPT["hybrid"]]).row_count == len(TRIALS) + 2


@pytest.mark.parametrize("record", [*KEPT.values(), *PUSHES], ids=lambda record: record["law"])
def test_what_is_kept_are_sizes_of_todays_trials(record):
    sizes = {trial.title: set(trial.sizes) for trial in TRIALS}
    for title, trial in record["trials"].items():
        for curve in trial["curves"].values():
            assert {point["size"] for point in curve} <= sizes[title]


def test_the_table_of_the_arena_is_its_records():
    (_, *laws), *rows = rows_of("trial, without")
    records = [KEPT[law.strip("`")] for law in laws]
    assert len(records) == len(FORCE_LAWS)
    found = {row[0]: row[1:] for row in rows}
    for title, unit, texts, _ in half_rows([KEPT["hybrid"], *records]):
        if not title.startswith("push"):
            pairs = zip(texts[2::2], texts[3::2], strict=True)
            assert found.pop(f"{title} ({unit})") == [
                " → ".join(filter(None, pair)) or "–" for pair in pairs
            ]
    disks = [
        " → ".join(f"{record['margins'][v]['force_loop']['disk']:.2f}" for v in ("ref", "dyn"))
        for record in records
    ]
    assert found == {"disk margin of the force loop on one foot": disks}


def test_the_table_of_pushes_is_its_record():
    (_, *laws), *rows = rows_of("push (Ns)")
    for law, (plain, adapted) in zip(
        laws, zip(PUSHES[::2], PUSHES[1::2], strict=True), strict=True
    ):
        assert plain["law"] == law.strip("`")
        assert adapted["law"] == f"{plain['law']} pattern.step_adaptation=true"
    for row, (title, _, texts, _) in zip(rows, half_rows(PUSHES), strict=True):
        assert f"push, {row[0]}" == title
        assert row[1:] == [" → ".join(pair) for pair in zip(texts[::2], texts[1::2], strict=True)]


@pytest.mark.parametrize("direction", [0.0, 180.0])
def test_step_adaptation_bears_a_third_more_forward_and_backward(direction):
    for plain, adapted in zip(PUSHES[::2], PUSHES[1::2], strict=True):
        halves = [
            record["trials"][f"push, {direction:g}°"]["half"]["dyn"] for record in (plain, adapted)
        ]
        assert halves[1] is None or halves[1] > 1.3 * halves[0]
