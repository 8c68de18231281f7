"""The file of a study: whole, readable while it is written, refused where it is another's."""

import dataclasses
import json
import sqlite3

import pytest
from made_runs import made

from lola_drake.results import ResultError
from lola_drake.scenario import Scenario
from lola_drake.studies.status import listed_runs, status
from lola_drake.studies.store import VERSION, Store


@pytest.fixture
def file(tmp_path):
    return tmp_path / "runs.sqlite"


def test_what_is_kept_is_read_again(file):
    rows = [made(1), made(2, fell=True, completed=False, fall_time_s=3.5)]
    Store(file).keep(*rows)
    found = list(Store(file).rows())
    assert [dataclasses.replace(row, number=0) for row in found] == rows
    assert [row.number for row in found] == [1, 2]
    assert Store(file).row(2) == found[1]
    assert Store(file).summaries(["key 2", "key 7"]) == {"key 2": rows[1].summary}
    with pytest.raises(ResultError, match="has no run 3"):
        Store(file).row(3)


def test_all_of_some_runs_or_none(file):
    store = Store(file)
    broken = made(2, max_slip_m=float("nan"))
    with pytest.raises(ValueError, match="JSON"):
        store.keep(made(1), broken)
    assert store.known(["key 1"]) == set()


def test_a_run_is_kept_once(file):
    """Whoever comes second, such as another process with the same study, changes nothing."""
    first, second = Store(file), Store(file)
    first.keep(made(1))
    second.keep(made(1, wall_time_s=9.0), made(2))
    assert [row.summary["wall_time_s"] for row in first.rows()] == [2.0, 2.0]


def test_one_may_read_while_another_writes(file):
    writer, reader = Store(file), Store(file, must_exist=True)
    writer.keep(made(1))
    with writer.transaction():
        writer._insert(made(2))
        assert [row.number for row in reader.rows()] == [1]
    assert [row.number for row in reader.rows()] == [1, 2]


def test_what_a_killed_process_had_not_finished_is_gone(file):
    """A copy of database and journal in the middle of a transaction is what SIGKILL leaves."""
    store = Store(file)
    store.keep(made(1))
    store._database.execute("PRAGMA cache_size = 1")
    store._database.execute("PRAGMA cache_spill = 1")
    copy = file.with_name("copy.sqlite")
    with store.transaction():
        for seed in range(2, 300):
            store._insert(made(seed))
        journal = file.with_name("runs.sqlite-journal")
        copy.write_bytes(file.read_bytes())
        copy.with_name("copy.sqlite-journal").write_bytes(journal.read_bytes())
    assert [row.number for row in Store(copy).rows()] == [1]
    assert len(list(Store(file).rows())) == 299


def test_a_scenario_is_kept_whole_even_when_the_defaults_change(file):
    row = made(4)
    defaults = dict(row.defaults) | {"duration": 77.0}
    Store(file).keep(dataclasses.replace(row, software="older", defaults=defaults))
    assert Store(file).row(1).scenario() == Scenario(seed=4, duration=77.0)


def test_a_run_of_software_that_knew_other_keys_is_said(file):
    row = dataclasses.replace(made(4), changes={"control.magic": 3})
    Store(file).keep(row)
    with pytest.raises(ResultError, match="run 1 is of other software: control.magic"):
        Store(file).row(1).scenario()


def test_a_study_of_another_version_is_refused(file):
    Store(file).keep(made(1))
    with sqlite3.connect(file) as database:
        database.execute(f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(ResultError, match=rf"version {VERSION + 1}.* version {VERSION} alone"):
        Store(file)


def test_somebody_elses_database_is_refused_and_left_alone(file):
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE letters (text)")
    before = file.read_bytes()
    with pytest.raises(ResultError, match="not a study"):
        Store(file)
    assert file.read_bytes() == before


def test_a_study_that_is_not_there_is_not_made_by_looking_at_it(file):
    with pytest.raises(ResultError, match="no such study"):
        Store(file, must_exist=True)
    assert not file.exists()


def test_status_counts_ends_and_what_is_left(file):
    store = Store(file)
    assert status(store)["runs"] == 0
    store.keep(made(1))
    store.order(wanted=5, there=1)
    store.keep(made(2, fell=True, completed=False), made(3, error="no number", completed=False))
    found = status(store)
    assert found["outcomes"] == {"completed": 1, "fell": 1, "failed": 1, "lost": 0}
    assert (found["last_order"]["wanted"], found["last_order"]["done"]) == (5, 3)
    json.dumps(found)


def test_the_last_runs_come_first_and_may_be_chosen_by_their_end(file):
    store = Store(file)
    store.keep(made(1, fell=True, completed=False), *map(made, range(2, 6)))
    assert [run["seed"] for run in listed_runs(store, 3)] == [5, 4, 3]
    assert [run["seed"] for run in listed_runs(store, 3, "fell")] == [1]
    with pytest.raises(ResultError, match="outcome: 'sat', there are completed, fell"):
        listed_runs(store, 3, "sat")


def test_the_worst_runs_failed_or_fell_early_or_inclined_most(file):
    store = Store(file)
    fallen = {"completed": False, "fell": True}
    store.keep(
        made(1),
        made(2, **fallen, fall_time_s=5.0),
        made(3, error="no number", completed=False),
        made(30),
        made(4, **fallen, fall_time_s=2.0),
    )
    worst = listed_runs(store, 5, worst=True)
    assert [run["seed"] for run in worst] == [3, 4, 2, 30, 1]
    assert worst[0]["command"] == f"lola study replay {file} 3"


def test_a_full_disk_is_said_and_costs_no_run_that_is_kept(file):
    store = Store(file)
    store.keep(made(1))
    pages = store.execute("PRAGMA page_count").fetchone()[0]
    store.execute(f"PRAGMA max_page_count = {pages + 2}")
    with pytest.raises(
        ResultError, match=r"runs\.sqlite: cannot be used, database or disk is full"
    ):
        store.keep(*map(made, range(2, 99)))
    assert [row.number for row in Store(file).rows()] == [1]
