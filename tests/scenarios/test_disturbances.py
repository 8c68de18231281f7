"""Uneven ground and pushes in the closed loop: just past the event, with what it leaves over."""

import numpy as np
import pytest

from lola_drake.metrics import inclination_deg
from lola_drake.signals import CONTACT, GROUND_FORCE
from lola_drake.simulation import simulate
from lola_drake.studies.arena import TRIALS

AT_ONCE = ("walk.start_time=0", "pattern.first_double_support=0.3")


def tilt(result, since=0.0):
    """Return the torso's greatest inclination from some time on (deg)."""
    angles = inclination_deg(result.signals["torso_pose"][result.times >= since])
    return np.linalg.norm(angles, axis=1).max()


def loaded(result, foot):
    """Return where a foot bears more than half the weight: a bool for each sample."""
    return result.signals["ground_force"][:, GROUND_FORCE.slice(f"F_{foot}")][:, 2] > 300.0


def test_feet_lie_on_a_slope_and_the_torso_stays_upright(run):
    slope = "{name: s, position: [1.3, 0], size: [2, 1.2], height: 0.14054, pitch_deg: -8}"
    result = run("slope", f"ground.obstacles=[{slope}]", *AT_ONCE, "duration=3.3")
    assert result.completed and tilt(result) < 2.0
    for foot in "lr":
        pose = result.signals[f"foot_pose_{foot}"]
        on_slope = loaded(result, foot) & (pose[:, 0] > 0.6)
        assert on_slope.sum() > 200
        # -8 deg is up ahead; the TCP is on the slope as a foot sinks in.
        assert np.degrees(np.median(pose[on_slope, 4])) == pytest.approx(-8.0, abs=0.7)
        depth = pose[on_slope, 2] - np.tan(np.radians(8.0)) * (pose[on_slope, 0] - 0.3)
        assert -5e-3 < np.median(depth) < 0.0


def test_a_slope_across_turns_the_feet_about_their_length(run):
    slope = "{name: s, position: [1.5, 0], size: [2, 1.2], height: 0.1, roll_deg: 5}"
    start = "{name: p, size: [1, 1.2], height: 0.1}"
    result = run("slope", f"ground.obstacles=[{start}, {slope}]", *AT_ONCE, "duration=3.3")
    assert result.completed and tilt(result) < 2.0
    for foot in "lr":
        pose = result.signals[f"foot_pose_{foot}"]
        on_slope = loaded(result, foot) & (pose[:, 0] > 0.65)
        assert np.degrees(np.median(pose[on_slope, 3])) == pytest.approx(5.0, abs=0.7)


def test_a_foot_stands_on_its_heel(run):
    hold = "{step: 2, part: heel, height: 0.06}"
    result = run("half_board", f"ground.footholds=[{hold}]", *AT_ONCE, "duration=2.6")
    assert result.completed and tilt(result) < 6.0
    pads = result.signals["contact"][:, CONTACT.slice("pads_r")]
    standing = loaded(result, "r") & (result.signals["foot_pose_r"][:, 2] > 0.02)
    # The rear pads find the board; the front ones hang until the foot has tilted to the floor.
    assert standing.sum() > 300 and pads[standing, :2].all(axis=1).mean() > 0.8
    assert not pads[standing, 2:][:50].any()
    assert np.degrees(result.signals["foot_pose_r"][standing, 4].max()) > 8.0


def test_boards_of_random_height_are_walked_over(run):
    field = "{name: f, position: [0.3, 0], size: [2, 1.2], seed: 3}"
    start = "{name: s, position: [-0.2, 0], size: [1, 1.2], height: 0.04}"
    changes = (f"ground.fields=[{field}]", f"ground.obstacles=[{start}]", "duration=3.3")
    result = run("rough_field", *AT_ONCE, *changes)
    assert result.completed and tilt(result) < 4.0
    ground = result.scenario.terrain
    feet = [result.signals[f"foot_pose_{foot}"] for foot in "lr"]
    below = np.concatenate([ground.surface(pose[:, :2]).height for pose in feet])
    assert np.ptp(below[np.abs(below - 0.04) > 1e-6]) > 0.01


def test_a_push_is_overcome(run):
    push = "{time: 1.2, impulse: 8, direction_deg: -90}"
    result = run("push", f"pushes=[{push}]", *AT_ONCE, "duration=2.8")
    assert result.completed
    roll = inclination_deg(result.signals["torso_pose"])[:, 0]
    assert 0.7 < roll[1200:1600].max() < 4.0, "to the right"
    assert tilt(result, since=2.5) < 1.5


def test_a_slippery_plate_lets_a_foot_slide(run):
    slip = {}
    for friction in (1.0, 0.05):
        plate = "name: p, position: [1.3, 0], size: [2, 1.2], height: 0.005"
        obstacles = f"ground.obstacles=[{{{plate}, relative_friction: {friction}}}]"
        result = run("walk_flat", obstacles, *AT_ONCE, "duration=2.2")
        slip[friction] = result.metrics["max_slip_m"]
        sliding = result.metrics["steps_beyond_limits"]["friction"]
        assert (sliding > 50) == (friction < 0.1)
    assert slip[0.05] > 3 * slip[1.0]


def test_a_push_backward_is_borne_by_a_step_that_goes_where_the_robot_falls(run):
    """Half of the sampled worlds fall from 15 Ns without the step's adaptation."""
    push = "pushes=[{time: 1.2, duration: 0.1, direction_deg: 180, impulse: 22}]"
    reset = ("pattern.phase_reset=true", "pattern.step_height=0.12", "duration=3.0")
    fallen = run("walk_flat", push, *reset, *AT_ONCE)
    borne = run("walk_flat", push, *reset, *AT_ONCE, "pattern.step_adaptation=true")
    assert fallen.fall_time is not None
    assert borne.completed and tilt(borne, since=2.5) < 4.0
    foot = borne.signals["foot_pose_r"][:, 0] - borne.signals["foot_pose_l"][:, 0]
    assert foot[(borne.times > 1.45) & (borne.times < 1.7)].max() < 0.2


@pytest.mark.parametrize("part", ["front", "inner"])
@pytest.mark.parametrize("sensed", [False, True])
def test_a_foot_turns_until_it_finds_the_ground_beside_half_a_board(part, sensed):
    """6 cm under half a foot; with 0.25 rad to turn the robot falls, from all of these."""
    (trial,) = (each for each in TRIALS if each.title == f"board under the {part} half")
    law = {"variant": "dyn", "control.force.sensed_area": sensed}
    result = simulate(trial.world(6, 8000, law))
    assert result.fall_time is None
    assert max(result.metrics["max_inclination_deg"].values()) < 3.0
