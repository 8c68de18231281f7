"""The CoM's dynamics in the force control against the paper's equations 18 to 20."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ticking import Ticking

from lola_drake.blocks.com_dynamics import (
    ComDynamics,
    ComDynamicsParams,
    com_acceleration,
    limited_step,
    single_support,
)
from lola_drake.signals import PERIOD, TASK_REFERENCE

INERTIA = np.array([10.0, 9.0, 60.0])
MODIFICATION_LIMITS = np.array([0.25, 0.25, 0.08])
OPEN, CLOSED = np.zeros(4), np.ones(4)
ON_LEFT, ON_BOTH, IN_AIR = np.r_[CLOSED, OPEN], np.r_[CLOSED, CLOSED], np.r_[OPEN, OPEN]
ON_RIGHT = np.r_[OPEN, CLOSED]
FORCES = st.floats(-1e3, 1e3)
LEVERS = st.floats(-0.3, 0.3)


class Foot(Ticking):
    """The block of one foot."""

    def __init__(self, foot="l", **params):
        constants = {"inertia": INERTIA, "modification_limits": MODIFICATION_LIMITS}
        super().__init__(ComDynamics(ComDynamicsParams(**params), foot, **constants))
        self.foot = foot

    def stand(self, x, y):
        reference = np.zeros(TASK_REFERENCE.size)
        reference[TASK_REFERENCE.slice(f"w_{self.foot}", 2)] = x, y
        self.fix("task_reference", reference)

    def step(self, ticks=1):
        super().step(ticks)
        return self.output("com_dynamics_rate")


def test_each_direction_has_its_own_limit():
    law = ComDynamics.laws["next_com_dynamics_rate"]
    limits, wide = np.array([0.1, 0.2, 0.3]), np.full(3, 9.0)
    rate = law(np.zeros(3), np.full(3, 1e9), np.zeros(3), ON_LEFT, np.zeros(2), np.zeros(3),
               -1.0, 1.0, INERTIA, limits, wide, 0)  # fmt: skip
    assert rate == pytest.approx(limits)


@given(st.tuples(FORCES, FORCES, FORCES), LEVERS, LEVERS)
def test_acceleration_is_that_of_equation_18(error, r_x, r_y):
    r_f = np.array([[1.0, 0.0, r_y], [0.0, 1.0, -r_x], [0.0, 0.0, 1.0]])
    expected = np.linalg.solve(np.diag(INERTIA), r_f @ error)
    assert com_acceleration(INERTIA, r_x, r_y, *error) == pytest.approx(expected, abs=1e-9)


@given(st.tuples(FORCES, FORCES, FORCES), LEVERS, LEVERS)
def test_mirrored_error_gives_the_mirrored_acceleration(error, r_x, r_y):
    e_x, e_y, e_z = error
    a_x, a_y, a_z = com_acceleration(INERTIA, r_x, r_y, *error)
    mirrored = com_acceleration(INERTIA, r_x, -r_y, -e_x, e_y, e_z)
    assert mirrored == pytest.approx((-a_x, a_y, a_z))


@pytest.mark.parametrize(
    ("contact", "left", "right"),
    [
        (ON_LEFT, True, False),
        (ON_RIGHT, False, True),
        (ON_BOTH, False, False),
        (IN_AIR, False, False),
    ],
)
def test_single_support_is_one_foot_alone(contact, left, right):
    assert (single_support(contact, 0), single_support(contact, 1)) == (left, right)


def test_one_closed_pad_is_a_contact():
    for pads in product((0.0, 1.0), repeat=4):
        assert single_support(np.r_[pads, OPEN], 0) == any(pads)
        assert single_support(np.r_[CLOSED, pads], 0) == (not any(pads))


@pytest.mark.parametrize(("foot", "contact"), [("l", ON_LEFT), ("r", ON_RIGHT)])
def test_stance_foot_integrates_the_acceleration_backwards(foot, contact):
    block = Foot(foot)
    block.stand(0.05, -0.1)
    block.fix("contact", contact)
    block.fix("contact_wrench", [4.0, -3.0, -20.0])
    acceleration = com_acceleration(INERTIA, 0.05, -0.1, -4.0, 3.0, 20.0)
    assert block.step(25) == pytest.approx(-25 * PERIOD * np.array(acceleration))


@pytest.mark.parametrize("contact", [ON_RIGHT, ON_BOTH, IN_AIR])
def test_foot_that_does_not_stand_alone_integrates_nothing(contact):
    foot = Foot()
    foot.fix("contact", contact)
    foot.fix("contact_wrench", [40.0, 40.0, 400.0])
    assert np.array_equal(foot.step(10), np.zeros(3))


def test_too_much_force_on_the_stance_foot_lets_the_com_down():
    foot = Foot()
    foot.fix("contact", ON_LEFT)
    foot.fix("contact_wrench", [0.0, 0.0, 300.0])
    assert foot.step()[2] == pytest.approx(PERIOD * 300.0 / 60.0)


def test_too_little_force_on_the_stance_foot_lifts_the_com():
    foot = Foot()
    foot.fix("contact", ON_LEFT)
    foot.fix("contact_wrench", [0.0, 0.0, -300.0])
    assert foot.step()[2] < 0


def test_gain_scales_the_integration():
    rates = []
    for gain in (1.0, 0.3):
        foot = Foot(gain=gain)
        foot.fix("contact", ON_LEFT)
        foot.fix("contact_wrench", [4.0, -3.0, 20.0])
        rates.append(foot.step(10))
    assert rates[1] == pytest.approx(0.3 * rates[0])


def test_gain_of_zero_switches_it_off():
    foot = Foot(gain=0.0)
    foot.fix("contact", ON_LEFT)
    foot.fix("contact_wrench", [40.0, -30.0, 400.0])
    assert np.array_equal(foot.step(100), np.zeros(3))


@pytest.mark.parametrize("contact", [ON_RIGHT, ON_BOTH, IN_AIR])
def test_rate_decays_outside_single_support(contact):
    foot = Foot(decay_gain=20.0)
    start = np.array([0.5, -1.0, 0.3])
    foot.set_state("com_dynamics_rate", start)
    foot.fix("contact", contact)
    ratio = foot.step(50) / start
    assert ratio == pytest.approx(np.full(3, np.exp(-1)), rel=0.02)


@given(
    st.lists(st.floats(-2, 2), min_size=1, max_size=60),
    st.floats(-0.08, 0.08),
)
def test_rate_never_passes_its_limit(changes, modification):
    rate = 0.0
    for change in changes:
        rate = limited_step(rate, change, 0.4, modification, 0.08)
        assert abs(rate) <= 0.4


@given(st.floats(1e-6, 0.4), st.integers(1, 1000), st.sampled_from([-1.0, 1.0]))
def test_rate_leaves_its_limit_without_delay(change, ticks_at_limit, side):
    rate = 0.0
    for _ in range(ticks_at_limit):
        rate = limited_step(rate, side * 0.5, 0.4, 0.0, 0.08)
    back = limited_step(rate, -side * change, 0.4, 0.0, 0.08)
    assert back == pytest.approx(side * (0.4 - change), abs=1e-12)


@given(st.floats(0, 0.4), st.floats(1e-6, 1), st.sampled_from([-1.0, 1.0]))
def test_integration_stops_at_the_limit_of_the_modification(rate, change, side):
    assert limited_step(side * rate, side * change, 0.4, side * 0.08, 0.08) == side * rate


@given(st.floats(0.1, 0.4), st.floats(1e-6, 0.1), st.sampled_from([-1.0, 1.0]))
def test_rate_decays_whatever_limit_the_modification_is_at(rate, change, side):
    for limit in (-0.08, 0.08):
        decayed = limited_step(side * rate, -side * change, 0.4, limit, 0.08)
        assert decayed == side * rate - side * change


@given(st.floats(-0.1, 0.1), st.floats(1e-6, 0.2), st.sampled_from([-1.0, 1.0]))
def test_integration_away_from_the_limit_of_the_modification_goes_on(rate, change, side):
    assert limited_step(rate, -side * change, 0.4, side * 0.08, 0.08) == rate - side * change


def test_block_stays_within_its_limits_and_comes_back_at_once():
    foot = Foot()
    foot.fix("contact", ON_LEFT)
    foot.fix("contact_wrench", [500.0, -500.0, 900.0])
    limits = np.array([1.5, -1.5, 0.4])
    assert foot.step(500) == pytest.approx(limits)
    foot.fix("contact_wrench", [-50.0, 50.0, -90.0])
    assert (np.abs(foot.step()) < np.abs(limits)).all()


def test_block_does_not_wind_up_while_the_foot_cannot_move():
    foot = Foot()
    foot.fix("contact", ON_LEFT)
    foot.fix("contact_wrench", [0.0, 0.0, 300.0])
    foot.fix("task_modification", [0.0, 0.0, 0.08])
    assert foot.step(100)[2] == 0.0
