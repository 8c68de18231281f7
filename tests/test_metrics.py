"""Metrics of made-up signals whose numbers are known."""

import numpy as np
import pytest

from lola_drake import metrics
from lola_drake.ground import Ground
from lola_drake.limits import LIMITS, Limits, beyond_limits
from lola_drake.logged import TORSO_POSE
from lola_drake.signals import (
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    GAIT_PHASE,
    JOINTS,
    MODIFIED_WRENCH,
    TASK_COMMAND,
)


def test_straight_walk(make_result):
    result = make_result(steps=6)
    assert result.metrics["distance_m"] == pytest.approx(2.4, abs=0.01)
    assert result.metrics["mean_speed_m_per_s"] == pytest.approx(0.5, abs=1e-9)
    assert result.metrics["max_foot_force_N"] == 600.0


def test_standing_goes_nowhere(make_result):
    result = make_result(steps=0)
    assert result.metrics["distance_m"] == 0.0
    assert result.metrics["mean_speed_m_per_s"] == 0.0


@pytest.mark.parametrize(
    ("x", "y", "z", "yaw", "collides"),
    [
        (0.0, -0.219, 0.0, 0.0, True),
        (0.0, -0.221, 0.0, 0.0, False),
        (0.269, -0.1, 0.0, 0.0, True),
        (0.271, -0.1, 0.0, 0.0, False),
        (0.0, -0.1, 0.099, 0.0, True),
        (0.0, -0.1, -0.101, 0.0, False),
        # Turned by 45 deg, corner to corner, a foot needs more room, and on its long side less.
        (0.0, -0.26, 0.0, np.pi / 4, True),
        (0.28, -0.28, 0.0, np.pi / 4, False),
        (0.18, -0.18, 0.0, np.pi / 4, True),
    ],
)
def test_feet_collide_where_their_soles_overlap(x, y, z, yaw, collides):
    left, right = (
        np.array([[1.0, 2.0, 0.5, 0, 0, 0.3]]),
        np.array([[0, 0, 0.5 + z, 0, 0, 0.3 + yaw]]),
    )
    c, s = np.cos(0.3), np.sin(0.3)
    right[0, :2] = left[0, :2] + [c * x - s * y, s * x + c * y]
    assert metrics.feet_colliding(left, right).tolist() == [collides]
    assert metrics.feet_colliding(right, left).tolist() == [collides]


def test_a_curve_has_the_length_of_the_curve(make_result):
    result = make_result(steps=12)
    torso = result.signals["torso_pose"].copy()
    angle = torso[:, 0] / 2.0
    torso[:, 0], torso[:, 1] = 2.0 * np.sin(angle), 2.0 * (1.0 - np.cos(angle))
    along = metrics.distance(torso, result.signals["gait_phase"])
    assert along == pytest.approx(4.8, rel=0.01)


def test_walking_part_is_from_first_lift_off_to_last_touchdown(make_result):
    result = make_result(steps=3)
    walking = result.times[metrics.walking_part(result.signals["gait_phase"])]
    assert walking[[0, -1]] == pytest.approx([1.2, 3.4], abs=2e-3)
    assert len(walking) == pytest.approx(2200, abs=2)


def test_touchdowns_count_the_steps(make_result):
    result = make_result(steps=3)
    at = result.times[metrics.touchdowns(result.signals["gait_phase"])]
    assert at == pytest.approx([1.8, 2.6, 3.4], abs=2e-3)


def test_inclination_is_roll_and_pitch_without_sign():
    torso = np.zeros((3, TORSO_POSE.size))
    torso[1, 3:] = np.radians([1.0, -2.0, 30.0])
    assert metrics.max_inclination(torso) == pytest.approx({"x": 1.0, "y": 2.0})
    assert metrics.inclination_deg(torso)[1] == pytest.approx([1.0, -2.0])


def test_start_does_not_count(make_result):
    result = make_result()
    result.signals["torso_pose"][:400, 3] = 1.0
    result.signals["ground_force"][:400, 2] = 1e4
    assert result.metrics["max_inclination_deg"]["x"] == 0.0
    assert result.metrics["max_foot_force_N"] == 600.0


def test_torque_error_is_about_the_com():
    n = 2
    signals = {"desired_wrench": np.zeros((n, DESIRED_WRENCH.size))}
    for foot, r in (("l", [0.1, 0.2, -0.9]), ("r", [-0.3, -0.2, -0.9])):
        signals[f"contact_wrench_{foot}"] = np.zeros((n, CONTACT_WRENCH.size))
        signals[f"task_command_{foot}"] = np.zeros((n, TASK_COMMAND.size))
        signals[f"task_command_{foot}"][:, :3] = r
    # Desired: T_x, T_y, F_z; the force's torque about the CoM is that of r x F.
    signals["desired_wrench"][:, DESIRED_WRENCH.slice("wrench_l")] = [1.0, 2.0, 100.0]
    signals["contact_wrench_r"][:] = [3.0, 4.0, 10.0]
    lever_l = np.cross([0.1, 0.2, -0.9], [0.0, 0.0, 100.0])
    lever_r = np.cross([-0.3, -0.2, -0.9], [0.0, 0.0, 10.0])
    expected = [1.0 + lever_l[0] - 3.0 - lever_r[0], 2.0 + lever_l[1] - 4.0 - lever_r[1]]
    np.testing.assert_allclose(metrics.torque_error(signals), [expected] * n)


