"""Studies: what is done is kept, what belongs to other software or scenarios is not used."""

import sys
import types

import pytest

from lola_drake.interruption import HEARD
from lola_drake.results import ResultError
from lola_drake.scenario import OwnLaw, Scenario, ScenarioError
from lola_drake.studies import run_key as run_key_module
from lola_drake.studies.row import survived
from lola_drake.studies.run_key import run_key
from lola_drake.studies.study import Study
from lola_drake.workers import Done, WorkerLost, inline


@pytest.fixture
def simulated(make_result, monkeypatch):
    """Return the seeds that were run, in place of simulations.

    Seed 13 is interrupted, 14 fails in its run, 15 before it, and 16 is nothing that can be run.
    """
    seeds = []

    def simulate(scenario):
        seeds.append(scenario.seed)
        if scenario.seed == 13:
            HEARD.set()
            return make_result(scenario, steps=1, completed=False)
        if scenario.seed == 14:
            return make_result(scenario, steps=1, completed=False, error="no number any more")
        if scenario.seed == 15:
            raise RuntimeError("no such\nmesh")
        if scenario.seed == 16:
            raise ScenarioError("no such law")
        return make_result(scenario, steps=1)

    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)
    return seeds


@pytest.fixture
def file(tmp_path):
    return tmp_path / "deep" / "runs.sqlite"


def scenarios(*seeds):
    return [Scenario(seed=seed) for seed in seeds]


def test_summaries_are_in_the_order_of_the_scenarios(file, simulated):
    summaries = Study(file, inline).run(scenarios(3, 1, 2))
    assert [summary["seed"] for summary in summaries] == [3, 1, 2]
    assert simulated == [3, 1, 2]


def test_a_summary_is_the_same_from_the_run_and_from_the_file(file, simulated, make_result):
    (summary,) = Study(file, inline).run(scenarios(3))
    assert summary == make_result(Scenario(seed=3), steps=1).summary | {"fall_events": []}
    assert Study(file, inline).run(scenarios(3)) == [summary]


def test_nothing_is_run_twice(file, simulated):
    first = Study(file, inline).run(scenarios(1, 2, 1))
    again = Study(file, inline).run(scenarios(2, 1, 4))
    assert simulated == [1, 2, 4]
    assert again[:2] == first[1::-1]


def test_progress_counts_what_is_there(file, simulated):
    counts = []
    study = Study(file, inline)
    study.run(scenarios(1))
    study.run(scenarios(1, 2, 3), progress=counts.append)
    assert counts == [1, 2, 3]


def test_an_interrupted_study_keeps_what_is_done(file, simulated):
    with pytest.raises(KeyboardInterrupt):
        Study(file, inline).run(scenarios(1, 13, 2))
    assert [row.summary["seed"] for row in Study(file).store.rows()] == [1]
    Study(file, inline).run(scenarios(1, 2))
    assert simulated == [1, 13, 2]


def test_after_an_interruption_what_others_had_completed_is_kept(file, simulated):
    def crew(function, items):
        yield from (Done(i, function(item), "a@b") for i, item in enumerate(items))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Study(file, crew).run(scenarios(13, 1))
    assert [row.summary["seed"] for row in Study(file).store.rows()] == [1]


def test_a_run_that_fails_stops_nothing_and_is_not_repeated(file, simulated):
    study = Study(file, inline)
    summaries = study.run(scenarios(14, 15, 1))
    assert [summary["error"] for summary in summaries] == [
        "no number any more",
        "RuntimeError: no such mesh",
        None,
    ]
    assert [survived(summary) for summary in summaries] == [False, False, True]
    assert study.failures == 2
    assert [row.outcome for row in study.store.rows()] == ["failed", "failed", "completed"]
    study.run(scenarios(14, 15, 1))
    assert simulated == [14, 15, 1]


def test_what_cannot_be_run_ends_the_study_at_once(file, simulated):
    with pytest.raises(ScenarioError, match="no such law"):
        Study(file, inline).run(scenarios(1, 16, 2))
    assert simulated == [1, 16]


def test_a_run_whose_process_is_lost_stops_nothing_and_is_repeated(file, simulated):
    def crew(function, items):
        for i, scenario in enumerate(items):
            lost = scenario.seed == 2
            yield Done(i, WorkerLost("killed") if lost else function(scenario), "a@b", 1 + 2 * lost)

    study = Study(file, crew)
    assert [summary["error"] for summary in study.run(scenarios(1, 2, 3))] == [None, "killed", None]
    rows = {row.summary["seed"]: row for row in study.store.rows()}
    assert (rows[2].outcome, rows[2].tries, rows[2].worker) == ("lost", 3, "a@b")
    summaries = Study(file, inline).run(scenarios(1, 2, 3))
    assert [summary["error"] for summary in summaries] == [None] * 3
    assert simulated == [1, 3, 2]
    assert [row.outcome for row in study.store.rows()] == ["completed"] * 3


def test_a_row_says_what_was_run(file, simulated):
    study = Study(file, inline)
    study.run(scenarios(5))
    (row,) = study.store.rows()
    assert row.changes == {"seed": 5}
    assert row.scenario() == Scenario(seed=5)
    assert row.summary["seed"] == 5 and row.tries == 1 and "@" in row.worker


def test_other_software_is_another_run(monkeypatch):
    before = run_key(Scenario())
    assert run_key(Scenario()) == before
    assert run_key(Scenario(seed=1)) != before
    monkeypatch.setattr(run_key_module, "software_digest", lambda: "later")
    assert run_key(Scenario()) != before


def test_a_law_that_has_changed_is_another_run(tmp_path):
    law = tmp_path / "law.py"
    scenario = Scenario(blocks=(OwnLaw("imu_stabilizer", f"{law}:Mine"),))
    keys = []
    for text in ("a = 1", "a = 2", "a = 1"):
        law.write_text(text)
        keys.append(run_key(scenario))
    assert keys[0] == keys[2] != keys[1]


def test_a_key_tells_any_two_numbers_apart():
    """They go into it with all their digits."""
    near = Scenario(duration=1.0), Scenario(duration=1.0 + 2**-52)
    beside = Scenario(duration=1.0, seed=11), Scenario(duration=1.01, seed=1)
    assert len(set(map(run_key, (*near, *beside)))) == 4


def test_a_key_does_not_depend_on_what_was_asked_before():
    scenario = Scenario(duration=10.0, seed=10)
    before = run_key(scenario)
    run_key_module._line.cache_clear()
    run_key_module._line(10.0), run_key_module._line(10)
    assert run_key(scenario) == before


def test_a_file_that_cannot_be_used_is_said(tmp_path):
    with pytest.raises(ResultError, match="cannot be used"):
        Study(tmp_path)
    other = tmp_path / "other.txt"
    other.write_text("something else\n" * 100)
    with pytest.raises(ResultError, match="not a study"):
        Study(other)
    assert other.read_text().startswith("something else\n")
