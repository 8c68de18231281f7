"""Tables of all runs: every number is where its name says."""

import csv
import sys

import pytest
from made_runs import made

from lola_drake.errors import OutputError
from lola_drake.scenario import Scenario, override
from lola_drake.studies.export import export
from lola_drake.studies.store import Store


@pytest.fixture
def store(tmp_path):
    """Return a store with a run that fell on other ground, one that failed, and another."""
    store = Store(tmp_path / "runs.sqlite")
    board = override(Scenario(seed=1), {"ground.friction": 0.7, "walk.steps": [{"count": 2}]})
    store.keep(
        made(1, board, completed=False, fell=True, fall_time_s=2.5),
        made(2, error="no number, any more", completed=False),
        made(3, max_slip_m=0.25),
    )
    return store


def test_csv_has_a_line_for_each_run(store, tmp_path):
    assert export(store, tmp_path / "runs.csv") == 3
    with (tmp_path / "runs.csv").open(newline="") as file:
        first, second, third = csv.DictReader(file)
    assert (first["run"], first["outcome"], first["fall_time_s"]) == ("1", "fell", "2.5")
    assert first["max_inclination_deg.y"] == "0.1" and third["max_inclination_deg.y"] == "0.3"
    assert first["scenario.ground.friction"] == "0.7" and third["scenario.ground.friction"] == ""
    assert '"count": 2' in first["scenario.walk.steps"]
    assert second["error"] == "no number, any more"
    assert (first["max_slip_m"], third["max_slip_m"]) == ("", "0.25")


def test_parquet_has_the_same_with_types(store, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    assert export(store, tmp_path / "runs.parquet") == 3
    table = parquet.read_table(tmp_path / "runs.parquet").to_pydict()
    assert table["run"] == [1, 2, 3]
    assert table["fell"] == [True, False, False]
    assert table["fall_time_s"] == [2.5, None, None]
    assert table["max_slip_m"] == [None, None, 0.25]
    assert table["scenario.seed"] == [1, 2, 3]


def test_a_study_without_runs_is_a_table_without_lines(tmp_path):
    assert export(Store(tmp_path / "runs.sqlite"), tmp_path / "runs.csv") == 0
    assert (tmp_path / "runs.csv").read_text().count("\n") == 1


def test_another_kind_of_file_is_refused(store, tmp_path):
    with pytest.raises(OutputError, match=r"must end with \.csv or \.parquet"):
        export(store, tmp_path / "runs.xlsx")


def test_without_its_package_parquet_says_what_to_install(store, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(OutputError, match=r"pip install 'lola_drake\[parquet\]'"):
        export(store, tmp_path / "runs.parquet")
    assert not (tmp_path / "runs.parquet").exists()
