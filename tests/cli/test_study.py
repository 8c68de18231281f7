"""lola study: looks into a study's file, and never makes or changes one."""

import csv
import json

import pytest
from made_runs import made

from lola_drake.scenario import load_scenario
from lola_drake.studies.store import Store


@pytest.fixture
def study(lola, tmp_path):
    """Return the folder of a study with a run in the world of seed 7, and one that fell."""
    stand = load_scenario("stand", {"seed": 7, "ground.friction": 0.7})
    store = Store(tmp_path / "runs.sqlite")
    store.order(wanted=9, there=0)
    store.keep(made(7, stand), made(8, completed=False, fell=True, fall_time_s=2.5))
    return str(tmp_path)


def test_status_says_how_far_it_is(lola, study):
    done = lola("study", "status", study)
    assert "2 runs: 1 completed, 1 fell" in done.stdout and "2 of 9 done" in done.stdout
    assert json.loads(lola("study", "status", study, "--json").stdout)["runs"] == 2


def test_show_lists_the_last_runs(lola, study):
    (run,) = json.loads(lola("study", "show", study, "--rows", "1", "--json").stdout)
    assert (run["seed"], run["outcome"], run["fall_time_s"]) == (8, "fell", 2.5)
    lines = lola("study", "show", study).stdout
    assert "completed" in lines and "fell at 2.50 s" in lines
    assert "lola study replay" in lines
    (run,) = json.loads(lola("study", "show", study, "--worst", "--rows", "1", "--json").stdout)
    assert run["seed"] == 8
    assert json.loads(lola("study", "show", study, "--outcome", "lost", "--json").stdout) == []


def test_export_writes_a_table(lola, study, tmp_path):
    assert "2 runs written" in lola("study", "export", study, "-o", "all.csv").stdout
    with (tmp_path / "all.csv").open() as file:
        assert [line["seed"] for line in csv.DictReader(file)] == ["7", "8"]
    done = lola("study", "export", study, "-o", "all.csv")
    assert done.exit_code == 2 and "is there already" in done.stderr


def test_replay_simulates_a_run_again(lola, study, tmp_path):
    assert lola("study", "replay", study, "1").exit_code == 0
    assert lola.runs == [load_scenario("stand", {"seed": 7, "ground.friction": 0.7})]
    assert (tmp_path / "runs" / "stand_1" / "signals.h5").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["status", "gone.sqlite"], "gone.sqlite: no such study"),
        (["replay", ".", "5"], "has no run 5"),
        (["show", ".", "--outcome", "sat"], "there are completed, fell, failed, lost"),
        (["export", ".", "-o", "all.doc"], "must end with .csv or .parquet"),
    ],
)
def test_what_cannot_be_done_is_one_line(lola, study, tmp_path, arguments, message):
    before = set(tmp_path.iterdir())
    done = lola("study", *arguments)
    assert done.exit_code == 2 and message in done.stderr and done.stderr.count("\n") == 1
    assert set(tmp_path.iterdir()) == before
