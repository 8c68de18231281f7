"""Plans of single steps: they join, they obey mechanics, and they are the same mirrored."""

from dataclasses import replace

import numpy as np
import pytest

from lola_drake.blocks.walking_pattern import (
    WalkingPatternParams,
    continued,
    standing_request,
)
from lola_drake.robot import Kinematics, leg_model
from lola_drake.signals import GAIT_PHASE, IDEAL_WRENCH, PERIOD, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import LEFT, RIGHT
from lola_drake.theory.leg_masses import LegMotion
from lola_drake.theory.step_plan import PatternModel, plan_step, zmp_shift
from lola_drake.theory.step_request import HORIZON

PARAMS = WalkingPatternParams()
STRAIGHT = np.tile([0.4, 0.0, 0.0, 0.0], (6, 1))
TURNING = np.tile([0.25, 0.03, 0.2, 0.0], (6, 1))
WALKS = ["straight", "turning"]
SIDES = np.array([1.0, -1.0, 1.0])
"""What mirroring at the x-z plane does to a vector."""


@pytest.fixture(scope="module")
def model():
    return PatternModel(
        timing=PARAMS.timing(),
        legs=leg_model(Kinematics()),
        p_TcpZmp=np.array([PARAMS.zmp_forward, PARAMS.zmp_inward]),
        blend_time=PARAMS.blend_time,
        contact_blend_time=PARAMS.contact_blend_time,
        ground_stiffness=PARAMS.ground_stiffness,
        period=PERIOD,
    )


def walk(model, steps, start=None):
    """Return request and plan of every step, the closing one included."""
    request = replace(start or standing_request(PARAMS), displacements=steps[:HORIZON])
    done = []
    for k in range(len(steps) + 1):
        plan = plan_step(model, request)
        done.append((request, plan))
        request = replace(
            continued(request, plan, len(plan.gait_phase) - 1),
            step_index=k + 1,
            swing=1 - request.swing,
            load=plan.load,
            path=plan.path,
            support=PARAMS.double_support,
            displacements=steps[k + 1 : k + 1 + HORIZON],
        )
    return done


@pytest.fixture(scope="module")
def walks(model):
    return {"straight": walk(model, STRAIGHT), "turning": walk(model, TURNING)}


@pytest.fixture(params=WALKS)
def plans(walks, request):
    return [plan for _, plan in walks[request.param]]


def planned(plan, name):
    return plan.planned_motion[:, PLANNED_MOTION.slice(name)]


def derivative(values):
    """Return central differences in the rows that have neighbours."""
    return (values[2:] - values[:-2]) / (2 * PERIOD)


def unturn(heading, vectors):
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = vectors.T
    return np.column_stack([c * x + s * y, c * y - s * x, z])


@pytest.mark.parametrize("name", ["com", "com_velocity", "heading", "foot_l", "foot_r"])
def test_each_plan_begins_where_the_last_one_ends(plans, name):
    for last, following in zip(plans, plans[1:], strict=False):
        assert planned(following, name)[0] == pytest.approx(planned(last, name)[-1], abs=1e-9)


def test_zmp_is_continuous_between_plans(plans):
    for last, following in zip(plans, plans[1:], strict=False):
        assert planned(following, "zmp")[0] == pytest.approx(planned(last, "zmp")[-1], abs=1e-9)


@pytest.mark.parametrize("name", ["w_l", "w_r", "toes"])
def test_task_reference_is_continuous_between_plans(plans, name):
    part = TASK_REFERENCE.slice(name)
    for last, following in zip(plans, plans[1:], strict=False):
        before, after = last.task_reference[-1, part], following.task_reference[0, part]
        assert after == pytest.approx(before, abs=1e-9)


def test_force_control_is_continuous_between_plans(plans):
    for last, following in zip(plans, plans[1:], strict=False):
        for name in ("load", "blend"):
            part = GAIT_PHASE.slice(name)
            before, after = last.gait_phase[-1, part], following.gait_phase[0, part]
            assert after == pytest.approx(before, abs=1e-9)


def test_walk_arrives_where_it_is_asked_to(walks):
    *_, (_, last), (_, closing) = walks["straight"]
    assert last.path == pytest.approx([6 * 0.4, 0.0, 0.0])
    assert closing.path == pytest.approx(last.path)


