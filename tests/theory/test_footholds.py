"""Footholds: no foot on the other one, and still where it was asked to go."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.theory.footholds import (
    GREATEST_AGAIN,
    LEFT,
    RIGHT,
    TURN,
    UP,
    Walker,
    advance,
    clear_foothold,
    first_foot,
    foothold,
    limited_step,
    outer_foot,
    paired_steps,
    reach,
    sole,
    with_closing_steps,
)

WIDTH = 0.23
steps_asked = st.tuples(
    st.floats(-0.5, 0.5), st.floats(-0.3, 0.3), st.floats(-0.78, 0.78), st.floats(-0.2, 0.2)
)
walks = st.lists(steps_asked, max_size=6).map(lambda steps: np.reshape(steps, (-1, 4)))


def walked(steps, swing):
    """Return the soles of the feet after each step."""
    walker = Walker(WIDTH, swing)
    for step in steps:
        walker.take(step)
        yield [sole(foot) for foot in walker.feet]


@given(walks)
def test_no_planned_step_puts_a_foot_on_the_other_one(steps):
    closed = with_closing_steps(steps, WIDTH)
    swing = first_foot(closed[0], WIDTH, LEFT) if len(closed) else LEFT
    for left, right in walked(closed, swing):
        assert not left.overlaps(right)


@given(walks)
def test_closing_steps_leave_the_planned_ones_as_they_are(steps):
    closed = with_closing_steps(steps, WIDTH)
    assert np.array_equal(closed[closed.any(axis=1)], steps[steps.any(axis=1)])
    assert len(steps) <= len(closed) <= 2 * len(steps)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("step", [(0, 0.05, 0, 0), (0, 0.2, 0, 0), (0, 0, 0.78, 0)])
def test_outer_foot_goes_first_and_the_other_one_closes(step, side):
    step = np.array(step) * [1, side, side, 1]
    outer = LEFT if side > 0 else RIGHT
    assert outer_foot(step) == first_foot(step, WIDTH, LEFT) == first_foot(step, WIDTH, RIGHT)
    assert outer_foot(step) == outer
    closed = with_closing_steps(np.tile(step, (2, 1)), WIDTH)
    assert np.array_equal(closed, [step, np.zeros(4), step])


@pytest.mark.parametrize(
    "step", [(0.4, 0, 0, 0), (0.1, 0, 0, 0.1), (0.25, 0, 0.17, 0), (0, 0, 0, 0)]
)
def test_steps_that_have_room_stay_as_they_are(step):
    steps = np.tile(step, (5, 1))
    assert np.array_equal(with_closing_steps(steps, WIDTH), steps)
    assert np.array_equal(paired_steps(np.array(step), RIGHT, 5, WIDTH), steps)
    assert first_foot(steps[0], WIDTH, LEFT) == LEFT


def test_straight_footholds_are_not_moved_at_all():
    path, standing = np.array([0.3, 0.0, 0.0]), foothold(np.zeros(3), RIGHT, WIDTH)
    assert np.array_equal(clear_foothold(path, LEFT, WIDTH, standing), foothold(path, LEFT, WIDTH))


@given(steps_asked, st.sampled_from([LEFT, RIGHT]))
def test_commanded_steps_never_overlap_and_arrive(step, swing):
    step = np.array([*limited_step(np.array(step))[:UP], 0.0])
    steps = paired_steps(step, swing, 6, WIDTH)
    for left, right in walked(steps, first_foot(step, WIDTH, swing)):
        assert not left.overlaps(right)
    np.testing.assert_allclose(steps.sum(axis=0), 6 * step, atol=1e-12)


@given(steps_asked)
def test_limited_steps_point_where_they_were_asked_to(step):
    asked = np.array([*step[:UP], 0.0]) * 3
    limited = limited_step(asked)
    assert reach(limited, GREATEST_AGAIN) <= 1 + 1e-9
    np.testing.assert_allclose(np.cross(limited[:UP], asked[:UP]), 0, atol=1e-12)
    if reach(asked, GREATEST_AGAIN) <= 1:
        assert np.array_equal(limited, asked)


@pytest.mark.parametrize("foot", [LEFT, RIGHT])
def test_a_foothold_that_needs_room_is_moved_outward_in_its_own_direction(foot):
    side = 1 if foot == LEFT else -1
    path, standing = np.array([0.0, 0.0, side * 0.6]), foothold(np.zeros(3), 1 - foot, WIDTH)
    place = clear_foothold(path, foot, WIDTH, standing)
    offset = place[:2] - foothold(path, foot, WIDTH)[:2]
    outward = side * np.array([-np.sin(path[2]), np.cos(path[2])])
    assert offset @ outward == pytest.approx(np.linalg.norm(offset))
    assert 0.05 < np.linalg.norm(offset) < 0.1
    assert place[2] == path[2]


def test_a_foot_is_turned_no_further_than_the_hips_allow():
    standing = foothold(np.zeros(3), RIGHT, WIDTH)
    place = clear_foothold(advance(np.zeros(3), [0.0, 0.0, 0.78]), LEFT, WIDTH, standing)
    assert np.degrees(place[TURN]) == pytest.approx(40.0)
