"""U of eq. 8 against the integral over the sole that it stands for."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.robot import PADS
from lola_drake.theory.contact_model import Pad, ServoCompliance, command_gradient, contact_matrix

positions = st.floats(-0.2, 0.2)
extents = st.floats(0.005, 0.1)
soles = st.lists(st.builds(Pad, positions, positions, extents, extents), min_size=1, max_size=6)


def surface_integral(pads, area_stiffness, x_f, points=4):
    """Return T_x, T_y, F_z of vertical springs all over the pads, summed up numerically.

    The height of an element over its unloaded place is z + y sin alpha_x - x sin alpha_y.
    """
    nodes, weights = np.polynomial.legendre.leggauss(points)
    wrench = np.zeros(3)
    for pad in pads:
        for u, weight_u in zip(nodes, weights, strict=True):
            for v, weight_v in zip(nodes, weights, strict=True):
                x, y = pad.x + u * pad.length / 2, pad.y + v * pad.width / 2
                height = x_f[2] + y * x_f[0] - x * x_f[1]
                force = -area_stiffness * height * weight_u * weight_v * pad.area / 4
                wrench += [y * force, -x * force, force]
    return wrench


@given(soles, st.tuples(*3 * [st.floats(-0.1, 0.1)]))
def test_matrix_is_the_surface_integral(pads, x_f):
    stiffness = 1e6
    expected = surface_integral(pads, stiffness, x_f)
    scale = stiffness * sum(pad.area for pad in pads)
    got = contact_matrix(pads, stiffness) @ x_f
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9 * scale)


@given(soles)
def test_matrix_is_symmetric_and_negative_definite(pads):
    matrix = contact_matrix(pads, 1e6)
    np.testing.assert_array_equal(matrix, matrix.T)
    assert np.linalg.eigvalsh(matrix).max() < 0


def test_signs_are_those_of_equation_8():
    """Pressed down, the ground pushes up; a foot that rolls or pitches is turned back."""
    front_left = contact_matrix([PADS[2]], 1e6)
    assert np.all(np.diag(front_left) < 0)
    # Pushed into the ground on the front left: up, roll to the right, pitch backward.
    t_x, t_y, f_z = front_left @ [0.0, 0.0, -0.001]
    assert f_z > 0
    assert t_x > 0
    assert t_y < 0


def test_symmetric_foot_does_not_couple():
    matrix = contact_matrix(PADS, 1e6)
    np.testing.assert_allclose(matrix - np.diag(np.diag(matrix)), 0, atol=1e-9)


@given(soles, soles)
def test_pads_add_up(some, others):
    together = contact_matrix([*some, *others], 1e6)
    expected = contact_matrix(some, 1e6) + contact_matrix(others, 1e6)
    np.testing.assert_allclose(together, expected, rtol=1e-12, atol=1e-6)


def test_a_contact_behind_a_compliance_is_met_where_both_balance():
    """The foot is moved by its wrench until contact and compliance agree on it."""
    contact = contact_matrix(PADS, 3e5 / sum(pad.area for pad in PADS))
    compliance = np.array([[1e-4, 0.0, 5e-6], [0.0, 1.5e-4, 0.0], [5e-6, 0.0, 1e-6]])
    command, wrench = np.array([2e-3, -1e-3, -1e-3]), np.zeros(3)
    for _ in range(200):
        wrench = 0.5 * wrench + 0.5 * contact @ (command + compliance @ wrench)
    np.testing.assert_allclose(command_gradient(contact, compliance) @ command, wrench, rtol=1e-9)


def test_springs_in_series_are_softer_than_either():
    stiffness = -command_gradient(-300.0 * np.eye(3), np.eye(3) / 600.0)
    np.testing.assert_allclose(stiffness, 200.0 * np.eye(3))


def test_a_servo_gives_way_less_to_what_is_quick():
    compliance = ServoCompliance(np.eye(3) / 600.0, relaxation=0.014)
    np.testing.assert_allclose(compliance.within(1e6), np.eye(3) / 600.0, rtol=1e-6)
    np.testing.assert_allclose(compliance.within(0.014), np.eye(3) / 1200.0)
