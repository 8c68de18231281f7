"""Many runs: in parallel, each kept on disk as soon as it is done, and none done twice."""

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from lola_drake.atomic_file import write_json as write_json
from lola_drake.paths import models_dir
from lola_drake.results import ResultError, software_versions
from lola_drake.scenario import Scenario, differences, dump_scenario
from lola_drake.studies.workers import WorkerLost, each_done

Summary = dict[str, object]

ABOVE_THE_SIMULATION = (
    "benchmarks",
    "cli",
    "diagram",
    "figures",
    "linear",
    "reports",
    "studies",
    "view3d",
)
"""Folders of the package that no run's numbers depend on."""


class Study:
    """The summaries of runs, in a file with one line for each.

    A run is known by its whole scenario and by the software that it depends on, so that a file can
    be continued after any change and never mixes what does not belong together.
    """

    def __init__(self, file: str | Path):
        """Open a file, which need not exist; ResultError if it cannot be used."""
        self.file = Path(file)
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            text = self.file.read_text(encoding="utf-8") if self.file.exists() else ""
            whole = text[: text.rfind("\n") + 1]
            if whole != text or not text:
                # A study that was killed while it wrote leaves a part of a line.
                self.file.write_text(whole, encoding="utf-8")
            records = [json.loads(line) for line in whole.splitlines()]
            self._known = {record["key"]: record["summary"] for record in records}
        except OSError as error:
            raise ResultError(f"{self.file}: cannot be used, {error.strerror}") from None
        except (ValueError, KeyError, TypeError):
            raise ResultError(f"{self.file}: holds something that is not a study") from None

    def run(
        self,
        scenarios: Sequence[Scenario],
        jobs: int = 2,
        progress: Callable[[int], None] | None = None,
    ) -> list[Summary]:
        """Return the summary of every scenario; runs only those that the file lacks.

        Args:
            scenarios: what to run.
            jobs: how many processes run at a time.
            progress: called with the number of summaries that are there.

        Raises:
            KeyboardInterrupt: If a run was interrupted; what is done by then is kept.
            ResultError: If the process of a run was killed; all others are done and kept.
        """
        keys = [run_key(scenario) for scenario in scenarios]
        missing = {k: s for k, s in zip(keys, scenarios, strict=True) if k not in self._known}
        report = progress or (lambda done: None)
        done = len(set(keys)) - len(missing)
        report(done)
        lost = 0
        for i, summary in each_done(_summary, list(missing.values()), jobs):
            if isinstance(summary, WorkerLost):
                lost += 1
                continue
            key = list(missing)[i]
            self._keep(key, missing[key], summary)
            done += 1
            report(done)
        if lost:
            kept = f"{len(self._known)} are kept in {self.file}, start again"
            raise ResultError(f"{lost} runs were lost, their processes were killed; {kept}")
        return [self._known[key] for key in keys]

    def _keep(self, key: str, scenario: Scenario, summary: Summary) -> None:
        if summary["error"]:
            raise ResultError(f"{scenario.name}, seed {scenario.seed}: {summary['error']}")
        if not (summary["completed"] or summary["fell"]):
            raise KeyboardInterrupt
        record = {"key": key, "scenario": differences(scenario), "summary": summary}
        with self.file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record, allow_nan=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
        self._known[key] = summary


def _summary(scenario: Scenario) -> Summary:
    from lola_drake.simulation import simulate

    return simulate(scenario).summary


def run_key(scenario: Scenario) -> str:
    """Return what a run is known by: a digest of its scenario and of the software."""
    return hashlib.sha256((software_digest() + dump_scenario(scenario)).encode()).hexdigest()


@cache
def software_digest() -> str:
    """Return a digest of everything but the scenario that a run's numbers depend on.

    It covers the package up to the simulation, the robot, and the versions of what they use.
    """
    package, robot = Path(__file__).resolve().parents[1], models_dir() / "lola"
    sources = [
        path
        for path in package.rglob("*.py")
        if path.relative_to(package).parts[0] not in ABOVE_THE_SIMULATION
    ]
    digest = hashlib.sha256(json.dumps(software_versions(), sort_keys=True).encode())
    for path in sorted([*sources, *robot.glob("*.urdf")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()
