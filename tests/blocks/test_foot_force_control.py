"""What all force laws of a foot share, against the paper's equations 10 to 13, 16 and 21."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from one_foot import SENSOR, Foot, foot_angles
from pydrake.math import RollPitchYaw

from lola_drake.blocks.foot_force_control import (
    FORCE_CONTROLLED,
    FootForceControl,
    grip_of,
    limited_rate,
    modification_rate,
)
from lola_drake.signals import GAIT_PHASE, PERIOD, TASK_REFERENCE
from lola_drake.theory.foot_wrench import FootSensor, wrench_at_tcp
from lola_drake.theory.late_foot import TOUCHED, overdue_time, seeking_rate

WEIGHTLESS = FootSensor((0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0))
MEASURED = np.array([30.0, -20.0, 400.0, 8.0, -12.0, 3.0])
LIMIT, RATE_LIMIT = 0.08, 0.5


def test_full_blend_adds_force_control_and_com_dynamics():
    assert modification_rate(0.3, 0.2, 5.0, 1.0, 6.0) == pytest.approx(0.5)


def test_no_blend_returns_to_the_plan():
    assert modification_rate(0.3, 0.2, 0.05, 0.0, 6.0) == pytest.approx(-0.3)


@given(st.floats(0, 1), st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.1, 0.1))
def test_a_blend_between_lies_on_the_line(blend, force_rate, com_rate, deviation):
    ends = [modification_rate(force_rate, com_rate, deviation, b, 6.0) for b in (0.0, 1.0)]
    between = modification_rate(force_rate, com_rate, deviation, blend, 6.0)
    assert between == pytest.approx(ends[0] + blend * (ends[1] - ends[0]), abs=1e-9)


def test_command_is_the_plan_with_its_modification():
    foot = Foot()
    w, w_dot = TASK_REFERENCE.slice("w_l"), TASK_REFERENCE.slice("w_dot_l")
    foot.fix("task_reference", np.arange(6) / 100, w)
    foot.fix("task_reference", np.arange(6) / 10, w_dot)
    delta = np.array([0.01, -0.02, 0.03])
    foot.set_state("task_modification", delta)
    plan_w, plan_rate = np.arange(6) / 100, np.arange(6) / 10
    plan_w[FORCE_CONTROLLED] += delta
    plan_rate[FORCE_CONTROLLED] -= foot.params.position_gain * delta
    assert foot.output("task_command") == pytest.approx(np.r_[plan_w, plan_rate])


def test_the_modification_is_the_integral_of_what_the_command_adds_to_the_plan():
    """Eq. 11, of the angles about x and y and of the height, and of nothing else."""
    foot = Foot()
    plan_rate = np.arange(1.0, 7.0) / 10
    foot.fix("task_reference", plan_rate, TASK_REFERENCE.slice("w_dot_l"))
    foot.set_state("task_modification", [0.01, -0.02, 0.03])
    rate = foot.output("task_command")[6:] - plan_rate
    assert np.abs(rate[FORCE_CONTROLLED]).min() > 0.01
    foot.step()
    expected = np.array([0.01, -0.02, 0.03]) + PERIOD * rate[FORCE_CONTROLLED]
    assert foot.modification() == pytest.approx(expected, abs=1e-12)


def full_transform(measured, rotation):
    """Return the whole wrench of the ground at the TCP in T, by the 6x6 transform."""
    lever = np.array(SENSOR.p_TcpSensor)
    skew = np.array([np.cross(lever, axis) for axis in np.eye(3)]).T
    shift = np.block([[np.eye(3), np.zeros((3, 3))], [skew, np.eye(3)]])
    turn = np.kron(np.eye(2), rotation)
    wrench = turn @ shift @ measured
    support = np.array([0.0, 0.0, SENSOR.weight])
    return wrench + np.r_[support, np.cross(rotation @ SENSOR.p_TcpFoot, support)]


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.5])
def test_wrench_at_tcp_is_the_full_transform_of_a_level_foot(yaw):
    rotation = RollPitchYaw(0.0, 0.0, yaw).ToRotationMatrix().matrix()
    expected = full_transform(MEASURED, rotation)[[3, 4, 2]]
    assert wrench_at_tcp(MEASURED, 0.0, 0.0, yaw, SENSOR) == pytest.approx(expected)


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.5])
def test_wrench_at_tcp_errs_by_the_lean_squared(yaw):
    errors = []  # The third column of the rotation is left at first order.
    for lean in (0.02, 0.01):
        rotation = RollPitchYaw(lean, -0.7 * lean, yaw).ToRotationMatrix().matrix()
        wrench = wrench_at_tcp(MEASURED, *foot_angles(rotation), WEIGHTLESS)
        turned = np.kron(np.eye(2), rotation) @ MEASURED
        errors.append(np.abs(wrench - turned[[3, 4, 2]]).max())
    assert errors[0] < MEASURED[2] * 0.02**2
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.5])
def test_wrench_at_tcp_is_near_the_full_transform_of_a_leaning_foot(yaw):
    rotation = RollPitchYaw(0.01, -0.02, yaw).ToRotationMatrix().matrix()
    wrench = wrench_at_tcp(MEASURED, *foot_angles(rotation), SENSOR)
    expected = full_transform(MEASURED, rotation)[[3, 4, 2]]
    assert wrench == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.5])
def test_a_hanging_foot_weighs_nothing(yaw):
    weight = np.array([0.0, 0.0, -SENSOR.weight])
    lever = np.subtract(SENSOR.p_TcpFoot, SENSOR.p_TcpSensor)
    hanging = np.r_[weight, np.cross(lever, weight)]
    assert wrench_at_tcp(hanging, 0.0, 0.0, yaw, SENSOR) == pytest.approx(np.zeros(3), abs=1e-12)


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=60))
def test_modification_never_passes_its_limit(rates):
    delta = 0.0
    for rate in np.repeat(rates, 10).tolist():
        limited = limited_rate(rate, delta, LIMIT, RATE_LIMIT)
        assert abs(limited) <= RATE_LIMIT
        delta += PERIOD * limited
        assert abs(delta) <= LIMIT * (1 + 1e-12)


@given(st.floats(1e-3, 5), st.integers(1, 1000), st.sampled_from([-1.0, 1.0]))
def test_modification_leaves_its_limit_without_delay(rate, ticks_at_limit, side):
    delta = side * LIMIT
    for _ in range(ticks_at_limit):
        delta += PERIOD * limited_rate(side * 5.0, delta, LIMIT, RATE_LIMIT)
    back = limited_rate(-side * rate, delta, LIMIT, RATE_LIMIT)
    assert back == -side * min(rate, RATE_LIMIT)


def test_block_stops_at_its_limits_and_comes_back_at_once():
    foot = Foot(max_height=0.01)
    foot.blend(1.0)
    foot.press(300.0)
    foot.desire([0.0, 0.0, 900.0])
    foot.step(200)
    assert foot.modification()[2] == pytest.approx(-0.01)
    foot.desire([0.0, 0.0, 200.0])
    foot.step()
    assert foot.modification()[2] > -0.01


def test_angles_of_an_unloaded_foot_are_turned_against_the_inclination():
    foot = Foot()
    foot.blend(1.0)
    foot.press(0.0)
    foot.desire([30.0, -30.0, 100.0])
    foot.fix("torso_orientation", [0.04, -0.03, 0.0, 0.0])
    foot.step(2000)
    assert foot.modification()[:2] == pytest.approx([-0.04, 0.03], abs=1e-6)


def test_without_leveling_an_unloaded_foot_keeps_to_the_torso():
    foot = Foot(leveling=0.0)
    foot.blend(1.0)
    foot.press(0.0)
    foot.fix("torso_orientation", [0.04, -0.03, 0.0, 0.0])
    foot.step(100)
    assert foot.modification()[:2] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_angles_of_a_loaded_foot_ignore_the_inclination():
    foot = Foot()
    foot.blend(1.0)
    foot.press(foot.params.grip_force)
    foot.desire([0.0, 0.0, foot.params.grip_force])
    foot.fix("torso_orientation", [0.04, -0.03, 0.0, 0.0])
    foot.step(100)
    assert foot.modification() == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("name", ["x", "y", "gamma_z"])
def test_other_directions_are_those_of_the_plan(name):
    foot = Foot()
    foot.blend(1.0)
    foot.press(300.0)
    foot.desire([10.0, -10.0, 500.0])
    foot.step(50)
    index = {"x": 0, "y": 1, "gamma_z": 5}[name]
    assert foot.output("task_command")[[index, 6 + index]] == pytest.approx([0.0, 0.0])
    assert np.abs(foot.modification()).min() > 1e-4


def test_no_command_presses_a_loaded_foot_down_where_it_lifts_off(straight_walk):
    """The CoM has sunk: the foot is 3 cm higher than planned, and bears 300 N too much."""
    phase, reference = straight_walk["gait_phase"], straight_walk["task_reference"]
    lift_off = np.flatnonzero(np.diff(phase[:, GAIT_PHASE.slice("support").start]) < 0)[1] + 1
    foot, rates = Foot(), []
    for k in range(lift_off - 150, lift_off + 150):
        wanted = 588.0 * phase[k, GAIT_PHASE.slice("load").start]
        foot.fix("task_reference", reference[k])
        foot.fix("gait_phase", phase[k])
        foot.desire([0.0, 0.0, wanted])
        foot.press(wanted + 300.0)
        foot.set_state("task_modification", [0.0, 0.0, 0.03])
        rates.append(foot.output("task_command")[6 + 2])
    assert min(rates) > 0.0


def test_a_foot_is_overdue_from_its_planned_touchdown_to_its_first_touch():
    overdue, known = TOUCHED, []
    for planned, closed in [(1, 4), (1, 0), (0, 4), (0, 0), (1, 0), (1, 0), (1, 1), (1, 0), (0, 0)]:
        overdue = overdue_time(overdue, planned, closed)
        known.append(overdue)
    late = [PERIOD, 2 * PERIOD]
    assert known == [TOUCHED, TOUCHED, 0.0, 0.0, *late, TOUCHED, TOUCHED, 0.0]


@pytest.mark.parametrize("pad", range(4))
def test_any_pad_ends_the_search(pad):
    foot = Foot()
    foot.plan(1.0)
    foot.set_state("overdue", [0.1])
    foot.touch(np.zeros(4))
    foot.step()
    assert foot.state("overdue") == pytest.approx([0.1 + PERIOD])
    foot.touch(np.eye(4)[pad])
    foot.step()
    assert foot.state("overdue") == pytest.approx([TOUCHED])


@pytest.mark.parametrize(
    ("overdue", "rate", "expected"),
    [
        (TOUCHED, 0.1, 0.1),
        (0.03, 0.1, 0.1),
        (0.05, 0.1, -0.05),
        (0.07, 0.1, -0.2),
        (1.0, 0.1, -0.2),
        (1.0, -0.1, -0.2),
        (1.0, -0.3, -0.3),
    ],
)
def test_a_late_foot_goes_down_at_least_at_the_speed_of_its_search(overdue, rate, expected):
    assert seeking_rate(rate, overdue, 0.03, 0.04, 0.2) == pytest.approx(expected)


def test_a_late_foot_seeks_the_ground_until_it_touches():
    foot = Foot(search_speed=0.2, search_onset=0.03, search_ramp=0.04)
    foot.blend(1.0)
    foot.press(0.0)
    foot.plan(0.0)
    foot.step()
    foot.plan(1.0)
    foot.step(31)
    assert foot.modification()[2] == pytest.approx(0.0, abs=1e-12)
    foot.step(140)
    assert foot.modification()[2] == pytest.approx(-0.2 * (0.14 - 0.02), abs=1e-3)
    assert foot.modification()[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    foot.touch([0.0, 1.0, 0.0, 0.0])
    foot.step()
    foot.touch(0.0)  # It bounces.
    reached = foot.modification()[2]
    foot.step(200)
    assert foot.modification()[2] == pytest.approx(reached)


def test_the_search_ends_at_the_limit_of_the_modification():
    foot = Foot(max_height=0.03)
    foot.blend(1.0)
    foot.press(0.0)
    foot.plan(0.0)
    foot.step()
    foot.plan(1.0)
    foot.step(600)
    assert foot.modification()[2] == pytest.approx(-0.03)


@pytest.mark.parametrize("speed", [0.0, 0.2])
def test_a_foot_that_unloads_is_not_late(speed):
    """It stood on the ground; that its switches open before its planned lift-off says nothing."""
    foot = Foot(search_speed=speed)
    foot.blend(1.0)
    foot.press(0.0)
    foot.plan(1.0)
    foot.touch(1.0)
    foot.step(10)
    foot.touch(0.0)
    foot.step(200)
    assert foot.modification()[2] == pytest.approx(0.0, abs=1e-12)


def test_without_a_speed_a_late_foot_waits_for_its_load():
    foot = Foot(search_speed=0.0)
    foot.blend(1.0)
    foot.press(0.0)
    foot.plan(0.0)
    foot.step()
    foot.plan(1.0)
    foot.step(300)
    assert foot.modification()[2] == pytest.approx(0.0, abs=1e-12)


def test_the_wrench_is_turned_by_the_foot_as_it_is_commanded():
    """Plan and modification count together, whichever of them tilts the foot."""
    law = FootForceControl.laws["contact_wrench"]
    planned = law(MEASURED, [0, 0, 0, 0.05, -0.03, 0.2], [0.0, 0.0, 0.0], SENSOR)
    modified = law(MEASURED, [0, 0, 0, 0.01, 0.02, 0.2], [0.04, -0.05, 0.01], SENSOR)
    assert modified == pytest.approx(planned)
    assert planned != pytest.approx(law(MEASURED, [0, 0, 0, 0, 0, 0.2], [0.0, 0.0, 0.0], SENSOR))


def test_a_foot_grips_in_proportion_to_its_load_between_none_and_all():
    assert [grip_of(force, 100.0) for force in (-50.0, 0.0, 25.0, 100.0, 300.0)] == [
        0.0,
        0.0,
        0.25,
        1.0,
        1.0,
    ]
