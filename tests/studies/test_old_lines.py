"""Studies of version 0.1 are taken over: nothing is lost, and nothing is mixed."""

import hashlib
import json
import sys
import types

import pytest

from lola_drake.results import ResultError
from lola_drake.scenario import Scenario, differences, dump_scenario
from lola_drake.studies.run_key import software_digest
from lola_drake.studies.study import Study
from lola_drake.workers import inline


def line(scenario, summary, software):
    """Return a line as version 0.1 wrote it."""
    key = hashlib.sha256((software + dump_scenario(scenario)).encode()).hexdigest()
    return json.dumps({"key": key, "scenario": differences(scenario), "summary": summary}) + "\n"


@pytest.fixture
def old(tmp_path, make_result):
    """Write an old study: seed 1 of today's software, seed 2 of other, and a half-written line."""
    lines = [
        line(scenario, make_result(scenario, steps=1).summary, software)
        for scenario, software in (
            (Scenario(seed=1), software_digest()),
            (Scenario(seed=2), "another"),
        )
    ]
    file = tmp_path / "runs.jsonl"
    file.write_text("".join(lines) + lines[0][:50])
    return file


@pytest.fixture
def simulated(make_result, monkeypatch):
    seeds = []

    def simulate(scenario):
        seeds.append(scenario.seed)
        return make_result(scenario, steps=1)

    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)
    return seeds


def test_runs_of_todays_software_are_not_run_again_and_others_are(old, simulated):
    before = old.read_text()
    study = Study(old.with_suffix(".sqlite"), inline)
    assert [row.summary["seed"] for row in study.store.rows()] == [1, 2]
    study.run([Scenario(seed=1), Scenario(seed=2)])
    assert simulated == [2]
    assert [row.summary["seed"] for row in study.store.rows()] == [1, 2, 2]
    assert old.read_text() == before


def test_an_old_study_is_taken_over_once(old, simulated):
    for _ in range(2):
        study = Study(old.with_suffix(".sqlite"), inline)
    assert len(list(study.store.rows())) == 2


def test_lines_that_are_no_study_are_said(tmp_path):
    (tmp_path / "runs.jsonl").write_text('{"letter": "dear"}\n')
    with pytest.raises(ResultError, match=r"runs\.jsonl: holds something that is not a study"):
        Study(tmp_path / "runs.sqlite")
    assert not (tmp_path / "runs.sqlite").exists()
