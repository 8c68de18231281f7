"""LOLA walks: straight, fast, in a curve, far from the origin; with real sensors."""

import numpy as np
import pytest

from lola_drake.metrics import SETTLED, touchdowns
from lola_drake.robot import JOINT_INDEX, Kinematics
from lola_drake.scenario import load_scenario
from lola_drake.signals import PLANNED_MOTION
from lola_drake.theory.footholds import SOLE


def worst_inclination(result) -> float:
    return max(result.metrics["max_inclination_deg"].values())


def stays_within_limits(result) -> bool:
    kinematics = Kinematics()
    lower, upper = kinematics.position_limits
    q = result.signals["joint_position"]
    return bool(
        (np.abs(result.signals["joint_torque"]) < kinematics.effort_limits).all()
        and (np.abs(result.signals["joint_velocity"]) < kinematics.velocity_limits).all()
        and ((q > lower) & (q < upper)).all()
    )


def test_walk_flat(run):
    result = run("walk_flat")
    assert result.completed and result.fall_time is None
    assert result.metrics["mean_speed_m_per_s"] == pytest.approx(1.5 / 3.6, rel=0.03)
    assert worst_inclination(result) < 1.0
    assert result.metrics["max_slip_m"] < 0.01
    assert stays_within_limits(result)


def test_walk_fast(run):
    result = run("walk_fast")
    assert result.completed and result.fall_time is None
    assert result.metrics["mean_speed_m_per_s"] == pytest.approx(0.5, rel=0.03)
    assert worst_inclination(result) < 2.0
    assert result.metrics["max_slip_m"] < 0.01
    assert stays_within_limits(result)


def test_walk_turn_ends_where_it_was_planned(run):
    result = run("walk_turn")
    assert result.completed and result.fall_time is None
    plan = result.signals["planned_motion"][-1]
    for foot in "lr":
        planned = plan[PLANNED_MOTION.slice(f"foot_{foot}")]
        actual = result.signals[f"foot_pose_{foot}"][-1]
        assert np.linalg.norm(actual[:2] - planned[:2]) < 0.05
        assert abs(np.degrees(actual[5] - planned[3])) < 3.0


def test_step_in_place_stays(run):
    result = run("step_in_place")
    assert result.completed and result.fall_time is None
    moved = result.signals["torso_pose"][-1, :2] - result.signals["torso_pose"][0, :2]
    assert np.linalg.norm(moved) < 0.03
    assert worst_inclination(result) < 1.0


def test_far_from_the_origin_it_is_the_same_robot(run):
    far = ("start.x=50", "start.y=-30", "start.heading_deg=135")
    here, there = run("walk_flat", "duration=5"), run("walk_flat", "duration=5", *far)
    for metric in ("mean_speed_m_per_s", "max_foot_force_N", "distance_m"):
        assert there.metrics[metric] == pytest.approx(here.metrics[metric], rel=0.005)
    for metric, margin in (("max_inclination_deg", 0.02), ("rms_torque_error_Nm", 0.05)):
        for axis in "xy":
            assert there.metrics[metric][axis] == pytest.approx(
                here.metrics[metric][axis], abs=margin
            )
    heading = np.deg2rad(135.0)
    moved = there.signals["torso_pose"][-1, :2] - there.signals["torso_pose"][0, :2]
    forward = moved @ [np.cos(heading), np.sin(heading)]
    assert forward == pytest.approx(
        here.signals["torso_pose"][-1, 0] - here.signals["torso_pose"][0, 0], abs=2e-3
    )


def test_command_changes_while_it_walks(run):
    command = (
        "duration=9",
        "walk.steps=[]",
        "walk.command=[{time: 0.5, v_x: 0.3}, {time: 4.0, v_x: 0.2, turn_rate: 0.2}, {time: 6.0}]",
    )
    result = run("walk_flat", *command)
    assert result.completed and result.fall_time is None
    yaw = np.degrees(result.signals["torso_pose"][:, 5])
    assert abs(yaw[result.times < 4.0]).max() < 2.0
    assert yaw[-1] > 10.0
    late = result.signals["torso_pose"][result.times > 8.8, :2]
    assert np.ptp(late, axis=0).max() < 5e-3
    assert worst_inclination(result) < 1.0


@pytest.mark.parametrize("step", [{"sideways": -0.2}, {"turn_deg": 45}])
def test_sideways_and_turning_in_place(run, step):
    """The outer foot goes first: the soles never overlap, and nothing reaches a limit."""
    result = run(
        "walk_flat", f"walk.steps=[{step | {'count': 2}}]", "walk.start_time=0.5", "duration=5"
    )
    assert result.completed and stays_within_limits(result)
    assert worst_inclination(result) < 0.5
    assert result.metrics["steps_with_feet_colliding"] == 0


STAIRS = (
    "ground.stairs.0.rises=2",
    "walk.steps=[{count: 2, length: 0.36, height: 0.12}, {length: 0.36},"
    " {count: 2, length: 0.36, height: -0.12}]",
    "walk.start_time=0.1",
    "pattern.first_double_support=0.4",
    "duration=8.2",
)
"""Two rises up and down again, and a step that closes."""


def test_planned_stairs_are_climbed_and_left_off_every_limit(run):
    """Each foot comes down wholly on a step; the ankle behind keeps 3 deg off its stop.

    Were the heel not lifted on the way down, ankles would be at their stops for hundreds of ticks.
    """
    result = run("stairs_planned", *STAIRS)
    assert result.completed and result.fall_time is None
    assert worst_inclination(result) < 0.5
    assert not any(result.metrics["steps_beyond_limits"].values())
    lower, upper = Kinematics().position_limits
    ankles = [JOINT_INDEX[f"tsf{side}"] for side in "rl"]
    q = result.signals["joint_position"][:, ankles]
    away = np.degrees(np.minimum(q - lower[ankles], upper[ankles] - q))[result.times > SETTLED]
    assert away.min() > 3.0
    landed = touchdowns(result.signals["gait_phase"])
    ground, heights = result.scenario.ground, []
    for k, at in enumerate(landed):
        x, y, z = result.signals[f"foot_pose_{'lr'[k % 2]}"][at, :3]
        under = [ground.height_at(x + end * SOLE[0] / 2, y) for end in (-1, 1)]
        assert under == pytest.approx([z, z], abs=0.003)
        heights.append(z)
    assert heights == pytest.approx([0.12, 0.24, 0.24, 0.12, 0.0, 0.0], abs=0.003)


def test_every_walk_is_as_planned():
    assert sum(g.count for g in load_scenario("walk_flat").walk.steps) == 20