def test_later_steps_hardly_move_the_zmp(walks):
    # The steps beyond the horizon are the news in every plan.
    for _, plan in walks["straight"][1:-1]:
        assert np.abs(plan.zmp_shift).max() < 0.02


def test_the_toe_of_the_swing_foot_alone_is_lifted(walks):
    assert PARAMS.toe_lift > 0.05
    for request, plan in walks["straight"][:-1]:
        toes = plan.task_reference[:, TASK_REFERENCE.slice("toes")]
        swing, stance = toes[:, request.swing], toes[:, 1 - request.swing]
        assert np.ptp(swing) == pytest.approx(PARAMS.toe_lift, rel=1e-3)
        assert swing[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-9)
        assert stance == pytest.approx(np.zeros(len(stance)), abs=1e-9)


@pytest.mark.parametrize("name", ["w_l", "w_r", "toes"])
def test_rates_are_the_derivatives_of_the_positions(plans, name):
    rate = {"w_l": "w_dot_l", "w_r": "w_dot_r", "toes": "toe_rates"}[name]
    for plan in plans:
        position = plan.task_reference[:, TASK_REFERENCE.slice(name)]
        expected = plan.task_reference[1:-1, TASK_REFERENCE.slice(rate)]
        error = np.abs(derivative(position) - expected).max(axis=1)
        # The sinking-in follows the load, whose rate jumps at the ends of its ramp.
        assert np.quantile(error, 0.99) < 2e-4
        assert error.max() < 0.005


def test_com_velocity_is_the_derivative_of_the_com(plans):
    for plan in plans:
        velocity = planned(plan, "com_velocity")[1:-1]
        assert derivative(planned(plan, "com")) == pytest.approx(velocity, abs=1e-4)


def test_ideal_force_accelerates_the_mass(plans, model):
    for plan in plans:
        acceleration = derivative(planned(plan, "com_velocity"))
        expected = model.legs.mass * (acceleration + [0, 0, GRAVITY])
        force = plan.ideal_wrench[1:-1, IDEAL_WRENCH.slice("F")]
        heading = planned(plan, "heading")[1:-1, 0]
        # The jerk jumps in the knots of the CoM's spline.
        assert force == pytest.approx(unturn(heading, expected), abs=2.0)


def test_ideal_torque_is_that_of_the_force_in_the_zmp(plans):
    for plan in plans:
        heading = planned(plan, "heading")[:, 0]
        load = plan.gait_phase[:, GAIT_PHASE.slice("load")]
        ground = load[:, 0] * planned(plan, "foot_l")[:, 2]
        ground = ground + load[:, 1] * planned(plan, "foot_r")[:, 2]
        lever = np.column_stack([planned(plan, "zmp"), ground]) - planned(plan, "com")
        expected = np.cross(unturn(heading, lever), plan.ideal_wrench[:, IDEAL_WRENCH.slice("F")])
        torque = plan.ideal_wrench[:, IDEAL_WRENCH.slice("T")]
        assert torque[:, :2] == pytest.approx(expected[:, :2], abs=1e-9)
        assert not torque[:, 2].any()


def test_ideal_torque_is_what_the_swinging_legs_need(walks, model):
    # The plan is corrected for the legs twice: less than a tenth or so of the peak is left over.
    rows = slice(None, None, 10)
    for _, plan in walks["straight"]:
        feet = np.stack([planned(plan, name)[rows].T for name in ("foot_l", "foot_r")], axis=1)
        legs = LegMotion(model.legs, 10 * PERIOD, planned(plan, "heading")[rows, 0], feet)
        momentum = legs.angular_momentum(planned(plan, "com")[rows].T).T
        rate = np.gradient(momentum, 10 * PERIOD, axis=0)[2:-2, :2]
        torque = plan.ideal_wrench[rows, IDEAL_WRENCH.slice("T", 2)][2:-2]
        assert np.abs(torque - rate).max() < 0.15 * np.abs(rate).max()


@pytest.mark.parametrize("name", WALKS)
def test_shift_of_the_zmp_is_known_without_the_plan(walks, model, name):
    for request, plan in walks[name]:
        assert np.array_equal(zmp_shift(model, request), plan.zmp_shift)


