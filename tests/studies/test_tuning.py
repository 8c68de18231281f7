"""The search for gains: finds the least of a known function, keeps its budget, uses ref alone."""

import dataclasses
import json
import math

import pytest

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.scenario import Control, Scenario, override
from lola_drake.studies import tuning
from lola_drake.studies.reproduction import EXPERIMENTS
from lola_drake.studies.tuning import GAINS, Score, best, coordinate_search, score


def valley(values):
    """Return a score that is least at a = 1.3, b = -2."""
    return Score(0, 0, (values["a"] - 1.3) ** 2 + 0.5 * (values["b"] + 2.0) ** 2)


STEPS = {"a": 0.8, "b": 0.8}


def test_search_finds_the_least():
    trials = coordinate_search(valley, {"a": 0.0, "b": 0.0}, STEPS, budget=80)
    found = best(trials).values
    assert found == pytest.approx({"a": 1.3, "b": -2.0}, abs=0.3)


def test_search_keeps_its_budget_and_tries_nothing_twice():
    trials = coordinate_search(valley, {"a": 0.0, "b": 0.0}, STEPS, budget=9)
    assert len(trials) == 9
    assert len({tuple(trial.values.values()) for trial in trials}) == 9
    assert trials[0].values == {"a": 0.0, "b": 0.0}


def test_search_stays_among_the_allowed_values():
    def evaluate(values):
        if values["a"] > 1.0:
            raise ValueError("not allowed")
        return valley(values)

    trials = coordinate_search(evaluate, {"a": 0.0, "b": 0.0}, STEPS, budget=80)
    assert 0.8 <= best(trials).values["a"] <= 1.0


def summary(scenario="step_down", fell=False, x=0.0, y=0.0, torque=0):
    """Return what the score looks at in the summary of a run."""
    return {
        "scenario": scenario,
        "fell": fell,
        "max_inclination_deg": {"x": x, "y": y},
        "steps_beyond_limits": {"joint_torque": torque, "friction": 0},
    }


def test_falls_count_first_and_then_overloads():
    up, calm, fallen = summary(x=3.0, y=4.0), summary(y=1.0), summary(fell=True, x=45.0)
    assert score([up, calm]) == Score(0, 0, pytest.approx(5.0**0.5))
    assert score([fallen, calm]) == Score(1, 0, 1.0)
    assert score([up, up]) < score([fallen, calm])
    assert score([fallen, fallen]) == Score(2, 0, math.inf)
    assert score([up, up, summary(tuning.CALM)]) < score(
        [calm, calm, summary(tuning.CALM, torque=1)]
    )


def test_limits_count_on_flat_ground_and_inclination_everywhere():
    assert score([summary(y=2.0, torque=50), summary(tuning.CALM, y=8.0)]) == Score(
        0, 0, pytest.approx(4.0)
    )


def test_the_gains_are_numbers_of_the_scenario_and_none_is_the_papers():
    for gain in GAINS:
        override(Scenario(), {gain.key: 1.5 * gain.step})
    keys = {gain.key for gain in GAINS}
    assert not keys & {"control.force.time_constant", "control.com_dynamics.gain"}


@pytest.mark.parametrize("law", FORCE_LAWS)
def test_of_a_force_law_the_gains_with_a_slider_are_tuned_and_no_others(law):
    gains = tuning.law_gains(law)
    section = Control(law=law).of_law()
    sliders = [f.name for f in dataclasses.fields(section) if f.metadata["slider"]]
    assert [gain.key.rpartition(".")[2] for gain in gains] == sliders
    for gain in gains:
        changed = override(Scenario(), {gain.key: 1.5 * gain.step, "control.law": law})
        assert changed.control.of_law() != section
    runs = tuning.tuning_scenarios({}, 1, law)
    assert {(run.variant, run.control.law) for run in runs} == {("ref", law)}


def test_only_ref_decides_and_not_in_the_worlds_of_the_reproduction():
    runs = tuning.tuning_scenarios({"pattern.zmp_inward": 0.04}, samples=3)
    assert len(runs) == 3 * (len(tuning.SCENARIOS) + 1)
    assert {run.variant for run in runs} == {"ref"}
    assert {run.pattern.zmp_inward for run in runs} == {0.04}
    measured = {run.seed for e in EXPERIMENTS for k in range(100) for run in e.scenarios(k)}
    assert not measured & {run.seed for run in runs}


def test_the_record_holds_every_trial():
    class Made:
        """Stands for a study: its runs incline by the damping's distance from 400."""

        @staticmethod
        def run(scenarios):
            distance = abs(scenarios[0].control.stabilizer.damping - 400.0) / 100.0
            return [summary(y=distance)]

    told = []
    trials = tuning.tune(
        Made(), samples=2, budget=24, progress=lambda trials: told.append(len(trials))
    )
    content = json.loads(json.dumps(tuning.record(trials, samples=2)))
    assert told == list(range(1, 25))
    assert len(trials) == len(content["trials"]) == 24
    assert content["seeds"] == [1000, 1001]
    assert content["start"]["values"]["control.stabilizer.damping"] == 300.0
    assert content["chosen"]["values"]["control.stabilizer.damping"] == 380.0
    assert content["chosen"]["falls"] == 0
