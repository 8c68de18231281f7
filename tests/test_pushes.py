"""Pushes: their force over time, in the closed loop, and where they are told and shown."""

import base64
import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from lola_drake.paths import models_dir
from lola_drake.pushes import BODIES, Push
from lola_drake.reports.payload import events
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario, ScenarioError, load_scenario
from lola_drake.signals import PERIOD
from lola_drake.simulation import simulate, start
from lola_drake.theory.constants import GRAVITY
from lola_drake.view3d.frames import SEEN, frames_at
from lola_drake.view3d.replay import replay_page

LEFT = {"time": 0.1, "duration": 0.05, "impulse": 6.0, "direction_deg": 90.0}


def test_every_link_but_the_pads_may_be_pushed():
    urdf = ElementTree.parse(models_dir() / "lola" / "lola.urdf").getroot()
    links = {link.get("name") for link in urdf.iter("link")}
    assert set(BODIES) == {link for link in links if not link.startswith("pad_")}


@pytest.mark.parametrize("shape", ["constant", "half_sine"])
@pytest.mark.parametrize("duration", [PERIOD, 0.1])
def test_the_force_adds_up_to_the_impulse_along_its_direction(shape, duration):
    push = Push(0.2, duration, 7.0, direction_deg=30.0, elevation_deg=-20.0, shape=shape)
    forces = np.array([push.force(tick) for tick in range(1000)])
    expected = 7.0 * np.array([0.8138, 0.4698, -0.3420])
    assert PERIOD * forces.sum(axis=0) == pytest.approx(expected, abs=1e-3)
    pushing = np.flatnonzero(forces.any(axis=1))
    assert pushing[0] == 200 and len(pushing) == round(duration / PERIOD)
    if duration > PERIOD:
        size = np.linalg.norm(forces[pushing], axis=1)
        assert size[50] / size[0] == pytest.approx(1.0 if shape == "constant" else 64, rel=0.01)
        assert push.mean_force() == pytest.approx(forces[pushing].mean(axis=0))


@pytest.fixture(scope="module")
def pushed():
    return simulate(load_scenario("stand", {"duration": 0.16, "pushes": [LEFT]}))


def test_a_push_changes_the_momentum_by_its_impulse(pushed):
    """What the ground does not account for is the push, in each direction."""
    mass = Kinematics().mass
    com, force = pushed.signals["com_position"], pushed.signals["ground_force"]
    first, last = 90, 155
    rates = (com[[first + 1, last + 1]] - com[[first, last]]) / PERIOD
    # The force of a step is in the record one tick later.
    ground = (force[first + 2 : last + 2, :3] + force[first + 2 : last + 2, 3:]).sum(
        axis=0
    ) * PERIOD
    weight = mass * GRAVITY * PERIOD * (last - first)
    impulse = mass * (rates[1] - rates[0]) - ground + [0.0, 0.0, weight]
    assert impulse == pytest.approx([0.0, 6.0, 0.0], abs=0.15)


def test_a_push_acts_at_its_point(pushed):
    """High up it leans the robot over, near the hips much less."""
    low = load_scenario("stand", {"duration": 0.16, "pushes": [{**LEFT, "point": [0, 0, -0.6]}]})
    leaning = [r.signals["torso_pose"][-1, 3] for r in (pushed, simulate(low))]
    assert leaning[0] < -1e-3 and abs(leaning[1]) < 0.5 * abs(leaning[0])


def test_a_push_before_a_drive_reaches_its_limit_is_not_lost():
    """The run then begins again with other servos, and is pushed on."""
    scenario = load_scenario("stand", {"duration": 0.16, "pushes": [LEFT]})
    changing, limited = start(scenario), start(scenario, limited=True)
    changing.advance(0.12)
    changing._go_on(changing._snapshot(), changing._limited())
    for run in (changing, limited):
        run.advance(0.16)
    rates = [run.plant_state[31:37] for run in (changing, limited)]
    assert rates[0] == pytest.approx(rates[1], abs=1e-6) and rates[0][4] > 0.02


def test_a_push_is_told_in_summary_and_report(pushed):
    told = json.loads(json.dumps(pushed.summary))["disturbances"]
    assert told.keys() == {"pushes"} and told["pushes"][0].items() >= LEFT.items()
    (event,) = events([pushed])
    assert (event["name"], event["planned"], event["time"]) == ("push", 0.1, pytest.approx(0.15))
    assert event["what"] == "6 Ns at 90° on torso"


def test_a_push_is_an_arrow_at_its_point(pushed):
    samples = [99, 100, 150]
    frames = frames_at(pushed, samples)
    assert [len(frame.pushes) for frame in frames] == [0, 1, 1]
    point, force = frames[1].pushes[0]
    assert point == pytest.approx(pushed.signals["torso_pose"][100, :3] + [0, 0, 0.25], abs=1e-3)
    assert force == pytest.approx([0.0, 120.0, 0.0])
    assert SEEN > 0.05


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"body": "head"}, "pushes[0].body: 'head' is not allowed, it must be one of torso"),
        ({"duration": 0.0}, "pushes[0].duration: 0.0 is not allowed"),
        ({"impulse": -1}, "pushes[0].impulse: -1 is not allowed"),
    ],
)
def test_a_push_that_cannot_be_is_refused(change, message):
    with pytest.raises(ScenarioError) as caught:
        load_scenario("stand", {"pushes": [change]})
    assert message in str(caught.value)


def test_nothing_is_told_where_nothing_disturbs(make_result):
    assert make_result(Scenario()).summary["disturbances"] == {}


def test_the_replay_has_an_arrow_for_a_push_and_none_without(pushed, make_result):
    for result, shown in ((pushed, True), (make_result(Scenario(), steps=0), False)):
        messages = re.findall(r"base64,([A-Za-z0-9+/=]+)", replay_page(result))
        (recording,) = [m for m in map(base64.b64decode, messages) if b"set_animation" in m]
        assert (b"push/0/shaft" in recording) == shown
