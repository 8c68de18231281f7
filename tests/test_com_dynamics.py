"""The CoM dynamics of one foot: eq. 18 to 21, single support, anti-windup."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.blocks.com_dynamics import (
    ComDynamics,
    ComDynamicsParams,
    com_acceleration,
    limited_step,
    single_support,
)

INERTIA = np.array([8.0, 7.0, 60.0])
LIMITS = np.array([0.25, 0.25, 0.08])
numbers = st.floats(-1.0, 1.0)


@given(*5 * [numbers])
def test_acceleration_is_equation_18(r_x, r_y, e_x, e_y, e_z):
    levers = np.array([[1, 0, r_y], [0, 1, -r_x], [0, 0, 1]])
    expected = np.linalg.solve(np.diag(INERTIA), levers @ [e_x, e_y, e_z])
    got = com_acceleration(INERTIA, r_x, r_y, (e_x, e_y, e_z))
    np.testing.assert_allclose(got, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [(1, 0, (True, False)), (0, 1, (False, True)), (1, 1, (False, False)), (0, 0, (False, False))],
)
def test_single_support_is_one_foot_alone_on_any_pad(left, right, expected):
    contact = [0.0] * 8
    contact[2], contact[5] = float(left), float(right)
    assert tuple(single_support(contact, foot) for foot in (0, 1)) == expected


class Foot:
    """The left foot's CoM dynamics, stepped tick by tick."""

    def __init__(self, **params):
        self.block = ComDynamics(ComDynamicsParams(**params), "l", INERTIA, LIMITS, 0.001)
        self.context = self.block.CreateDefaultContext()
        self.error, self.modification, self.contact = np.zeros(3), np.zeros(3), [1.0, 0.0]

    def step(self):
        """Return the rate that follows from the present error, modification and contact."""
        reference = np.zeros(28)
        reference[:3] = [0.1, 0.12, -0.87]
        inputs = {
            "desired_wrench": np.r_[self.error, np.zeros(9)],
            "contact_wrench": np.zeros(3),
            "contact": np.repeat(self.contact, 4),
            "task_reference": reference,
            "task_modification": self.modification,
        }
        for name, value in inputs.items():
            self.block.GetInputPort(name).FixValue(self.context, value)
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        return self.block.GetOutputPort("com_dynamics_rate").Eval(self.context).copy()


def test_error_of_the_stance_foot_accelerates_the_com():
    """Delta w_a,f'' = -g_a M^-1 R_f e: less force than desired raises the CoM over the foot."""
    foot = Foot(gain=0.5)
    foot.error = np.array([3.0, -2.0, 60.0])
    expected = -0.5 * 0.001 * np.array(com_acceleration(INERTIA, 0.1, 0.12, foot.error))
    for k in range(5):
        np.testing.assert_allclose(foot.step(), (k + 1) * expected, atol=1e-15)


def test_gain_0_switches_it_off():
    foot = Foot(gain=0.0)
    foot.error = np.array([10.0, 10.0, 100.0])
    np.testing.assert_array_equal([foot.step() for _ in range(5)], 0)


def test_outside_single_support_the_rate_decays():
    foot = Foot(decay_gain=20.0)
    foot.error = np.array([10.0, -10.0, 100.0])
    for _ in range(50):
        start = foot.step()
    foot.contact = [1.0, 1.0]
    decayed = np.array([foot.step() for _ in range(10)])
    np.testing.assert_allclose(decayed, start * 0.98 ** np.arange(1, 11)[:, None])


@given(st.lists(st.tuples(*3 * [st.floats(-3, 3)]), min_size=1, max_size=60))
def test_state_never_passes_its_limit(changes):
    limits = (1.5, 1.5, 0.4)
    state = [0.0, 0.0, 0.0]
    for change in changes:
        state = [
            limited_step(s, c, limit, 0.0, 1.0)
            for s, c, limit in zip(state, change, limits, strict=True)
        ]
        assert all(abs(s) <= limit for s, limit in zip(state, limits, strict=True))


def test_state_leaves_its_limit_without_delay():
    foot = Foot()
    foot.error = np.array([0.0, 0.0, 4000.0])
    held = [foot.step()[2] for _ in range(2000)]
    assert held[-1] == held[-500] == -ComDynamicsParams().max_height_rate
    foot.error = -foot.error
    assert foot.step()[2] > held[-1]


@given(numbers, st.floats(-0.5, 0.5), st.sampled_from([-0.25, 0.25]))
def test_state_stands_still_where_the_modification_is_at_its_limit(rate, change, modification):
    following = limited_step(rate, change, 2.0, modification, 0.25)
    assert following == (rate if change * modification > 0 else rate + change)


def test_modification_at_its_limit_stops_the_integration_of_that_direction_alone():
    foot = Foot()
    foot.error = np.array([0.0, 0.0, 100.0])
    foot.modification = np.array([0.0, 0.0, -LIMITS[2]])
    assert foot.step()[2] == 0.0
    assert np.all(foot.step()[:2] != 0.0)
    foot.modification = -foot.modification
    assert foot.step()[2] < 0.0


def test_gains_are_turned_without_a_rebuild():
    foot = Foot(gain=1.0)
    foot.error = np.array([0.0, 0.0, 60.0])
    foot.context.get_mutable_numeric_parameter(0).SetAtIndex(0, 0.0)
    np.testing.assert_array_equal(foot.step(), 0)