@pytest.mark.parametrize("name", WALKS)
def test_zmp_is_inward_and_behind_the_tcp_of_the_stance_foot(walks, name):
    for request, plan in walks[name]:
        stance = 1 - request.swing
        row = round((plan.lift_off + plan.duration) / 2 / PERIOD)
        foot = planned(plan, ("foot_l", "foot_r")[stance])[row]
        side = 1 if stance == RIGHT else -1
        lever = np.r_[planned(plan, "zmp")[row] - foot[:2], 0.0][None]
        expected = [PARAMS.zmp_forward, side * PARAMS.zmp_inward]
        assert unturn(foot[3], lever)[0, :2] == pytest.approx(expected, abs=1e-9)


def test_ideal_force_is_the_weight_when_standing(model):
    plan = plan_step(model, standing_request(PARAMS))
    force = plan.ideal_wrench[:, IDEAL_WRENCH.slice("F")]
    weight = [0.0, 0.0, 60.0 * GRAVITY]
    assert force == pytest.approx(np.tile(weight, (len(force), 1)), abs=1e-6)


def test_standing_request_stays(model):
    request = standing_request(PARAMS)
    plan = plan_step(model, request)
    assert plan.lift_off == np.inf
    assert planned(plan, "com") == pytest.approx(
        np.tile(request.com, (len(plan.gait_phase), 1)), abs=1e-9
    )
    assert planned(plan, "com_velocity") == pytest.approx(0.0, abs=1e-9)
    assert np.array_equal(plan.path, request.path)
    assert plan.load == 0.5


def test_standing_feet_are_force_controlled(model):
    plan = plan_step(model, standing_request(PARAMS))
    for name in ("support", "blend"):
        assert plan.gait_phase[:, GAIT_PHASE.slice(name)] == pytest.approx(1.0)


def test_loaded_feet_sink_in(model):
    request = standing_request(PARAMS)
    plan = plan_step(model, request)
    sink = 60.0 * GRAVITY / PARAMS.ground_stiffness / 2
    for name in ("w_l", "w_r"):
        height = plan.task_reference[:, TASK_REFERENCE.slice(name).start + 2]
        assert height == pytest.approx(-PARAMS.com_height - sink)


def test_swing_foot_is_unloaded_and_out_of_support(plans):
    for k, plan in enumerate(plans):
        swing = LEFT if k % 2 == 0 else RIGHT
        time = plan.gait_phase[:, GAIT_PHASE.index("time_in_step")]
        flying = (time > plan.lift_off + 1e-9) & (time < plan.duration - 1e-9)
        assert not plan.gait_phase[flying, GAIT_PHASE.slice("support")][:, swing].any()
        load = plan.gait_phase[flying, GAIT_PHASE.slice("load")][:, swing]
        assert load == pytest.approx(0.0, abs=1e-12)


def test_force_control_of_the_swing_foot_fades_from_lift_off_on(plans):
    for k, plan in enumerate(plans):
        lift_off = round(plan.lift_off / PERIOD)
        blend = plan.gait_phase[:, GAIT_PHASE.slice("blend")]
        assert blend[:, 1 - k % 2] == pytest.approx(1.0, abs=1e-9)
        assert blend[: lift_off + 1, k % 2] == pytest.approx(1.0, abs=1e-9)
        fading = blend[lift_off : lift_off + round(PARAMS.blend_time / PERIOD) + 1, k % 2]
        assert (np.diff(fading) < 0).all()
        assert fading[-1] == pytest.approx(0.0, abs=1e-9)


def test_force_control_is_complete_where_the_foot_is_planned_to_touch(plans):
    for k, plan in enumerate(plans):
        before = round(PARAMS.blend_time / PERIOD) + 1
        rising = plan.gait_phase[-before:, GAIT_PHASE.slice("blend")][:, k % 2]
        assert (np.diff(rising) > 0).all()
        assert rising[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-9)


def test_time_in_step_counts_the_ticks(plans):
    for k, plan in enumerate(plans):
        time = plan.gait_phase[:, GAIT_PHASE.index("time_in_step")]
        assert time == pytest.approx(PERIOD * np.arange(len(time)))
        assert time[-1] == pytest.approx(plan.duration)
        assert (plan.gait_phase[:, GAIT_PHASE.index("step_index")] == k).all()


