"""The robot: its joints and mirror symmetry, and the controller's kinematics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from lola_drake.robot import (
    FOOT_TASK,
    MIRRORED_JOINTS,
    PADS,
    Kinematics,
    foot_angle_rates,
    foot_angles,
    foot_sensor_geometry,
    leg_model,
    posture,
    solve_posture,
)
from lola_drake.signals import JOINTS
from lola_drake.theory.constants import GRAVITY

BENT = posture(hip=0.4, knee=0.8)
near_bent = st.tuples(*len(JOINTS) * [st.floats(-0.3, 0.3)]).map(lambda change: BENT + change)
MIRRORED_TASK = np.array([1, -1, 1, -1, 1, -1])


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


def task(kinematics, q):
    """Return w at the joint angles, and its Jacobian."""
    kinematics.update(q)
    return kinematics.w.copy(), kinematics.jacobian.copy()


def test_robot_is_lola(kinematics):
    plant = kinematics.plant
    names = [plant.get_joint_actuator(i).joint().name() for i in plant.GetJointActuatorIndices()]
    assert tuple(names) == JOINTS
    assert kinematics.mass == pytest.approx(60.0)
    lower, upper = kinematics.position_limits
    assert np.all(lower < upper)
    assert np.all(kinematics.velocity_limits > 0)
    assert np.all(kinematics.effort_limits > 0)


@settings(max_examples=8)
@given(q=near_bent)
def test_jacobian_is_the_derivative(kinematics, q):
    h = 1e-6
    _, jacobian = task(kinematics, q)
    for joint in range(len(JOINTS)):
        step = h * np.eye(len(JOINTS))[joint]
        ahead, _ = task(kinematics, q + step)
        behind, _ = task(kinematics, q - step)
        np.testing.assert_allclose((ahead - behind) / (2 * h), jacobian[:, joint], atol=1e-8)


angle = st.floats(-0.6, 0.6)


@given(angle, angle, st.floats(-3, 3), st.tuples(*3 * [st.floats(-1, 1)]))
def test_angle_rates_are_the_derivatives_of_the_angles(roll, pitch, yaw, omega):
    rotation, h = RollPitchYaw(roll, pitch, yaw).ToRotationMatrix().matrix(), 1e-6
    spin = np.cross(np.array(omega), np.eye(3)).T
    ahead, behind = (np.array(foot_angles(rotation + d * spin @ rotation)) for d in (h, -h))
    np.testing.assert_allclose(
        foot_angle_rates(rotation) @ omega, (ahead - behind) / (2 * h), atol=1e-7
    )


@given(angle, st.floats(-3, 3))
def test_foot_angles_are_about_the_axes_of_the_foot(lean, yaw):
    """A foot that rolls about its own length has no pitch, wherever it points."""
    turned = RollPitchYaw(0, 0, yaw).ToRotationMatrix()
    rolled = foot_angles((turned @ RollPitchYaw(lean, 0, 0).ToRotationMatrix()).matrix())
    pitched = foot_angles((turned @ RollPitchYaw(0, lean, 0).ToRotationMatrix()).matrix())
    np.testing.assert_allclose(rolled, [np.sin(lean), 0, yaw], atol=1e-12)
    np.testing.assert_allclose(pitched, [0, np.sin(lean), yaw], atol=1e-12)


def test_joints_are_paired_left_and_right():
    pairs = np.array(MIRRORED_JOINTS)
    np.testing.assert_array_equal(pairs[pairs], np.arange(len(JOINTS)))
    assert [JOINTS[i] for i in pairs if i == pairs[i]] == ["tbr", "tba", "tvp", "tvt"]


@given(q=near_bent)
def test_mirrored_posture_has_mirrored_feet(kinematics, mirror_joints, q):
    """The model is symmetric: also its masses, since w is relative to the CoM."""
    w, _ = task(kinematics, q)
    mirror, _ = task(kinematics, mirror_joints @ q)
    np.testing.assert_allclose(mirror[FOOT_TASK:], MIRRORED_TASK * w[:FOOT_TASK], atol=1e-12)
    np.testing.assert_allclose(mirror[:FOOT_TASK], MIRRORED_TASK * w[FOOT_TASK:], atol=1e-12)


def test_bent_posture_is_symmetric_and_has_level_feet(kinematics, mirror_joints):
    np.testing.assert_allclose(mirror_joints @ BENT, BENT)
    w, _ = task(kinematics, BENT)
    np.testing.assert_allclose(w[3:6], 0, atol=1e-12)
    np.testing.assert_allclose(w[:6], MIRRORED_TASK * w[6:], atol=1e-12)


def test_limits_are_nearly_mirrored(kinematics, mirror_joints):
    """They were measured on the robot, joint by joint."""
    limits = kinematics.position_limits
    mirrored = np.sort([mirror_joints @ limit for limit in limits], axis=0)
    np.testing.assert_allclose(mirrored, limits, atol=np.deg2rad(3.5))


def test_solved_posture_reaches_the_feet(kinematics):
    w, _ = task(kinematics, BENT)
    w += np.array([0.1, 0.02, 0.03, 0.05, -0.05, 0.1, -0.1, 0, 0, 0, 0, 0])
    q = solve_posture(kinematics, w, BENT)
    np.testing.assert_allclose(task(kinematics, q)[0], w, atol=1e-9)


def test_posture_out_of_reach_is_an_error(kinematics):
    w, _ = task(kinematics, BENT)
    with pytest.raises(ValueError, match="no posture reaches"):
        solve_posture(kinematics, w - np.array([0, 0, 0.5, 0, 0, 0] * 2), BENT)


def test_lumped_masses_are_those_of_the_robot(kinematics):
    legs = leg_model(kinematics)
    assert legs.mass == pytest.approx(kinematics.mass)
    plant, context = kinematics.plant, kinematics.context
    plant.SetPositions(context, np.r_[1.0, np.zeros(plant.num_positions() - 1)])
    below_hip = -legs.thigh_com, -legs.thigh_length - legs.shank_com
    ankle = -legs.thigh_length - legs.shank_length
    foot = ankle - legs.p_TcpAnkle[2] + legs.p_TcpFoot[2]
    leg = (
        legs.thigh_mass * below_hip[0] + legs.shank_mass * below_hip[1] + legs.foot_mass * foot
    ) + (legs.thigh_mass + legs.shank_mass + legs.foot_mass) * legs.p_THip[2]
    height = (legs.body_mass * legs.p_TBody[2] + 2 * leg) / legs.mass
    com = plant.CalcCenterOfMassPositionInWorld(context)
    assert height == pytest.approx(com[2], abs=1e-9)


def test_sensor_lies_over_the_foot_that_it_carries(kinematics):
    p_TcpSensor, weight, p_TcpFoot = foot_sensor_geometry(kinematics)
    assert p_TcpSensor[2] > p_TcpFoot[2] > 0
    assert 0 < weight < 0.05 * kinematics.mass * GRAVITY


@pytest.mark.parametrize("foot", [0, 1])
def test_pads_lie_where_the_contact_model_has_them(kinematics, foot):
    kinematics.update(BENT)
    points, _ = kinematics.pads(foot)
    np.testing.assert_allclose(points, [[pad.x, pad.y] for pad in PADS], atol=1e-9)


def test_inertia_about_the_com_is_plausible_and_symmetric(kinematics):
    com, inertia = kinematics.centroidal_inertia(BENT)
    np.testing.assert_allclose(com[1], 0, atol=1e-9)
    np.testing.assert_allclose(inertia, inertia.T)
    np.testing.assert_allclose(inertia[1, [0, 2]], 0, atol=1e-9)
    # Between a compact body and a rod of the robot's height.
    assert np.all(np.diag(inertia)[:2] > 60 * 0.3**2)
    assert np.all(np.diag(inertia) < 60 * 1.8**2 / 12)
