"""Distribution of the wrench to the feet: the whole of it, within what the feet can give."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.blocks.force_distribution import (
    ForceDistribution,
    ForceDistributionParams,
    distribute,
)

LIMITS = {"margin_x": 0.09, "margin_y": 0.08, "least_force": 20.0}
LEFT, RIGHT = (0.02, 0.115, -0.87), (0.02, -0.115, -0.87)

forces = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(200, 900))
torques = st.tuples(*2 * [st.floats(-300, 300)], st.just(0.0))
wrenches = st.builds(lambda f, t: f + t, forces, torques)
left_loads = st.floats(0, 1)
feet = st.tuples(st.floats(-0.4, 0.4), st.floats(0.05, 0.3), st.floats(-0.9, -0.8))


def about_com(wrench, modified, load, r_left, r_right):
    """Return F_z, T_x, T_y about the CoM of both feet's wrenches.

    The horizontal forces go to the feet by their loads.
    """
    f_x, f_y = modified[:2]
    f_z = t_x = t_y = 0.0
    for (foot_t_x, foot_t_y, foot_f_z), share, (x, y, z) in zip(
        (wrench[:3], wrench[3:]), (load, 1 - load), (r_left, r_right), strict=True
    ):
        f_z += foot_f_z
        t_x += foot_t_x + y * foot_f_z - z * share * f_y
        t_y += foot_t_y + z * share * f_x - x * foot_f_z
    return np.array([f_z, t_x, t_y])


@given(wrenches, left_loads, feet)
def test_vertical_force_is_always_the_whole(modified, load, place):
    r_right = (place[0], -place[1], place[2])
    wrench = distribute(modified, (load, 1 - load), place, r_right, **LIMITS)
    assert wrench[2] + wrench[5] == pytest.approx(modified[2])


@given(wrenches, left_loads)
def test_where_no_limit_is_active_the_sum_is_the_modified_wrench(modified, load):
    wide = {"margin_x": 10.0, "margin_y": 10.0, "least_force": 0.0}
    wrench = distribute(modified, (load, 1 - load), LEFT, RIGHT, **wide)
    expected = [modified[2], modified[3], modified[4]]
    got = about_com(wrench, modified, load, LEFT, RIGHT)
    np.testing.assert_allclose(got, expected, atol=1e-9)


@given(wrenches, left_loads)
def test_desired_centres_of_pressure_stay_on_the_feet(modified, load):
    """By the planned loads; a shift moves force between the feet and leaves the torques alone."""
    wrench = np.array(distribute(modified, (load, 1 - load), LEFT, RIGHT, **LIMITS))
    planned = np.array([load, 1 - load]) * modified[2]
    assert np.all(np.abs(wrench[[0, 3]]) <= LIMITS["margin_y"] * planned + 1e-9)
    assert np.all(np.abs(wrench[[1, 4]]) <= LIMITS["margin_x"] * planned + 1e-9)


@given(wrenches, left_loads)
def test_shift_of_the_load_leaves_the_least_force(modified, load):
    wrench = distribute(modified, (load, 1 - load), LEFT, RIGHT, **LIMITS)
    for force, share in ((wrench[2], load), (wrench[5], 1 - load)):
        assert force >= min(LIMITS["least_force"], share * modified[2]) - 1e-9


@given(wrenches, st.sampled_from([0.0, 1.0]))
def test_unloaded_foot_gets_nothing(modified, load):
    wrench = distribute(modified, (load, 1 - load), LEFT, RIGHT, **LIMITS)
    free = wrench[:3] if load == 0.0 else wrench[3:]
    np.testing.assert_allclose(free, 0, atol=1e-12)


def test_too_large_a_roll_torque_is_met_by_a_shift_of_the_load():
    upright = distribute((0, 0, 600, 0, 0, 0), (0.5, 0.5), LEFT, RIGHT, **LIMITS)
    tilted = distribute((0, 0, 600, 60, 0, 0), (0.5, 0.5), LEFT, RIGHT, **LIMITS)
    assert upright[2] == pytest.approx(300)
    assert tilted[2] > 300 > tilted[5]


@given(wrenches, left_loads, feet)
def test_mirrored_wrench_is_distributed_to_the_mirrored_feet(modified, load, place):
    other = (place[0], -place[1], place[2])
    f_x, f_y, f_z, t_x, t_y, t_z = modified
    wrench = distribute(modified, (load, 1 - load), place, RIGHT, **LIMITS)
    mirror = distribute((f_x, -f_y, f_z, -t_x, t_y, -t_z), (1 - load, load), LEFT, other, **LIMITS)
    sign = np.array([-1, 1, 1, -1, 1, 1])
    np.testing.assert_allclose(mirror[3:] + mirror[:3], sign * wrench, atol=1e-9)


def block_with(modified, tau):
    """Return the block standing on both feet, with a wrench that can be changed."""
    block = ForceDistribution(ForceDistributionParams(rate_filter=tau), 0.001)
    context = block.CreateDefaultContext()
    reference = np.zeros(28)
    reference[0:3], reference[6:9] = LEFT, RIGHT
    block.GetInputPort("gait_phase").FixValue(context, [1.0, 1, 0.5, 0.5, 1, 1, 0, 0])
    block.GetInputPort("task_reference").FixValue(context, reference)
    block.GetInputPort("modified_wrench").FixValue(context, np.array(modified, dtype=float))
    return block, context


def test_rate_of_a_steady_wrench_fades_with_the_filter():
    """The rate of a step is that of a first-order filter, exact at the ticks."""
    tau = 0.02
    block, context = block_with([0, 0, 600, 10, 0, 0], tau)
    rates = []
    for _ in range(40):
        rates.append(block.GetOutputPort("desired_wrench").Eval(context)[6])
        context.SetDiscreteState(block.EvalUniquePeriodicDiscreteUpdate(context))
    expected = 5.0 / tau * np.exp(-0.001 * np.arange(40) / tau)
    np.testing.assert_allclose(rates, expected, rtol=1e-9)


def test_planned_load_makes_no_rate():
    """The pattern itself moves the feet into the ground for it."""
    block, context = block_with([0, 0, 600, 0, 0, 0], 0.02)
    rates = block.GetOutputPort("desired_wrench").Eval(context)[6:]
    np.testing.assert_allclose(rates[[2, 5]], 0, atol=1e-9)
