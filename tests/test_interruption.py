"""Runs that do not come to their end: what was recorded is kept, and they say what it is."""

import os
import signal
import threading

import numpy as np
import pytest

import lola_drake as lola
from lola_drake.interruption import interruption
from lola_drake.scenario import Scenario
from lola_drake.simulation import simulate

SHORT = Scenario(duration=0.1)


def kept(result, until):
    assert not result.completed and result.fall_time is None
    assert result.duration == pytest.approx(until)
    assert len(result.times) == len(result.signals["torso_pose"]) > 10
    assert all(np.isfinite(values).all() for values in result.signals.values())
    return result


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_run(number):
    before = signal.getsignal(number)
    result = simulate(SHORT, progress=lambda now: os.kill(os.getpid(), number))
    assert kept(result, 0.02).error is None and "interrupted" in repr(result)
    assert signal.getsignal(number) is before


def test_in_another_thread_signals_are_left_alone():
    seen = []

    def attend():
        with interruption() as event:
            seen.append((event.is_set(), signal.getsignal(signal.SIGINT)))

    before = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=attend)
    thread.start()
    thread.join()
    assert seen == [(False, before)]


def test_a_view_that_dies_takes_no_record_along(tmp_path):
    def attend(run):
        if run.time > 0.03:
            raise RuntimeError("the browser\nis gone")
        return 0.02

    result = kept(simulate(SHORT, attend=attend), 0.04)
    assert result.error == "RuntimeError: the browser is gone"
    assert result.summary["error"] == result.error
    assert lola.load_result(result.save(tmp_path / "run")).error == result.error


def test_a_state_that_is_no_number_ends_a_run():
    def attend(run):
        if run.time > 0.03:
            inside = run.plant.GetMyMutableContextFromRoot(run.context)
            run.plant.SetVelocities(inside, np.full(run.plant.num_velocities(), np.nan))
        return 0.02

    result = simulate(SHORT, attend=attend)
    assert result.error and len(kept(result, result.duration).error) < 200
    assert result.duration < 0.05


def test_a_scenario_may_be_a_name_or_a_path(tmp_path):
    (tmp_path / "my.yaml").write_text("duration: 0.002")
    assert lola.simulate(tmp_path / "my.yaml").scenario.name == "my"
    assert lola.build_simulation("stand").get_name() == "lola"
    for wrong in (5, None, "stnd", "gone.yaml"):
        with pytest.raises(lola.LolaError):
            lola.simulate(wrong)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [({3: 4}, "3 is not a key"), ([5], "5 is not of the form"), ("duration", "is not of the form")],
)
def test_wrong_overrides_are_one_line(overrides, message):
    with pytest.raises(lola.ScenarioError, match=message):
        lola.load_scenario("stand", overrides)
    assert lola.load_scenario("walk_flat", "duration=3").duration == 3.0


def test_a_posture_out_of_reach_names_its_keys():
    high = {"pattern.com_height": 0.92, "pattern.step_width": 0.5, "pattern.zmp_forward": 0.05}
    try:
        lola.build_simulation(lola.load_scenario("stand", high))
    except lola.ScenarioError as error:
        assert "pattern.com_height" in str(error)


def test_all_errors_are_of_one_family():
    names = [name for name in lola.__all__ if name.endswith("Error")]
    assert len(names) == 7
    assert all(issubclass(getattr(lola, name), lola.LolaError) for name in names)
    with pytest.raises(lola.OutputError, match="at least one run"):
        lola.write_report([], "page.html")
