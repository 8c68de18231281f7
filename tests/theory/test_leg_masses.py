"""The lumped legs: mass, angular momentum, and the agreement with the robot's full model."""

from dataclasses import replace

import numpy as np
import pytest

from lola_drake.blocks.walking_pattern import WalkingPatternParams, continued, standing_request
from lola_drake.robot import Kinematics, leg_model, posture, solve_posture
from lola_drake.signals import PERIOD, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.leg_masses import LegMotion, derivative
from lola_drake.theory.step_plan import PatternModel, plan_step

PARAMS = WalkingPatternParams(double_support=0.3, zmp_forward=-0.02)
"""The gait in which the figures below were measured; they depend on it a little."""
STEP = 0.02
TIME = STEP * np.arange(50)
SIDES = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@pytest.fixture(scope="module")
def legs(kinematics):
    return leg_model(kinematics)


def angular_momentum(legs, step, com, heading, tcps, yaws):
    """Return the angular momentum (n, 3) of a CoM (n, 3), TCPs (n, 3) and yaws (n)."""
    feet = np.stack([np.column_stack(foot).T for foot in zip(tcps, yaws, strict=True)], axis=1)
    return LegMotion(legs, step, heading, feet).angular_momentum(com.T).T


def standing():
    """Return the CoM, heading, TCPs and yaws of a robot that stands."""
    n = len(TIME)
    com = np.tile([-0.02, 0.0, 0.85], (n, 1))
    tcps = tuple(np.tile([0.0, side * 0.115, 0.0], (n, 1)) for side in (1, -1))
    return com, np.zeros(n), tcps, (np.zeros(n), np.zeros(n))


def swinging():
    """Return a motion in which the left foot swings forward, turns and is lifted."""
    com, heading, (left, right), (yaw_left, yaw_right) = standing()
    phase = 0.5 - 0.5 * np.cos(np.pi * TIME / TIME[-1])
    swing = np.column_stack([0.4 * phase, 0.02 * phase, 0.05 * np.sin(np.pi * phase) ** 2])
    moving = com + np.column_stack([0.2 * phase, -0.02 * phase, 0 * phase])
    return moving, heading + 0.1 * phase, (left + swing, right), (yaw_left + 0.2 * phase, yaw_right)


def test_derivative_is_numpy_s_gradient():
    values = np.random.default_rng(0).normal(size=(3, 2, 20))
    expected = np.gradient(values, STEP, axis=-1)
    assert derivative(values, STEP) == pytest.approx(expected, rel=1e-12)


def test_masses_add_up_to_the_robot(legs):
    assert legs.mass == pytest.approx(60.0, abs=1e-6)


def test_legs_are_as_long_as_the_robot_s(legs, kinematics):
    kinematics.update(np.zeros(24))
    hip_to_tcp = legs.thigh_length + legs.shank_length + legs.p_TcpAnkle[2]
    tcp = kinematics.w[2] + kinematics.centroidal_inertia(np.zeros(24))[0][2]
    assert legs.p_THip[2] - hip_to_tcp == pytest.approx(tcp)


def test_masses_are_positive_and_inside_their_links(legs):
    assert min(legs.body_mass, legs.thigh_mass, legs.shank_mass, legs.foot_mass) > 0
    assert 0 < legs.thigh_com < legs.thigh_length
    assert 0 < legs.shank_com < legs.shank_length
    assert min(legs.thigh_inertia, legs.shank_inertia) > 0


def test_standing_has_no_angular_momentum(legs):
    assert angular_momentum(legs, STEP, *standing()) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("velocity", [[0.5, 0.0, 0.0], [0.0, -0.3, 0.0], [0.1, 0.2, 0.4]])
def test_rigid_translation_has_no_angular_momentum(legs, velocity):
    com, heading, tcps, yaws = standing()
    shift = TIME[:, None] * velocity
    momentum = angular_momentum(
        legs, STEP, com + shift, heading, tuple(tcp + shift for tcp in tcps), yaws
    )
    assert momentum == pytest.approx(0.0, abs=1e-9)


def test_momentum_does_not_depend_on_a_common_velocity(legs):
    com, heading, tcps, yaws = swinging()
    shift = TIME[:, None] * [0.5, -0.2, 0.0]
    momentum = angular_momentum(
        legs, STEP, com + shift, heading, tuple(tcp + shift for tcp in tcps), yaws
    )
    still = angular_momentum(legs, STEP, com, heading, tcps, yaws)
    assert momentum == pytest.approx(still, abs=1e-9)


def test_mirrored_motion_has_the_mirrored_momentum(legs):
    com, heading, (left, right), (yaw_left, yaw_right) = swinging()
    momentum = angular_momentum(legs, STEP, com, heading, (left, right), (yaw_left, yaw_right))
    mirrored = angular_momentum(
        legs, STEP, com * SIDES, -heading, (right * SIDES, left * SIDES), (-yaw_right, -yaw_left)
    )
    assert mirrored == pytest.approx(momentum * -SIDES, abs=1e-9)
    assert np.abs(momentum).max(axis=0).min() > 0.05


