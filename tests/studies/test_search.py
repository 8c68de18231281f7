"""A search finds the least of a known function, and goes on wherever it was ended."""

import sys

import pytest

from lola_drake.scenario import ScenarioError
from lola_drake.studies.search import (
    Range,
    Score,
    Search,
    SearchError,
    Trial,
    along_axes,
    search,
)
from lola_drake.studies.store import Store

RANGES = {"a": Range(0.0, 0.1, 30, 30), "b": Range(0.0, 0.1, 40, 20)}
START = {"a": 0.0, "b": 0.0}


def valley(values):
    """Return a score that is least at a = 1.3, b = -2."""
    return Score(0, 0, (values["a"] - 1.3) ** 2 + 0.5 * (values["b"] + 2.0) ** 2)


def searched(file=None, budget=40, evaluate=valley):
    return search(file, "a search", evaluate, RANGES, budget)


def test_it_finds_the_least_and_begins_where_it_is_told():
    found = searched()
    assert found.trials[0] == Trial(START, valley(START))
    assert len(found.trials) == 40
    assert found.best().values == pytest.approx({"a": 1.3, "b": -2.0}, abs=0.2)
    for trial in found.trials:
        assert all(at.low <= trial.values[key] <= at.high for key, at in RANGES.items())


def test_along_the_axes_it_finds_the_least_and_comes_to_its_end():
    ranges, scores = list(RANGES.values()), {}
    while (there := along_axes(scores, ranges)) is not None:
        assert there not in scores
        scores[there] = (there[0] - 13) ** 2 + 0.5 * (there[1] + 20) ** 2
    assert min(scores, key=scores.get) == (13, -20)
    assert next(iter(scores)) == (0, 0) and len(scores) < 30
    assert all(-40 <= b <= 20 and -30 <= a <= 30 for a, b in scores)


def test_it_is_the_same_again():
    assert searched(budget=15) == searched(budget=15)


def test_falls_count_before_all_else():
    """There is a fall wherever it inclines least."""

    def cliff(values):
        return Score(int(values["a"] > 0.5), 0, 10.0 - values["a"])

    found = searched(budget=30, evaluate=cliff)
    assert found.best().score.falls == 0
    assert found.best().values["a"] == pytest.approx(0.4, abs=0.3)
    assert found.importance["a"] > 0.8


def test_values_that_are_not_allowed_cost_nothing():
    def bounded(values):
        if values["a"] > 1.0:
            raise ScenarioError("not allowed")
        return valley(values)

    found = searched(budget=25, evaluate=bounded)
    assert len(found.trials) == 25
    assert max(trial.values["a"] for trial in found.trials) <= 1.0


def test_a_search_that_is_ended_in_a_trial_goes_on_with_it(tmp_path):
    """It lies in a study's file, beside the runs."""
    whole, calls = searched(budget=14), []

    def ended(values):
        calls.append(values)
        if len(calls) in (1, 6, 11):
            raise KeyboardInterrupt
        return valley(values)

    Store(tmp_path / "runs.sqlite")
    for _ in range(3):
        with pytest.raises(KeyboardInterrupt):
            searched(tmp_path / "runs.sqlite", 14, ended)
    assert searched(tmp_path / "runs.sqlite", 14, ended) == whole
    assert len(calls) == 14 + 3
    assert list(Store(tmp_path / "runs.sqlite").rows()) == []


def test_the_front_is_what_one_may_choose_from():
    scores = [
        Score(1, 0, 3.0),
        Score(0, 0, 5.0),
        Score(0, 1, 4.0),
        Score(2, 0, 3.5),
        Score(0, 2, 2),
    ]
    trials = [Trial({"a": k}, score) for k, score in enumerate(scores)]
    front = Search(trials, {}).front()
    assert [trial.values["a"] for trial in front] == [1, 0, 4]


def test_the_rank_has_the_order_of_the_scores():
    scores = [
        Score(0, 0, 5.0),
        Score(0, 0, 700.0),
        Score(0, 1, 0.1),
        Score(1, 0, 0.1),
        Score(1, 99, 1),
    ]
    assert sorted(scores) == scores
    assert sorted(scores, key=Score.rank) == scores
    assert Score(3, 0, float("inf")).rank() < Score(4, 0, 0.0).rank()


def test_without_optuna_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(SearchError, match=r"pip install 'lola_drake\[tune\]'"):
        searched()