def test_torque_error_against_the_modified_wrench_is_all_that_the_feet_do_not_give():
    feet = {"l": [0.1, 0.2, -0.9], "r": [-0.3, -0.2, -0.8]}
    forces = {"l": [3.0, 9.0, 400.0], "r": [1.0, 3.0, 200.0]}  # horizontal ones by the load
    modified = np.zeros(MODIFIED_WRENCH.size)
    signals = {"gait_phase": np.zeros((1, GAIT_PHASE.size))}
    signals["gait_phase"][:, GAIT_PHASE.slice("load")] = 0.75, 0.25
    for foot, r in feet.items():
        height = [0.0, 0.0, 0.75 * -0.9 + 0.25 * -0.8]
        horizontal, vertical = np.array([*forces[foot][:2], 0.0]), [0.0, 0.0, forces[foot][2]]
        torque = np.array([5.0, -7.0, 0.0]) + np.cross(r, vertical) + np.cross(height, horizontal)
        modified[MODIFIED_WRENCH.slice("F")] += forces[foot]
        modified[MODIFIED_WRENCH.slice("T")] += torque
        signals[f"contact_wrench_{foot}"] = np.array([[5.0, -7.0, forces[foot][2]]])
        signals[f"task_command_{foot}"] = np.zeros((1, TASK_COMMAND.size))
        signals[f"task_command_{foot}"][:, :3] = r
    signals["modified_wrench"] = modified[None]
    assert metrics.modified_torque_error(signals) == pytest.approx(np.zeros((1, 2)), abs=1e-9)
    signals["modified_wrench"][0, MODIFIED_WRENCH.slice("T", 2)] += [2.0, -3.0]
    assert metrics.modified_torque_error(signals)[0] == pytest.approx([2.0, -3.0])


def test_rms():
    assert metrics.rms(np.array([[3.0, 1.0], [4.0, -1.0]])) == pytest.approx(
        {"x": np.sqrt(12.5), "y": 1.0}
    )
    assert metrics.rms(np.zeros((0, 2))) == {"x": 0.0, "y": 0.0}


def test_slip_is_the_worst_step_of_a_loaded_foot():
    force, foot = np.zeros((9, 3)), np.zeros((9, 6))
    force[1:4, 2] = force[6:9, 2] = 300.0
    foot[1:4, 0] = [0.0, 0.01, 0.02]
    foot[4:6, 0] = 0.5
    foot[6:9, 1] = [1.0, 1.05, 1.01]
    assert metrics.max_slip(foot, force) == pytest.approx(0.02)
    assert metrics.max_slip(foot, np.zeros((9, 3))) == 0.0


def test_a_foot_stands_from_50_N_on():
    foot = np.zeros((6, 6))
    foot[:, 0] = np.arange(6.0)
    assert metrics.max_slip(foot, np.tile([0.0, 0.0, 50.5], (6, 1))) == 5.0
    assert metrics.max_slip(foot, np.tile([0.0, 0.0, 49.5], (6, 1))) == 0.0


def test_settling_counts_from_the_largest_inclination():
    times, torso = np.arange(6.0), np.zeros((6, TORSO_POSE.size))
    assert metrics.settling_time(times, torso) == 0.0
    torso[:, 4] = np.radians([0.1, 3.0, 1.0, -0.6, 0.4, 0.1])
    assert metrics.settling_time(times, torso) == 3.0
    torso[-1, 3] = np.radians(2.0)
    assert metrics.settling_time(times, torso) is None


def test_acceleration_of_a_height():
    times = np.arange(0.0, 1.0, 0.001)
    assert metrics.vertical_acceleration(times, 0.5 * 3.0 * times**2) == pytest.approx(3.0)
    wave = metrics.vertical_acceleration(times, 0.01 * np.sin(10.0 * times))
    assert np.abs(wave + np.sin(10.0 * times))[30:-30].max() < 0.01
    assert not metrics.vertical_acceleration(times[:10], times[:10]).any()


def test_steps_beyond_limits_are_counted_by_kind():
    n = len(JOINTS)
    limits = Limits(
        -np.ones(n), np.ones(n), np.full(n, 5.0), np.full(n, 100.0), Ground(friction=0.5)
    )
    signals = {name: np.zeros((6, n)) for name in ("joint_position", "joint_velocity")}
    signals["joint_torque"], signals["ground_force"] = np.zeros((6, n)), np.zeros((6, 6))
    signals["foot_pose_l"] = signals["foot_pose_r"] = np.zeros((6, 6))
    assert not beyond_limits(signals, limits).any()
    signals["joint_position"][[1, 2], [3, 4]] = [1.01, -1.01]
    signals["joint_velocity"][0, [5, 6, 7]] = -6.0
    signals["joint_torque"][3:, 2] = 100.0
    # Sliding, holding, sliding without a load on the foot.
    signals["ground_force"][:3, :3] = [[0, 149.5, 300], [100, 100, 300], [9, 0, 10]]
    counted = beyond_limits(signals, limits).sum(axis=0)
    assert dict(zip(LIMITS, counted, strict=True)) == {
        "joint_angle": 2,
        "joint_speed": 1,
        "joint_torque": 3,
        "friction": 1,
    }


def test_the_run_knows_its_limits(make_result):
    result = make_result(steps=2)
    result.signals["joint_velocity"][700:720, 3] = 100.0
    assert result.metrics["steps_beyond_limits"]["joint_speed"] == 20
    assert result.metrics["max_com_vertical_acceleration_m_per_s2"] == 0.0


def test_what_drives_brake_is_work_as_what_they_drive():
    times = np.array([0.0, 0.5, 1.0])
    signals = {
        "joint_torque": np.array([[2.0, -1.0]] * 3),
        "joint_velocity": np.array([[1.0, 3.0]] * 3),
    }
    assert metrics.drive_work(times, metrics.drive_power(signals)) == pytest.approx(5.0)
