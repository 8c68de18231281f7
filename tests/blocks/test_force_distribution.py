"""The distribution of the wrench to the feet: balance, limits, symmetry, rates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ticking import Ticking

from lola_drake.blocks.force_distribution import (
    ForceDistribution,
    ForceDistributionParams,
    distribute,
    unplanned,
)
from lola_drake.signals import DESIRED_WRENCH, GAIT_PHASE, IDEAL_WRENCH, PERIOD, TASK_REFERENCE

MARGIN_X, MARGIN_Y, LEAST = 0.09, 0.08, 20.0
HEIGHT = 0.85


@st.composite
def situations(draw, torque=100.0):
    """Return a modified wrench, load shares and feet; one foot may bear everything."""
    horizontal = st.floats(-60, 60)
    force = [draw(horizontal), draw(horizontal), draw(st.floats(100, 1200))]
    torques = [draw(st.floats(-torque, torque)) for _ in range(3)]
    left = draw(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 0.99)))
    step = st.floats(-0.3, 0.3)
    r_left = [draw(step), draw(st.floats(0.05, 0.25)), -HEIGHT]
    r_right = [draw(step), draw(st.floats(-0.25, -0.05)), -HEIGHT]
    return force + torques, [left, 1 - left], r_left, r_right


def wrenches(situation):
    return np.reshape(distribute(*situation, MARGIN_X, MARGIN_Y, LEAST), (2, 3))


def total_about_com(situation, feet):
    """Return T_x, T_y about the CoM and F_z of both feet; the load carries what is horizontal."""
    modified, load, *positions = situation
    total = np.zeros(3)
    for (t_x, t_y, f_z), share, r in zip(feet, load, positions, strict=True):
        force = np.array([share * modified[0], share * modified[1], f_z])
        torque = np.cross(r, force) + [t_x, t_y, 0.0]
        total += [torque[0], torque[1], f_z]
    return total


def within_soles(situation, part_x, part_y):
    """Return it with a torque that asks the feet for these parts of what their soles give."""
    modified, load, *positions = situation
    torque = np.array([part_x * MARGIN_Y, part_y * MARGIN_X, 0.0]) * modified[2]
    for share, r in zip(load, positions, strict=True):
        torque += np.cross(r, share * np.array(modified[:3]))
    return modified[:3] + torque.tolist(), load, *positions


def mirrored(situation):
    (f_x, f_y, f_z, t_x, t_y, t_z), load, r_left, r_right = situation
    flip = np.array([1.0, -1.0, 1.0])
    modified = [f_x, -f_y, f_z, -t_x, t_y, -t_z]
    return modified, load[::-1], (flip * r_right).tolist(), (flip * r_left).tolist()


def balanced(load):
    """Return a wrench that level feet give with forces at their TCPs only, and little more."""
    r_left, r_right = [0.1, 0.12, -HEIGHT], [-0.1, -0.12, -HEIGHT]
    forces = [np.array([0.0, 0.0, 588.0 * share]) for share in load]
    torque = np.cross(r_left, forces[0]) + np.cross(r_right, forces[1])
    return [0.0, 0.0, 588.0, *torque], list(load), r_left, r_right


@given(situations(), st.floats(-0.99, 0.99), st.floats(-0.99, 0.99))
def test_feet_give_the_wrench_where_no_limit_is_active(situation, part_x, part_y):
    situation = within_soles(situation, part_x, part_y)
    modified = situation[0]
    expected = [modified[3], modified[4], modified[2]]
    assert total_about_com(situation, wrenches(situation)) == pytest.approx(expected, abs=1e-6)


@given(st.floats(0, 1), st.floats(-15, 15), st.floats(-15, 15))
def test_feet_give_a_small_torque_by_their_shares(left, t_x, t_y):
    situation = balanced((left, 1 - left))
    situation[0][3] += t_x
    situation[0][4] += t_y
    feet = wrenches(situation)
    assert feet[0] == pytest.approx([left * t_x, left * t_y, left * 588.0], abs=1e-6)
    assert total_about_com(situation, feet) == pytest.approx([*situation[0][3:5], 588.0])


@given(situations())
def test_vertical_force_is_never_lost(situation):
    assert wrenches(situation)[:, 2].sum() == pytest.approx(situation[0][2])


@given(situations(torque=400.0))
def test_torques_stay_within_the_soles_under_the_planned_load(situation):
    force = np.array(situation[1]) * situation[0][2]
    feet = wrenches(situation)
    assert (np.abs(feet[:, 0]) <= MARGIN_Y * force + 1e-9).all()
    assert (np.abs(feet[:, 1]) <= MARGIN_X * force + 1e-9).all()


@given(situations(torque=400.0))
def test_shift_of_the_load_leaves_the_least_force(situation):
    planned = np.array(situation[1]) * situation[0][2]
    force = wrenches(situation)[:, 2]
    assert (force >= np.minimum(planned, LEAST) - 1e-9).all()


@given(situations(torque=400.0))
def test_mirrored_wrench_is_distributed_in_the_mirror(situation):
    t_x, t_y, f_z = wrenches(situation)[::-1].T
    expected = np.column_stack([-t_x, t_y, f_z])
    assert wrenches(mirrored(situation)) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("stance", [0, 1])
@given(situation=situations(torque=400.0))
def test_in_single_support_the_stance_foot_bears_all(stance, situation):
    modified, _, *positions = situation
    load = [float(foot == stance) for foot in (0, 1)]
    feet = wrenches((modified, load, *positions))
    assert feet[stance, 2] == modified[2]
    assert feet[1 - stance] == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_the_soles_cannot_give_is_a_shift_of_the_load(side):
    modified, load, r_left, r_right = balanced((0.5, 0.5))
    r_left[0] = r_right[0] = 0.0
    situation = [0.0, 0.0, 588.0, side * 80.0, 0.0, 0.0], load, r_left, r_right
    feet = wrenches(situation)
    assert feet[:, 0] == pytest.approx(np.full(2, side * MARGIN_Y * 294.0))
    assert feet[0, 2] - feet[1, 2] == pytest.approx(side * 2 * (80.0 - 0.16 * 294.0) / 0.24)
    assert total_about_com(situation, feet)[0] == pytest.approx(side * 80.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_feet_behind_each_other_shift_the_load_for_a_torque_about_y(side):
    modified, load = [0.0, 0.0, 588.0, 0.0, side * 80.0, 0.0], [0.5, 0.5]
    situation = modified, load, [0.3, 0.0, -HEIGHT], [-0.3, 0.0, -HEIGHT]
    feet = wrenches(situation)
    assert feet[:, 1] == pytest.approx(np.full(2, side * MARGIN_X * 294.0))
    assert total_about_com(situation, feet) == pytest.approx([0.0, side * 80.0, 588.0])


class Feet(Ticking):
    """The block, standing on both feet."""

    def __init__(self, **params):
        super().__init__(ForceDistribution(ForceDistributionParams(**params)))
        self.put(balanced((0.5, 0.5)))

    def put(self, situation, height_feedback=0.0):
        """Give it a situation whose vertical force holds a feedback (N) beside the plan's."""
        modified, load, r_left, r_right = situation
        ideal = np.zeros(IDEAL_WRENCH.size)
        ideal[IDEAL_WRENCH.slice("F").start + 2] = modified[2] - height_feedback
        phase, reference = np.zeros(GAIT_PHASE.size), np.zeros(TASK_REFERENCE.size)
        phase[GAIT_PHASE.slice("load")] = load
        reference[TASK_REFERENCE.slice("w_l", 3)] = r_left
        reference[TASK_REFERENCE.slice("w_r", 3)] = r_right
        for name, value in (
            ("modified_wrench", modified),
            ("ideal_wrench", ideal),
            ("gait_phase", phase),
            ("task_reference", reference),
        ):
            self.fix(name, value)

    def desired(self, name):
        return self.output("desired_wrench")[DESIRED_WRENCH.slice(name)]


