"""One run of a study, as it is kept."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from typing import Any

from lola_drake import typed_yaml
from lola_drake.errors import ResultError
from lola_drake.results import software_versions
from lola_drake.scenario import Scenario, differences
from lola_drake.studies.run_key import software_digest

Summary = Mapping[str, Any]
"""The content of summary.json; of a run that left no record what `without_record` gives."""

LOST = "lost"

OUTCOMES = ("completed", "fell", "failed", LOST)
"""How a run ends. One that failed has an `error` in its summary, the same whenever it is run. One
that was lost had its process ended from outside, again and again; it is run once more with its
study."""


@dataclass(frozen=True)
class Row:
    """A run and what came of it.

    Attributes:
        key: what the run is known by, see `run_key`.
        software: digest of the software, see `software_digest`.
        versions: of the software.
        defaults: a whole scenario of that software, as plain data.
        changes: what the run's scenario changes of it, by dotted keys.
        outcome: one of `OUTCOMES`.
        summary: of the run.
        worker: where it was run: process@machine.
        tries: how often it was begun.
        finished: when, in UTC as ISO 8601.
        number: of the row in its file, from 1 on; 0 before it is kept.
    """

    key: str
    software: str
    versions: Mapping[str, str]
    defaults: Mapping[str, object]
    changes: Mapping[str, object]
    outcome: str
    summary: Summary
    worker: str
    tries: int
    finished: str
    number: int = 0

    def scenario(self) -> Scenario:
        """Return the whole scenario.

        Raises:
            ResultError: If it is of other software, and this one does not know all of it.
        """
        whole = copy.deepcopy(dict(self.defaults))
        try:
            for key, value in self.changes.items():
                typed_yaml.set_at(whole, key, value)
            return typed_yaml.build(Scenario, whole)
        except ValueError as error:
            raise ResultError(f"run {self.number} is of other software: {error}") from None


def row_of(
    key: str, scenario: Scenario, summary: Summary, worker: str, tries: int, *, lost: bool = False
) -> Row:
    """Return the row of a run that today's software has made, or lost, just now."""
    return Row(
        key=key,
        software=software_digest(),
        versions=software_versions(),
        defaults=default_scenario(),
        changes=differences(scenario),
        outcome=LOST if lost else outcome(summary),
        summary=summary,
        worker=worker,
        tries=tries,
        finished=datetime.now(UTC).isoformat(timespec="seconds"),
    )


def without_record(scenario: Scenario, error: str) -> Summary:
    """Return the summary of a run of which nothing is known but why."""
    return {
        "scenario": scenario.name,
        "variant": scenario.variant,
        "seed": scenario.seed,
        "completed": False,
        "fell": False,
        "fall_time_s": None,
        "error": error,
    }


def outcome(summary: Mapping[str, object]) -> str:
    """Return how a run ended that was not interrupted."""
    if summary["error"]:
        return "failed"
    return "fell" if summary["fell"] else "completed"


def survived(summary: Mapping[str, object]) -> bool:
    """Return whether a run came to its end: without a fall, and without an error."""
    return not (summary["fell"] or summary.get("error"))


@cache
def default_scenario() -> Mapping[str, object]:
    """Return the defaults of today's software as plain data."""
    return typed_yaml.plain(Scenario())
