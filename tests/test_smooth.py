"""Smooth transitions: their ends, and their derivatives against finite differences."""

import numpy as np
import pytest

from lola_drake.theory.smooth import bump, linear, quintic

INSIDE = np.linspace(0.01, 0.99, 99)
OUTSIDE = np.array([-3.0, -0.1, 1.1, 4.0])
H = 1e-5


@pytest.mark.parametrize("transition", [quintic, linear])
def test_goes_from_zero_to_one(transition):
    s, _, _ = transition(np.array([0.0, 0.5, 1.0]))
    assert s == pytest.approx([0.0, 0.5, 1.0], abs=1e-15)


@pytest.mark.parametrize("transition", [quintic, linear])
def test_is_held_outside(transition):
    s, ds, dds = transition(OUTSIDE)
    assert s == pytest.approx([0.0, 0.0, 1.0, 1.0])
    assert not ds.any() and not dds.any()


@pytest.mark.parametrize("transition", [quintic, linear])
def test_never_turns_back(transition):
    s, ds, _ = transition(np.linspace(-0.5, 1.5, 401))
    assert (np.diff(s) >= 0).all()
    assert (ds >= 0).all()


@pytest.mark.parametrize("transition", [quintic, linear])
def test_first_derivative_is_that_of_the_value(transition):
    _, ds, _ = transition(INSIDE)
    difference = (transition(INSIDE + H)[0] - transition(INSIDE - H)[0]) / (2 * H)
    assert ds == pytest.approx(difference, abs=1e-8)


@pytest.mark.parametrize("transition", [quintic, linear])
def test_second_derivative_is_that_of_the_first(transition):
    _, _, dds = transition(INSIDE)
    difference = (transition(INSIDE + H)[1] - transition(INSIDE - H)[1]) / (2 * H)
    assert dds == pytest.approx(difference, abs=1e-7)


def test_quintic_begins_and_ends_at_rest():
    _, ds, dds = quintic(np.array([0.0, 1.0]))
    assert ds == pytest.approx([0.0, 0.0])
    assert dds == pytest.approx([0.0, 0.0])


def test_quintic_is_the_same_backwards():
    assert quintic(1 - INSIDE)[0] == pytest.approx(1 - quintic(INSIDE)[0])


def test_quintic_keeps_the_shape_of_its_argument():
    tau = np.linspace(-0.5, 1.5, 12).reshape(3, 4)
    assert all(part.shape == tau.shape for part in quintic(tau))


def test_linear_has_the_rate_of_what_comes_next():
    _, ds, _ = linear(np.array([0.0, 1.0]))
    assert ds == pytest.approx([1.0, 0.0])


def test_bump_is_one_in_the_middle_and_zero_at_the_ends():
    assert bump(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 1.0, 0.0])
    assert bump(OUTSIDE) == pytest.approx(np.zeros(4))


@pytest.mark.parametrize("end", [0.0, 1.0])
def test_bump_begins_and_ends_without_slope(end):
    slope = (bump(np.array([end + H])) - bump(np.array([end - H]))) / (2 * H)
    assert slope == pytest.approx([0.0], abs=1e-3)
