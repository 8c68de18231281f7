"""Many runs: by several workers, each kept as soon as it is done, and none done twice.

A study is a file and who works for it. What is to be run is a list of scenarios; what comes back is
a summary for each, in the same order:

    from lola_drake.scenario import load_scenario, override
    from lola_drake.studies.row import survived
    from lola_drake.studies.sampled_worlds import sample_world
    from lola_drake.studies.study import Study
    from lola_drake.workers import Processes

    worlds = [sample_world(load_scenario("step_down"), seed) for seed in range(100)]
    study = Study("runs/edges/runs.sqlite", Processes(2))
    summaries = study.run([override(world, {"variant": "ref"}) for world in worlds], print)
    print(sum(map(survived, summaries)), "of", len(worlds))

* A run is known by its whole scenario, by the files of the laws that this names, and by the
  software (`run_key`). So a file can be continued after any change, hold many studies, and never
  mixes what does not belong together. Scenarios that are equal are run once.
* A summary is the content of summary.json, and what came before a fall (`fall_events`). A run that
  failed has an `error` in it, and perhaps no metrics; it stops nothing. `survived` counts falls and
  errors alike.
* A scenario that cannot be run (a `LolaError`) ends the study at once: it is for its user to mend.
* Ctrl-C is a KeyboardInterrupt here; what is done by then is kept. After SIGKILL it is, too.
* Workers are `Processes(jobs)`, `inline`, or a `Cluster`, see `workers`.
* `study.store` reads what is kept: `rows`, `row`, `execute` with SQL of one's own.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from lola_drake.errors import LolaError
from lola_drake.fall_events import fall_events
from lola_drake.scenario import Scenario
from lola_drake.studies.old_lines import take_over
from lola_drake.studies.row import Summary, row_of, without_record
from lola_drake.studies.run_key import run_key
from lola_drake.studies.store import Store
from lola_drake.workers import Processes, WorkerLost, Workers

FILE = "runs.sqlite"
"""How the file of a study is called in its folder."""

Progress = Callable[[int], None]


class Study:
    """Runs in a file, and who makes those that it lacks.

    Attributes:
        store: the file.
        workers: who runs.
        failures: how many of the runs that were asked for until now ended in an error.
    """

    def __init__(self, file: str | Path, workers: Workers | None = None):
        """Open a file, which need not exist; ResultError if it cannot be used.

        Without any workers there are two processes. The lines of an old study beside a new file,
        such as runs.jsonl, are taken over into it.
        """
        self.workers, self.failures = workers or Processes(), 0
        old = Path(file).with_suffix(".jsonl")
        rows = take_over(old) if old.is_file() and not Path(file).exists() else []
        self.store = Store(file)
        if rows:
            self.store.keep(*rows)

    def run(self, scenarios: Sequence[Scenario], progress: Progress | None = None) -> list[Summary]:
        """Return the summary of every scenario; runs only those that the file lacks.

        Args:
            scenarios: what to run.
            progress: called with the number of summaries that are there.

        Raises:
            KeyboardInterrupt: If a run was interrupted; what is done by then is kept.
        """
        keys = [run_key(scenario) for scenario in scenarios]
        wanted = dict(zip(keys, scenarios, strict=True))
        known = self.store.known(wanted)
        self.store.order(len(wanted), len(known))
        missing = {key: scenario for key, scenario in wanted.items() if key not in known}
        self._run(missing, lambda done: progress and progress(len(known) + done))
        summaries = self.store.summaries(wanted)
        self.failures += sum(bool(summary["error"]) for summary in summaries.values())
        return [summaries[key] for key in keys]

    def _run(self, missing: Mapping[str, Scenario], progress: Progress) -> None:
        progress(0)
        keys, scenarios = list(missing), list(missing.values())
        kept, stopped = 0, False
        for done in self.workers(_summary, scenarios) if missing else ():
            scenario, lost = scenarios[done.index], isinstance(done.answer, WorkerLost)
            summary = without_record(scenario, str(done.answer)) if lost else done.answer
            if _interrupted(summary):
                stopped = True
                continue
            key = keys[done.index]
            self.store.keep(row_of(key, scenario, summary, done.worker, done.tries, lost=lost))
            kept += 1
            progress(kept)
        if stopped:
            raise KeyboardInterrupt


def _interrupted(summary: Summary) -> bool:
    return not (summary["completed"] or summary["fell"] or summary["error"])


def _summary(scenario: Scenario) -> Summary:
    """Return the summary of a run; of one that cannot even begin, what is wrong with it."""
    from lola_drake.simulation import simulate

    try:
        result = simulate(scenario)
        return result.summary | {"fall_events": fall_events(result)}
    except LolaError:
        raise
    except Exception as error:
        return without_record(scenario, f"{type(error).__name__}: {' '.join(str(error).split())}")
