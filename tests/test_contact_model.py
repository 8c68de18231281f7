"""The explicit contact model: U of eq. 8 against the surface integrals of eq. 2 to 5."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lola_drake.robot import PADS
from lola_drake.theory.contact_model import Pad, contact_matrix

STIFFNESS = 2.5e7
PLACE = st.floats(-0.2, 0.2)
EXTENT = st.floats(0.005, 0.2)
PAD_SETS = st.lists(
    st.builds(Pad, x=PLACE, y=PLACE, length=EXTENT, width=EXTENT), min_size=1, max_size=8
)


def pressure(x, y, sin_x, sin_y, height):
    """Return f_z of eq. 2 over the stiffness."""
    return x * sin_y - y * sin_x - height


def surface_integral(pads, stiffness, deflection):
    """Return T_x, T_y and F_z of eq. 3 to 5 for small angles, by 3x3 Gauss-Legendre per pad."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = np.zeros(3)
    for pad in pads:
        x, y = np.meshgrid(pad.x + nodes * pad.length / 2, pad.y + nodes * pad.width / 2)
        d_area = np.outer(weights, weights) * pad.area / 4
        f_z = stiffness * pressure(x, y, *deflection)
        total += [(y * f_z * d_area).sum(), -(x * f_z * d_area).sum(), (f_z * d_area).sum()]
    return total


def moments(pads):
    """Return A, r_c and I_xy of a set of pads."""
    area = sum(pad.area for pad in pads)
    center = sum(pad.area * np.array([pad.x, pad.y]) for pad in pads) / area
    return area, center, sum(pad.area * pad.x * pad.y for pad in pads)


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_u_is_the_integral_over_the_sole(pads):
    integral = np.column_stack([surface_integral(pads, STIFFNESS, unit) for unit in np.eye(3)])
    scale = np.abs(integral).max()
    assert contact_matrix(pads, STIFFNESS) == pytest.approx(integral, rel=1e-9, abs=1e-12 * scale)


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_u_is_symmetric(pads):
    u = contact_matrix(pads, STIFFNESS)
    assert np.array_equal(u, u.T)


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_diagonal_is_negative(pads):
    assert (np.diag(contact_matrix(pads, STIFFNESS)) < 0).all()


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_u_is_negative_definite(pads):
    assert np.linalg.eigvalsh(contact_matrix(pads, 1.0)).max() < 0


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_off_diagonal_signs_are_those_of_eq_8(pads):
    area, (r_x, r_y), i_xy = moments(pads)
    u = contact_matrix(pads, STIFFNESS) / STIFFNESS
    assert u[0, 1] == pytest.approx(i_xy, abs=1e-12)
    assert u[0, 2] == pytest.approx(-r_y * area, abs=1e-12)
    assert u[1, 2] == pytest.approx(r_x * area, abs=1e-12)


@given(pads=PAD_SETS, factor=st.floats(0.01, 100))
@settings(deadline=None)
def test_u_is_proportional_to_the_stiffness(pads, factor):
    expected = factor * contact_matrix(pads, STIFFNESS)
    assert contact_matrix(pads, factor * STIFFNESS) == pytest.approx(expected, rel=1e-12)


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_pads_mirrored_sideways_mirror_u(pads):
    sides = np.array([-1.0, 1.0, 1.0])
    mirrored = contact_matrix([replace(pad, y=-pad.y) for pad in pads], STIFFNESS)
    expected = np.outer(sides, sides) * contact_matrix(pads, STIFFNESS)
    assert mirrored == pytest.approx(expected, rel=1e-12)


@given(pads=PAD_SETS)
@settings(deadline=None)
def test_pads_mirrored_lengthwise_mirror_u(pads):
    ends = np.array([1.0, -1.0, 1.0])
    mirrored = contact_matrix([replace(pad, x=-pad.x) for pad in pads], STIFFNESS)
    expected = np.outer(ends, ends) * contact_matrix(pads, STIFFNESS)
    assert mirrored == pytest.approx(expected, rel=1e-12)


@given(pads=PAD_SETS, more=PAD_SETS)
@settings(deadline=None)
def test_feet_add_up(pads, more):
    total = contact_matrix(pads, STIFFNESS) + contact_matrix(more, STIFFNESS)
    scale = np.abs(total).max()
    together = contact_matrix(pads + more, STIFFNESS)
    assert together == pytest.approx(total, rel=1e-9, abs=1e-12 * scale)


def test_no_pad_gives_no_wrench():
    assert np.array_equal(contact_matrix([], STIFFNESS), np.zeros((3, 3)))


def test_whole_foot_has_a_diagonal_and_invertible_u():
    u = contact_matrix(PADS, STIFFNESS)
    assert u - np.diag(np.diag(u)) == pytest.approx(np.zeros((3, 3)), abs=1e-9)
    assert np.linalg.cond(u) < 1e3


def test_front_pads_alone_couple_height_and_pitch():
    u = contact_matrix(PADS[2:], STIFFNESS)
    area = sum(pad.area for pad in PADS[2:])
    assert u[1, 2] == pytest.approx(0.095 * STIFFNESS * area)
    assert u[0, 2] == pytest.approx(0.0, abs=1e-9)


def test_sinking_in_pushes_the_foot_up():
    _, _, f_z = contact_matrix(PADS, STIFFNESS) @ [0.0, 0.0, -0.001]
    assert f_z == pytest.approx(0.001 * STIFFNESS * sum(pad.area for pad in PADS))
