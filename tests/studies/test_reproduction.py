"""Comparison and reproduction of made-up runs whose numbers are known."""

import json
import sys
import types

import numpy as np
import pytest

from lola_drake.scenario import Scenario, ScenarioError, differences, override
from lola_drake.studies.reproduction import EXPERIMENTS, Outcome, reproduction, run_experiments
from lola_drake.studies.study import Study
from lola_drake.studies.variants import COMPARED, change_percent, compare, comparison
from lola_drake.workers import inline


def summary(**changes):
    """Return the part of a summary that comparisons look at; all metrics are 2."""
    both = {"x": 2.0, "y": 2.0}
    pairs = dict.fromkeys(("max_inclination_deg", "rms_torque_error_Nm"), both)
    return {"fell": False, "error": None} | dict.fromkeys(COMPARED, 2.0) | pairs | changes


@pytest.fixture
def inclined(make_result, monkeypatch):
    """Let every simulation incline the torso by an angle that depends on variant and seed.

    `ref` inclines by 4 degrees, `dyn` by 1 degree for each number of the seed, `original` falls.
    """

    def simulate(scenario, folder=None):
        fall = {"completed": False, "fall_time": 1.5} if scenario.variant == "original" else {}
        result = make_result(scenario, steps=1, **fall)
        angle = 4.0 if scenario.variant == "ref" else float(scenario.seed)
        result.signals["torso_pose"][1000, 4] = np.radians(angle)
        return result

    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)


def test_change_is_that_of_the_second_against_the_first():
    other = summary(max_inclination_deg={"x": 1.0, "y": 3.0}, max_foot_force_N=2.0)
    change = change_percent(summary(), other)
    assert change["max_inclination_deg"] == {"x": -50.0, "y": 50.0}
    assert change["max_foot_force_N"] == 0.0
    assert change.keys() == set(COMPARED)


@pytest.mark.parametrize("first", [None, 0.0])
def test_there_is_no_change_without_something_to_compare(first):
    assert change_percent(summary(settling_time_s=first), summary())["settling_time_s"] is None


def test_a_fall_has_no_change():
    for pair in ((summary(fell=True), summary()), (summary(), summary(fell=True))):
        change = change_percent(*pair)
        assert change["max_slip_m"] is None
        assert change["max_inclination_deg"] == {"x": None, "y": None}


def test_a_run_that_failed_is_counted_and_changes_nothing():
    failed = {"fell": False, "error": "no number any more"}
    pairs = [(summary(), failed), (summary(), summary(settling_time_s=3.0))]
    report = Outcome(EXPERIMENTS[1], pairs).report()
    assert report["failures"] == {"ref": 0, "dyn": 1}
    assert report["falls"] == {"ref": 0, "dyn": 0}
    assert report["pairs_that_stay_up"] == 1
    assert report["median_change_percent"]["settling_time_s"] == 50.0


def test_comparison_of_two_variants(inclined):
    results = compare(Scenario(name="made_up", seed=1), ["ref", "dyn"], jobs=1)
    content = comparison(results)
    assert content["scenario"] == "made_up"
    assert list(content["variants"]) == ["ref", "dyn"]
    assert content["variants"]["dyn"]["max_inclination_deg"]["y"] == pytest.approx(1.0)
    assert content["change_percent"]["max_inclination_deg"]["y"] == pytest.approx(-75.0)
    json.dumps(content, allow_nan=False)


def test_an_unknown_variant_is_said_before_anything_runs():
    with pytest.raises(ScenarioError, match="variant"):
        compare(Scenario(), ["ref", "best"])


def test_median_quartiles_and_falls_of_paired_changes():
    ends = [1.0, 2.0, 3.0, 4.0, 8.0]
    pairs = [(summary(), summary(settling_time_s=end)) for end in ends]
    pairs.append((summary(fell=True), summary()))
    report = Outcome(EXPERIMENTS[1], pairs).report()
    assert report["worlds"] == 6 and report["pairs_that_stay_up"] == 5
    assert report["falls"] == {"ref": 1, "dyn": 0}
    assert report["median_change_percent"]["settling_time_s"] == 50.0
    assert report["quartiles"]["settling_time_s"] == [0.0, 100.0]
    assert report["median_change_percent"]["rms_torque_error_Nm"] == {"x": 0.0, "y": 0.0}


def test_where_nobody_stays_up_there_is_no_change():
    report = Outcome(EXPERIMENTS[1], [(summary(fell=True), summary(fell=True))]).report()
    assert report["median_change_percent"]["max_inclination_deg"] == {"x": None, "y": None}
    assert report["quartiles"]["max_foot_force_N"] is None


def test_reproduction_over_worlds(inclined, tmp_path):
    study = Study(tmp_path / "runs.sqlite", inline)
    content = reproduction(run_experiments(study, samples=3))
    assert list(content["experiments"]) == [e.name for e in EXPERIMENTS]
    board, step = content["experiments"]["board_4cm"], content["experiments"]["step_down"]
    assert board["falls"] == {"original": 3, "ref": 0}
    assert step["worlds"] == 3 and step["paper"] == {"max_inclination_deg": {"y": -63.0}}
    # Seeds 0, 1 and 2 incline dyn by as many degrees.
    assert step["median_change_percent"]["max_inclination_deg"]["y"] == pytest.approx(-75.0)
    json.dumps(content, allow_nan=False)


def test_without_sampling_there_is_one_world_as_it_is_written(inclined, tmp_path):
    content = reproduction(run_experiments(Study(tmp_path / "runs.sqlite", inline)))
    assert {e["worlds"] for e in content["experiments"].values()} == {1}


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda e: e.name)
def test_the_variants_differ_in_nothing_else(experiment):
    first, second = experiment.scenarios(seed=4)
    assert (first.variant, second.variant) == experiment.variants
    assert override(first, {"variant": second.variant}) == second


def test_experiments_have_the_papers_gains():
    scenarios = {e.name: e.scenarios()[1] for e in EXPERIMENTS}
    gains = {
        name: (s.control.force.time_constant, s.control.com_dynamics.gain, s.pattern.phase_reset)
        for name, s in scenarios.items()
    }
    assert gains == {
        "board_4cm": (0.02, 1.0, True),
        "board_9cm": (0.02, 1.0, True),
        "step_down": (0.027, 0.8, False),
        "step_down_8cm5": (0.027, 0.8, False),
    }
    assert scenarios["board_9cm"].pattern.step_height == 0.12
    assert scenarios["step_down"].ground.obstacles[0].height == 0.055
    assert scenarios["step_down_8cm5"].ground.obstacles[0].height == 0.085
    assert scenarios["board_4cm"].walk.steps[0].length == 0.4


def test_one_set_of_gains_for_all_experiments():
    """But for what the paper changes: delta (with it K_a,x), g_a, phase reset, step height."""
    allowed = {
        "control.force.time_constant",
        "control.com_dynamics.gain",
        "control.com_dynamics.decay_gain",
        "pattern.phase_reset",
        "pattern.step_height",
    }
    for experiment in EXPERIMENTS:
        changed = differences(experiment.scenarios()[1])
        gains = {key for key in changed if key.startswith(("control.", "pattern.", "sensors."))}
        assert gains <= allowed, experiment.name
        control = experiment.scenarios()[1].control
        inverse = 1 / control.force.time_constant
        assert control.com_dynamics.decay_gain == pytest.approx(inverse, rel=0.01)