def test_block_distributes_as_the_law_says():
    feet = Feet()
    expected = wrenches(balanced((0.5, 0.5)))
    assert feet.desired("wrench_l") == pytest.approx(expected[0])
    assert feet.desired("wrench_r") == pytest.approx(expected[1])


@pytest.mark.parametrize("foot", "lr")
def test_rates_of_a_constant_wrench_vanish(foot):
    feet = Feet()
    situation = balanced((0.5, 0.5))
    situation[0][3] += 20.0
    feet.put(situation)
    before = np.abs(feet.desired(f"rate_{foot}")).max()
    feet.step(400)
    assert before > 100.0
    assert feet.desired(f"rate_{foot}") == pytest.approx(np.zeros(3), abs=1e-4)


def test_rate_decays_with_the_time_constant_of_the_filter():
    feet = Feet(rate_filter=0.02)
    situation = balanced((0.5, 0.5))
    situation[0][3] += 20.0
    feet.put(situation)
    before = feet.desired("rate_l")[0]
    feet.step(20)
    assert feet.desired("rate_l")[0] / before == pytest.approx(np.exp(-1))


def test_rate_of_a_ramp_is_its_slope():
    feet = Feet()
    for k in range(300):
        situation = balanced((0.5, 0.5))
        situation[0][3] += 0.05 * k
        feet.put(situation)
        if k < 299:
            feet.step()
    assert feet.desired("rate_l")[0] == pytest.approx(25.0, rel=PERIOD / 0.02)


def test_what_is_unplanned_is_all_but_the_planned_loads():
    desired = [1.0, -2.0, 330.0, 3.0, -4.0, 280.0]
    assert unplanned(desired, [0.6, 0.4], 500.0) == pytest.approx([1, -2, 30, 3, -4, 80])


def test_feedback_of_the_height_has_its_rate():
    """The CoM sinks: both feet are told to press more, and how fast."""
    feet = Feet()
    for k in range(300):
        feedback = 0.1 * k
        situation = balanced((0.7, 0.3))
        situation[0][2] += feedback
        feet.put(situation, height_feedback=feedback)
        if k < 299:
            feet.step()
    rates = [feet.desired(f"rate_{foot}")[2] for foot in "lr"]
    assert rates == pytest.approx([70.0, 30.0], rel=PERIOD / 0.02)


def test_planned_load_has_no_rate():
    feet = Feet()
    feet.step(100)
    feet.put(balanced((0.7, 0.3)))
    assert feet.desired("wrench_l")[2] == pytest.approx(0.7 * 588.0)
    assert feet.desired("rate_l")[2] == pytest.approx(0.0, abs=1e-9)
