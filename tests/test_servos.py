"""The two kinds of servos: the same torques, and limits that hold whichever runs."""

import numpy as np
import pytest

from lola_drake.scenario import load_scenario
from lola_drake.servos import DampedDriveGuard, DriveGuard
from lola_drake.signals import PERIOD
from lola_drake.simulation import start
from lola_drake.view3d.live import push


def run_of(scenario, *, limited, until, pushed=None):
    run = start(scenario, limited=limited)
    if pushed is not None:
        run.advance(0.1)
        push(run, np.array(pushed))
    while run.time < until - 1e-9 and not run.fallen:
        run.advance(run.time + 0.02)
    run.finish()
    return run, run.result(1.0)


def test_force_and_damping_are_the_implicit_servos():
    """While walking; the contact solver is exact to some 1e-6 of a force."""
    scenario = load_scenario("walk_flat", {"sensors.ideal": True})
    _, damped = run_of(scenario, limited=False, until=2.5)
    _, implicit = run_of(scenario, limited=True, until=2.5)
    torque = implicit.signals["joint_torque"]
    assert np.abs(torque).max() > 50.0
    np.testing.assert_allclose(damped.signals["joint_torque"], torque, atol=0.01)
    pose = implicit.signals["torso_pose"]
    np.testing.assert_allclose(damped.signals["torso_pose"], pose, atol=1e-6)


@pytest.mark.parametrize("direction", [(0.0, 60.0), (0.0, -60.0)])
def test_no_drive_gives_more_than_its_limit(direction):
    """A push that no drive can hold: from there on the servos are those that keep their limits."""
    scenario = load_scenario("stand")
    run, result = run_of(scenario, limited=False, until=0.6, pushed=direction)
    _, implicit = run_of(scenario, limited=True, until=0.6, pushed=direction)
    limit = run.plant.GetEffortUpperLimits()
    torque = np.abs(result.signals["joint_torque"])
    assert (torque <= limit * (1 + 1e-9)).all() and (torque >= limit * (1 - 1e-9)).any()
    assert len(result.times) == len(implicit.times)
    np.testing.assert_allclose(np.diff(result.times), 1e-3, rtol=1e-9)
    np.testing.assert_allclose(
        result.signals["torso_pose"], implicit.signals["torso_pose"], atol=1e-3
    )


def test_what_was_turned_goes_on_behind_the_limit():
    run = start(load_scenario("stand"))
    gain = next(gain for gain in run.gains() if gain.name == "stiffness")
    run.set_gain(gain, 1234.0)
    run.command(np.array([0.1, 0.0, 0.0]))
    push(run, np.array([60.0, 0.0]))
    before = run.diagram
    while run.diagram is before and run.time < 1.0:
        run.advance(run.time + 0.02)
    assert run.diagram is not before
    assert run.gain(gain) == 1234.0
    assert run.signal("walk_command").tolist() == [0.1, 0.0, 0.0]


def test_a_damped_servo_pulls_towards_where_it_shall_be_at_the_end_of_the_step():
    """At rest and accelerating it has moved by PERIOD^2 times the acceleration."""
    law, a = DampedDriveGuard.laws["joint_torque"], np.array([2.0, -4.0])
    q, v, desired, feedforward = (
        np.zeros(2),
        np.zeros(2),
        np.array([0.1, 0.2, 3.0, 4.0]),
        np.ones(2),
    )
    torque = law(q, v, a, desired, feedforward, np.array([50.0, 60.0]), np.array([5.0, 6.0]))
    to_go, faster = desired[:2] - PERIOD**2 * a, desired[2:] - PERIOD * a
    np.testing.assert_allclose(torque, [50, 60] * to_go + [5, 6] * faster + 1.0, rtol=1e-12)


@pytest.mark.parametrize(("torque", "reached"), [(99.9, 0.0), (100.0, 1.0), (-100.0, 1.0)])
def test_the_guard_remembers_a_torque_at_its_limit(torque, reached):
    guard = DriveGuard.laws["next_overloaded"]
    assert guard([0.0], [1.0, torque], [50.0, 100.0]) == (reached,)
    assert guard([1.0], [0.0, 0.0], [50.0, 100.0]) == (1.0,)
