"""The search for gains: what it looks at, where, and in which worlds; it uses ref alone."""

import dataclasses
import json
import math
import types

import pytest

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.scenario import Control, Scenario, override
from lola_drake.studies import tuning
from lola_drake.studies.reproduction import EXPERIMENTS
from lola_drake.studies.search import Range, Score
from lola_drake.studies.tuning import GAINS, score


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


class Made:
    """Stands for a study: its runs incline by the damping's distance from 400."""

    def __init__(self, file):
        self.store = types.SimpleNamespace(file=file)
        self.runs = []

    def run(self, scenarios):
        self.runs.append(scenarios[0].control.stabilizer.damping)
        return [summary(y=abs(self.runs[-1] - 400.0) / 100.0 + 0.1)]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    told = []
    study = Made(tmp_path_factory.mktemp("study") / "runs.sqlite")
    return tuning.tune(study, samples=2, budget=20, progress=told.append), told


def test_the_record_holds_every_trial(found):
    search, told = found
    content = json.loads(json.dumps(tuning.record(search, samples=2)))
    assert told == list(range(21))
    assert len(content["trials"]) == 20
    assert content["seeds"] == [1000, 1001]
    assert content["start"]["values"]["control.stabilizer.damping"] == 300.0
    assert content["chosen"]["values"]["control.stabilizer.damping"] == pytest.approx(400.0, abs=25)
    assert content["chosen"]["falls"] == 0
    importance = content["importance"]
    assert max(importance, key=importance.get) == "control.stabilizer.damping"


def test_gains_are_looked_for_where_they_are_allowed():
    for gain in GAINS:
        at = gain.range()
        assert at.low < gain.start < at.high
        for value in (at.low, gain.start, at.high):
            override(Scenario(), {gain.key: value})
    damping = next(gain for gain in GAINS if gain.key == "control.stabilizer.damping")
    assert damping.range() == Range(300.0, 5.0, down=32, up=32)
    assert (damping.range().low, damping.range().high) == (140.0, 460.0)


def test_a_search_that_was_stopped_goes_on(tmp_path):
    file = tmp_path / "runs.sqlite"
    whole = tuning.tune(Made(tmp_path / "whole.sqlite"), samples=2, budget=12)
    tuning.tune(Made(file), samples=2, budget=5)
    again = Made(file)
    assert tuning.tune(again, samples=2, budget=12).trials == whole.trials
    assert len(again.runs) == 7
    other = Made(file)
    tuning.tune(other, samples=3, budget=5)
    assert len(other.runs) == 5
