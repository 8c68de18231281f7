"""Studies: what is done is kept, what belongs to other software or scenarios is not used."""

import json
import sys
import types

import pytest

from lola_drake.results import ResultError
from lola_drake.scenario import Scenario
from lola_drake.studies import study as study_module
from lola_drake.studies.study import Study, run_key
from lola_drake.studies.workers import WorkerLost


@pytest.fixture
def simulated(make_result, monkeypatch):
    """Return the seeds that were run, in place of simulations; seed 13 is interrupted."""
    seeds = []

    def simulate(scenario):
        seeds.append(scenario.seed)
        interrupted = {"completed": False} if scenario.seed == 13 else {}
        return make_result(scenario, steps=1, **interrupted)

    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)
    return seeds


def scenarios(*seeds):
    return [Scenario(seed=seed) for seed in seeds]


def test_summaries_are_in_the_order_of_the_scenarios(tmp_path, simulated):
    summaries = Study(tmp_path / "deep" / "runs.jsonl").run(scenarios(3, 1, 2), jobs=1)
    assert [summary["seed"] for summary in summaries] == [3, 1, 2]
    assert simulated == [3, 1, 2]


def test_nothing_is_run_twice(tmp_path, simulated):
    file = tmp_path / "runs.jsonl"
    first = Study(file).run(scenarios(1, 2, 1), jobs=1)
    again = Study(file).run(scenarios(2, 1, 4), jobs=1)
    assert simulated == [1, 2, 4]
    assert again[:2] == first[1::-1]


def test_progress_counts_what_is_there(tmp_path, simulated):
    counts = []
    study = Study(tmp_path / "runs.jsonl")
    study.run(scenarios(1), jobs=1)
    study.run(scenarios(1, 2, 3), jobs=1, progress=counts.append)
    assert counts == [1, 2, 3]


def test_an_interrupted_study_keeps_what_is_done(tmp_path, simulated):
    file = tmp_path / "runs.jsonl"
    with pytest.raises(KeyboardInterrupt):
        Study(file).run(scenarios(1, 13, 2), jobs=1)
    assert len(file.read_text().splitlines()) == 1
    Study(file).run(scenarios(1, 2), jobs=1)
    assert simulated == [1, 13, 2]


def test_a_half_written_line_is_forgotten(tmp_path, simulated):
    file = tmp_path / "runs.jsonl"
    Study(file).run(scenarios(1, 2), jobs=1)
    file.write_text(file.read_text()[:-40])
    Study(file).run(scenarios(1, 2), jobs=1)
    assert simulated == [1, 2, 2]
    assert [s["seed"] for s in Study(file).run(scenarios(1, 2), jobs=1)] == [1, 2]
    assert simulated == [1, 2, 2]


def test_a_line_says_what_was_run(tmp_path, simulated):
    file = tmp_path / "runs.jsonl"
    Study(file).run(scenarios(5), jobs=1)
    record = json.loads(file.read_text())
    assert record["scenario"] == {"seed": 5}
    assert record["summary"]["seed"] == 5


def test_other_software_is_another_run(monkeypatch):
    before = run_key(Scenario())
    assert run_key(Scenario()) == before
    assert run_key(Scenario(seed=1)) != before
    monkeypatch.setattr(study_module, "software_digest", lambda: "later")
    assert run_key(Scenario()) != before


def test_a_file_that_cannot_be_used_is_said(tmp_path):
    with pytest.raises(ResultError, match="cannot be used, Is a directory"):
        Study(tmp_path)
    other = tmp_path / "other.txt"
    other.write_text("something else\n")
    with pytest.raises(ResultError, match="not a study"):
        Study(other)
    assert other.read_text() == "something else\n"


def test_a_killed_process_costs_its_own_run_alone(tmp_path, simulated, monkeypatch):
    def each_done(function, items, jobs):
        for i, scenario in enumerate(items):
            yield i, WorkerLost("killed") if scenario.seed == 2 else function(scenario)

    monkeypatch.setattr(study_module, "each_done", each_done)
    file = tmp_path / "runs.jsonl"
    with pytest.raises(ResultError, match=r"1 runs were lost.*2 are kept in .*, start again"):
        Study(file).run(scenarios(1, 2, 3))
    monkeypatch.undo()
    assert len(file.read_text().splitlines()) == 2