def test_turned_motion_has_the_turned_momentum(legs):
    com, heading, tcps, yaws = swinging()
    c, s = np.cos(0.8), np.sin(0.8)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = angular_momentum(
        legs,
        STEP,
        com @ rotation.T,
        heading + 0.8,
        tuple(tcp @ rotation.T for tcp in tcps),
        tuple(yaw + 0.8 for yaw in yaws),
    )
    expected = angular_momentum(legs, STEP, com, heading, tcps, yaws) @ rotation.T
    assert turned == pytest.approx(expected, abs=1e-9)


def test_backward_motion_has_the_opposite_momentum(legs):
    com, heading, tcps, yaws = swinging()
    forward = angular_momentum(legs, STEP, com, heading, tcps, yaws)
    backward = angular_momentum(
        legs,
        STEP,
        com[::-1],
        heading[::-1],
        tuple(tcp[::-1] for tcp in tcps),
        tuple(yaw[::-1] for yaw in yaws),
    )
    assert backward == pytest.approx(-forward[::-1], abs=1e-9)


def test_foot_that_swings_forward_turns_the_robot_backward(legs):
    com, heading, (left, right), yaws = standing()
    swing = TIME[:, None] * [0.2, 0.0, 0.0]
    momentum = angular_momentum(legs, STEP, com, heading, (left + swing, right), yaws)
    # Below the CoM, forward is a negative rotation about y.
    assert momentum[:, 1].max() < -0.3


@pytest.fixture(scope="module")
def planned_step(legs):
    """Return the second step of a walk with steps of 0.4 m."""
    model = PatternModel(
        timing=PARAMS.timing(),
        legs=legs,
        p_TcpZmp=np.array([PARAMS.zmp_forward, PARAMS.zmp_inward]),
        blend_time=PARAMS.blend_time,
        contact_blend_time=PARAMS.contact_blend_time,
        ground_stiffness=PARAMS.ground_stiffness,
        period=PERIOD,
    )
    steps = np.tile([0.4, 0.0, 0.0, 0.0], (3, 1))
    request = replace(standing_request(PARAMS), displacements=steps)
    first = plan_step(model, request)
    following = replace(
        continued(request, first, len(first.gait_phase) - 1),
        swing=1 - request.swing,
        load=first.load,
        path=first.path,
        support=PARAMS.double_support,
    )
    return plan_step(model, following)


@pytest.fixture(scope="module")
def both_momenta(legs, kinematics, planned_step):
    """Return the angular momentum of the lumped and of the full model along the step."""
    rows = slice(None, None, round(STEP / PERIOD))
    plan, task = planned_step.planned_motion[rows], planned_step.task_reference[rows]
    com = plan[:, PLANNED_MOTION.slice("com")]
    feet = [plan[:, PLANNED_MOTION.slice(name)] for name in ("foot_l", "foot_r")]
    heading = plan[:, PLANNED_MOTION.index("heading")]
    lumped = angular_momentum(
        legs,
        STEP,
        com,
        heading,
        tuple(foot[:, :3] for foot in feet),
        tuple(foot[:, 3] for foot in feet),
    )
    w = np.column_stack(
        [task[:, TASK_REFERENCE.slice("w_l")], task[:, TASK_REFERENCE.slice("w_r")]]
    )
    return lumped, full_momentum(kinematics, w, com)


def full_momentum(kinematics, w, com):
    """Return the full model's momentum about its CoM; the torso is upright, the heading zero."""
    plant = kinematics.plant
    context = plant.CreateDefaultContext()
    q = posture(0.4, 0.8)
    angles, torso = [], []
    for w_k, com_k in zip(w, com, strict=True):
        q = solve_posture(kinematics, w_k, q)
        plant.SetPositions(context, np.r_[1.0, np.zeros(6), q])
        angles.append(q)
        torso.append(com_k - plant.CalcCenterOfMassPositionInWorld(context))
    rates = np.gradient(np.array(angles), STEP, axis=0)
    torso_velocity = np.gradient(np.array(torso), STEP, axis=0)
    momentum = []
    for k, com_k in enumerate(com):
        plant.SetPositions(context, np.r_[1.0, np.zeros(3), torso[k], angles[k]])
        plant.SetVelocities(context, np.r_[np.zeros(3), torso_velocity[k], rates[k]])
        momentum.append(plant.CalcSpatialMomentumInWorldAboutPoint(context, com_k).rotational())
    return np.array(momentum)


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_pitching_momentum_agrees_with_the_full_model_within_3_percent(both_momenta):
    lumped, full = both_momenta
    assert rms((lumped - full)[:, 1]) < 0.03 * rms(full[:, 1])


def test_its_rate_agrees_within_7_percent(both_momenta):
    lumped, full = (np.gradient(momentum[:, 1], STEP) for momentum in both_momenta)
    assert rms(lumped - full) < 0.07 * rms(full)


def test_yawing_momentum_agrees_within_15_percent(both_momenta):
    lumped, full = both_momenta
    assert rms((lumped - full)[:, 2]) < 0.15 * rms(full[:, 2])


def test_rolling_momentum_agrees_roughly(both_momenta):
    # Small as it is, it is where the lumped legs are worst: the pelvis' joints are not in them.
    lumped, full = both_momenta
    assert rms((lumped - full)[:, 0]) < 0.5 * rms(full[:, 0])
    assert rms((lumped - full)[:, 0]) < 0.1 * rms(full[:, 1])