def mirrored_request(request):
    left, right = (foot * [1, -1, 1, -1] for foot in request.feet)
    return replace(
        request,
        swing=1 - request.swing,
        load=1 - request.load,
        com=request.com * SIDES,
        com_velocity=request.com_velocity * SIDES,
        feet=(right, left),
        path=request.path * [1, -1, -1],
        heading=-request.heading,
        blend=request.blend[::-1],
        displacements=request.displacements * [1, -1, -1, 1],
    )


@pytest.mark.parametrize("name", WALKS)
@pytest.mark.parametrize("step", [0, 2, 5])
def test_mirrored_request_gives_the_mirrored_plan(model, walks, name, step):
    request, plan = walks[name][step]
    mirrored = plan_step(model, mirrored_request(request))
    pose = np.array([1.0, -1.0, 1.0, -1.0])
    task = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    expected = {
        "com": planned(plan, "com") * SIDES,
        "com_velocity": planned(plan, "com_velocity") * SIDES,
        "zmp": planned(plan, "zmp") * SIDES[:2],
        "foot_l": planned(plan, "foot_r") * pose,
        "foot_r": planned(plan, "foot_l") * pose,
    }
    for signal, values in expected.items():
        assert planned(mirrored, signal) == pytest.approx(values, abs=1e-9)
    for left, right in (("w_l", "w_r"), ("w_dot_l", "w_dot_r")):
        values = plan.task_reference[:, TASK_REFERENCE.slice(right)] * task
        mirror = mirrored.task_reference[:, TASK_REFERENCE.slice(left)]
        assert mirror == pytest.approx(values, abs=1e-9)
    for signal in ("support", "load", "blend"):
        part = GAIT_PHASE.slice(signal)
        values = plan.gait_phase[:, part][:, ::-1]
        assert mirrored.gait_phase[:, part] == pytest.approx(values, abs=1e-9)
    force, torque = IDEAL_WRENCH.slice("F"), IDEAL_WRENCH.slice("T")
    assert mirrored.ideal_wrench[:, force] == pytest.approx(
        plan.ideal_wrench[:, force] * SIDES, abs=1e-6
    )
    assert mirrored.ideal_wrench[:, torque] == pytest.approx(
        plan.ideal_wrench[:, torque] * -SIDES, abs=1e-6
    )


def test_plan_does_not_depend_on_where_it_is(model, walks):
    request, plan = walks["straight"][2]
    shift = np.array([3.0, -2.0, 0.0])
    moved = replace(
        request,
        com=request.com + shift,
        feet=tuple(foot + [3.0, -2.0, 0.0, 0.0] for foot in request.feet),
        path=request.path + shift,
    )
    again = plan_step(model, moved)
    assert again.task_reference == pytest.approx(plan.task_reference, abs=1e-9)
    assert again.ideal_wrench == pytest.approx(plan.ideal_wrench, abs=1e-6)


def test_forces_do_not_depend_on_the_height_of_the_ground(model, walks):
    request, plan = walks["turning"][1]
    up = np.array([0.0, 0.0, 0.3, 0.0])
    raised = replace(
        request,
        feet=tuple(foot + up for foot in request.feet),
        ground=request.ground + 0.3,
        com=request.com + 0.3 * (np.arange(request.com.size) == 2).reshape(request.com.shape),
    )
    again = plan_step(model, raised)
    assert again.ideal_wrench == pytest.approx(plan.ideal_wrench, abs=1e-6)


def test_plan_does_not_depend_on_the_direction(model, walks):
    request, plan = walks["straight"][2]
    turn = 0.9
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = replace(
        request,
        com=rotation @ request.com,
        com_velocity=rotation @ request.com_velocity,
        feet=tuple(np.r_[rotation @ foot[:3], foot[3] + turn] for foot in request.feet),
        path=np.r_[rotation[:2, :2] @ request.path[:2], request.path[2] + turn],
        heading=request.heading + turn,
    )
    again = plan_step(model, turned)
    assert again.task_reference == pytest.approx(plan.task_reference, abs=1e-9)
    assert again.ideal_wrench == pytest.approx(plan.ideal_wrench, abs=1e-6)
