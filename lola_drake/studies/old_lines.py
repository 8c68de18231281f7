"""Studies of version 0.1, which kept a line of JSON for each run: taken over into a new file."""

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

from lola_drake.errors import ResultError
from lola_drake.scenario import Scenario, ScenarioError, dump_scenario, override
from lola_drake.studies.row import Row, default_scenario, outcome
from lola_drake.studies.run_key import run_key, software_digest


def take_over(file: Path) -> list[Row]:
    """Return the runs of an old study; ResultError if it is none.

    A run of today's software is known by its scenario from now on, and not run again. Of any other
    the software is known by its versions alone, so it is there to be read.
    """
    try:
        return list(_rows(file.read_text(encoding="utf-8")))
    except OSError as error:
        raise ResultError(f"{file}: cannot be read, {error.strerror}") from None
    except (ValueError, LookupError, TypeError, AttributeError):
        raise ResultError(f"{file}: holds something that is not a study") from None


def _rows(text: str) -> Iterator[Row]:
    # A study that was killed while it wrote has left a part of a line.
    for line in text[: text.rfind("\n") + 1].splitlines():
        record = json.loads(line)
        old_key, changes, summary = record["key"], record["scenario"], record["summary"]
        scenario = _todays(old_key, changes)
        versions = summary["versions"]
        digest = f"versions {json.dumps(versions, sort_keys=True)}"
        yield Row(
            key=run_key(scenario) if scenario else f"old {old_key}",
            software=software_digest() if scenario else digest,
            versions=versions,
            defaults=default_scenario(),
            changes=changes,
            outcome=outcome(summary),
            summary=summary,
            worker="",
            tries=1,
            finished="",
        )


def _todays(old_key: str, changes: dict[str, object]) -> Scenario | None:
    """Return the scenario of a run if its old key is the one that today's software gives it."""
    try:
        scenario = override(Scenario(), changes)
    except ScenarioError:
        return None
    text = software_digest() + dump_scenario(scenario)
    return scenario if hashlib.sha256(text.encode()).hexdigest() == old_key else None
