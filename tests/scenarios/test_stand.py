"""LOLA stands: still with ideal sensors, upright for a minute with real ones."""

import numpy as np

from lola_drake.signals import GROUND_FORCE
from lola_drake.theory.constants import GRAVITY

WEIGHT = 60.0 * GRAVITY


def vertical_force(result):
    force = result.signals["ground_force"]
    return force[:, GROUND_FORCE.slice("F_l").stop - 1] + force[:, -1]


def test_ideal_sensors_stand_still(run):
    result = run("stand", "duration=10", "sensors.ideal=true")
    later = result.times >= 2.0
    assert result.completed
    assert np.abs(vertical_force(result)[later] / WEIGHT - 1).max() < 0.005
    assert np.abs(result.signals["joint_velocity"][later]).max() < 1e-3
    drift = np.ptp(result.signals["torso_pose"][later], axis=0)
    assert drift[:3].max() < 1e-4 and np.degrees(drift[3:]).max() < 0.01


def test_ideal_sensors_do_not_rattle(run):
    result = run("stand", "duration=10", "sensors.ideal=true")
    force = vertical_force(result)[result.times >= 2.0]
    assert np.abs(np.diff(force)).max() < 1.0
    assert result.signals["contact"][result.times >= 2.0].all()


def test_real_sensors_stand_a_minute(run):
    result = run("stand", "duration=60")
    assert result.completed
    assert max(result.metrics["max_inclination_deg"].values()) < 0.3
    moved = result.signals["torso_pose"][-1, :2] - result.signals["torso_pose"][0, :2]
    assert np.linalg.norm(moved) < 0.01
