"""What led to a fall, in made-up runs in which it is known."""

import numpy as np
import pytest

from lola_drake.fall_events import fall_events
from lola_drake.results import run_limits
from lola_drake.signals import CONTACT, GAIT_PHASE, JOINTS


@pytest.fixture
def fallen(make_result):
    """Return a walk that is calm until 3 s and falls at its end."""
    result = make_result(steps=4, completed=False, fall_time=5.2)
    result.signals["torso_pose"][3000:, 4] = np.radians(5.0)
    return result


def at_torque_limit(result, name, begin):
    k = JOINTS.index(name)
    limit = run_limits(result.scenario).torque[k]
    result.signals["joint_torque"][begin : begin + 20, k] = -limit


def test_a_run_that_stays_up_has_none(make_result):
    result = make_result(steps=4)
    at_torque_limit(result, "tkfr", 3100)
    assert fall_events(result) == []


def test_the_first_one_is_the_cause(fallen):
    at_torque_limit(fallen, "tkfr", 3200)
    fallen.signals["joint_velocity"][3100, JOINTS.index("tbr")] = -100.0
    assert fall_events(fallen) == [
        {"time_s": 3.1, "event": "joint_speed of tbr"},
        {"time_s": 3.2, "event": "joint_torque of tkfr"},
    ]


def test_what_was_survived_is_no_cause(fallen):
    """The torso was calm again, a step of 0.8 s and more later."""
    at_torque_limit(fallen, "tkfr", 2100)
    assert fall_events(fallen) == []
    at_torque_limit(fallen, "tkfr", 2300)
    assert [event["time_s"] for event in fall_events(fallen)] == [2.3]


def test_a_late_contact_counts_from_when_it_was_planned(fallen):
    """The right foot lifts off, is to land before long, and does so 0.2 s later."""
    gait = fallen.signals["gait_phase"]
    at = GAIT_PHASE.slice("support")
    gait[:, at] = 1.0
    swing = fallen.scenario.pattern.step_time - fallen.scenario.pattern.double_support
    gait[3000 : 3000 + round(1000 * swing), at.start + 1] = 0.0
    pads = CONTACT.slice("pads_r")
    fallen.signals["contact"][:, pads] = 1.0
    landed = 3000 + round(1000 * (swing + 0.2))
    fallen.signals["contact"][3000:landed, pads] = 0.0
    (event,) = fall_events(fallen)
    assert event["event"] == "late contact of the right foot"
    assert event["time_s"] == pytest.approx(3.0 + swing, abs=2e-3)
