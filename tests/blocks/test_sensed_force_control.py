"""The paper's law with the sensed contact area and without small angles, against eq. 6, 13, 15."""

import numpy as np
import pytest
from one_foot import AREA_STIFFNESS, SENSOR, Foot, U, foot_angles
from pydrake.math import RollPitchYaw

from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.blocks.sensed_force_control import SensedForceControl, exact_wrench_at_tcp
from lola_drake.robot import PADS
from lola_drake.signals import PERIOD, TASK_REFERENCE
from lola_drake.theory.contact_model import contact_matrix
from lola_drake.theory.sensed_contact import foot_axes, kept, pad_model

MODEL = pad_model(PADS, AREA_STIFFNESS)
AMPLIFIED = max(kept(s) / s for s in np.linspace(0.01, 1.0, 1000))
"""How much more a direction may move that keeps a part of its stiffness."""

SWITCHES = [{"sensed_area": True}, {"exact_angles": True}, {}]


def sensed_foot(pads=1.0, **params):
    foot = Foot(SensedForceControl, **params)
    foot.blend(1.0)
    foot.touch(pads)
    foot.set_state("pad_share", np.full(4, 1.0) * pads)
    return foot


@pytest.mark.parametrize("switches", SWITCHES)
def test_a_level_foot_on_all_pads_obeys_eq_15(switches):
    feet = [sensed_foot(**switches), Foot(HybridForceControl)]
    for foot in feet:
        foot.blend(1.0)
        foot.press(300.0, (2.0, -3.0))
        foot.desire([6.0, -8.0, 400.0], [20.0, 30.0, 1000.0])
    found, expected = (foot.output("force_rate") for foot in feet)
    if "exact_angles" in switches:
        assert found == pytest.approx(expected, rel=1e-9)
    assert np.abs(found / expected - 1).max() < 1e-12


FRONT = np.array([0.0, 0.0, 1.0, 1.0])


def test_the_pole_stays_that_of_delta_in_directions_that_keep_their_stiffness():
    """On the front pads: the force with the torque that belongs to it, and the rolling torque."""
    foot, front = sensed_foot(FRONT, sensed_area=True), contact_matrix(PADS[2:], AREA_STIFFNESS)
    start = np.array([0.0, -0.095 * 300.0, 300.0])
    step = np.array([4.0, -0.095 * 40.0, 40.0])
    foot.desire(start + step)
    for _ in range(20):
        wrench = start + front @ foot.modification()
        foot.press(wrench[2], wrench[:2])
        foot.step()
    left = start + step - (start + front @ foot.modification())
    assert left[[0, 2]] / step[[0, 2]] == pytest.approx(np.full(2, np.exp(-1)), rel=0.03)


LEFT = np.array([1.0, 0.0, 1.0, 0.0])


@pytest.mark.parametrize(
    ("pads", "x", "y"),
    [
        (FRONT, 0.095, 0.0),
        (1 - FRONT, -0.095, 0.0),
        (LEFT, 0.0, 0.09),
        (1 - LEFT, 0.0, -0.09),
    ],
    ids=["front", "heel", "left", "right"],
)
def test_a_loaded_foot_lets_its_open_pads_down(pads, x, y):
    """Asked for a CoP at its middle, it turns until they find the ground."""
    foot = sensed_foot(pads, sensed_area=True)
    foot.press(300.0, (y * 300.0, -x * 300.0))
    foot.desire([0.0, 0.0, 300.0])
    s_x, s_y, z = foot.output("force_rate")
    # The height of a point x, y of the sole is z + y s_x - x s_y; the open pads are opposite.
    assert z - y * s_x + x * s_y < -0.05
    assert abs(s_x if x else s_y) < 1e-9


def test_pads_count_more_and_less_over_the_ramp():
    foot = sensed_foot(sensed_area=True)
    foot.touch([1.0, 0.0, 1.0, 0.0])
    foot.step(10)
    assert foot.state("pad_share") == pytest.approx([1.0, 0.5, 1.0, 0.5])
    foot.step(10)
    assert foot.state("pad_share") == pytest.approx([1.0, 0.0, 1.0, 0.0])
    foot.touch(1.0)
    foot.step(5)
    assert foot.state("pad_share") == pytest.approx([1.0, 0.25, 1.0, 0.25])


def test_without_the_sensed_area_the_switches_say_nothing():
    foot = sensed_foot(exact_angles=True)
    foot.touch(0.0)
    foot.step(30)
    assert (foot.state("pad_share") == 1.0).all()


def test_a_foot_without_contact_returns_to_its_plan_and_turns_level():
    foot = sensed_foot(0.0, sensed_area=True)
    foot.press(0.0)
    foot.desire([10.0, 10.0, 300.0])
    foot.fix("torso_orientation", [0.04, -0.03, 0.0, 0.0])
    foot.set_state("task_modification", [0.1, 0.1, 0.02])
    expected = -6.0 * np.array([0.14, 0.07, 0.02])
    assert foot.output("force_rate") == pytest.approx(expected)


def test_the_rate_is_continuous_and_bounded_while_the_pads_open():
    foot = sensed_foot(sensed_area=True)
    foot.press(200.0, (2.0, -3.0))
    foot.desire([6.0, -8.0, 260.0])
    rates = []
    for pads in ([0, 1, 1, 1], [0, 0, 1, 1], [0, 0, 1, 0], [0, 0, 0, 0]):
        foot.touch(np.array(pads, dtype=float))
        for _ in range(30):
            foot.set_state("task_modification", np.zeros(3))
            rates.append(foot.output("force_rate"))
            foot.step()
    rates = np.array(rates) * [MODEL.radius, MODEL.radius, 1.0]
    # The errors: at most the force, and the same at the corner of a pad.
    most = (60.0 + 200.0 * 0.15 / MODEL.radius) / 0.02 * AMPLIFIED / MODEL.stiffness
    assert np.abs(rates).max() < most
    assert np.abs(np.diff(rates, axis=0)).max() < 0.5 * np.abs(rates).max()
    # Still loaded, it goes on as if all pads had contact.
    assert rates[-1] == pytest.approx(rates[0], rel=1e-6)


@pytest.mark.parametrize("law", [SensedForceControl, HybridForceControl])
@pytest.mark.parametrize("exact", [True, False])
def test_the_foot_is_as_the_plan_and_its_modification_together_have_it(law, exact):
    """What of its angles is planned and what is modified makes no difference to its wrench."""
    whole, apart = (
        Foot(law, **({"exact_angles": exact} if law is SensedForceControl else {}))
        for _ in range(2)
    )
    w = TASK_REFERENCE.slice("w_l")
    for foot, planned, added in (
        (whole, [0, 0, 0, 0.2, -0.1, 0.3], [0.0, 0.0, 0.0]),
        (apart, [0, 0, 0, 0.05, 0.1, 0.3], [0.15, -0.2, 0.01]),
    ):
        foot.fix("measured_wrench", MEASURED, slice(0, 6))
        foot.fix("task_reference", planned, w)
        foot.set_state("task_modification", added)
    assert apart.output("contact_wrench") == pytest.approx(whole.output("contact_wrench"))


MEASURED = np.array([30.0, -20.0, 400.0, 8.0, -12.0, 3.0])


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.17, -0.2, 0.35), (-0.3, 0.25, -2.5)])
def test_the_exact_wrench_is_the_full_transform(angles):
    rotation = RollPitchYaw(*angles).ToRotationMatrix().matrix()
    lever = np.array(SENSOR.p_TcpSensor)
    force, torque = MEASURED[:3], MEASURED[3:] + np.cross(lever, MEASURED[:3])
    weight = np.array([0.0, 0.0, SENSOR.weight])
    torque_T = rotation @ torque + np.cross(rotation @ SENSOR.p_TcpFoot, weight)
    expected = [torque_T[0], torque_T[1], (rotation @ force + weight)[2]]
    axes = foot_axes(*foot_angles(rotation))
    assert exact_wrench_at_tcp(MEASURED, axes, SENSOR) == pytest.approx(expected)


@pytest.mark.parametrize("yaw", [0.35, -1.2])
def test_a_turned_foot_decays_about_its_own_axes(yaw):
    """The torque error that a turned foot meets about its x axis moves its roll alone."""
    foot = sensed_foot(exact_angles=True)
    foot.fix("task_reference", yaw, TASK_REFERENCE.slice("w_l").start + 5)
    foot.press(300.0)
    felt = foot.output("contact_wrench")
    foot.desire(felt + [10.0 * np.cos(yaw), 10.0 * np.sin(yaw), 0.0])
    rate = foot.output("force_rate")
    expected = (1 - np.exp(-PERIOD / 0.02)) / PERIOD * 10.0 / U[0, 0]
    assert rate == pytest.approx([expected, 0.0, 0.0], abs=1e-9)
