"""The contact of a foot as it is sensed: against eq. 6 and 8, NumPy, and brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from one_foot import foot_angles
from pydrake.math import RollPitchYaw

from lola_drake.robot import PADS
from lola_drake.theory.contact_model import command_gradient, contact_matrix
from lola_drake.theory.sensed_contact import (
    behind_servos,
    foot_axes,
    inclined,
    kept,
    pad_model,
    safe_motion,
    sensed_gradient,
    symmetric_eigen,
    turned,
)

AREA_STIFFNESS = 3e5 / sum(pad.area for pad in PADS)
MODEL = pad_model(PADS, AREA_STIFFNESS)
U = contact_matrix(PADS, AREA_STIFFNESS)
SERVOS = np.diag([8e-5, 9e-5, 6e-7]) + 1e-7
ALL, FRONT, LEFT = np.ones(4), np.array([0.0, 0.0, 1.0, 1.0]), np.array([1.0, 0.0, 1.0, 0.0])
LEVEL = (0.0, 0.0)
LENGTHS = np.array([MODEL.radius, MODEL.radius, 1.0])


def test_pads_together_are_the_foot():
    assert MODEL.matrices.sum(axis=0) == pytest.approx(U)
    assert sensed_gradient(ALL, MODEL, LEVEL, (9.0, 9.0, 300.0)) == pytest.approx(U)
    front = contact_matrix(PADS[2:], AREA_STIFFNESS)
    assert sensed_gradient(FRONT, MODEL, LEVEL, (0.0, 0.0, 0.0)) == pytest.approx(front)


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6))
def test_eigenvectors_are_those_of_numpy(entries):
    a, b, c, d, e, f = entries
    matrix = np.array([[a, b, c], [b, d, e], [c, e, f]])
    values, vectors = symmetric_eigen(matrix)
    assert np.sort(values) == pytest.approx(np.linalg.eigvalsh(matrix), abs=1e-9)
    assert vectors @ vectors.T == pytest.approx(np.eye(3), abs=1e-12)
    assert vectors * values @ vectors.T == pytest.approx(matrix, abs=1e-9)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3, 3))
def test_axes_of_a_foot_are_the_columns_of_its_rotation(roll, pitch, yaw):
    rotation = RollPitchYaw(roll, pitch, yaw).ToRotationMatrix().matrix()
    axes = foot_axes(*foot_angles(rotation))
    assert np.array(axes).T == pytest.approx(rotation[:, :2], abs=1e-12)


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-1, 1), st.floats(-0.3, 0.3))
def test_inclination_is_that_of_torso_and_foot_together(roll, pitch, yaw, lean):
    foot = RollPitchYaw(roll, pitch, yaw).ToRotationMatrix().matrix()
    torso = RollPitchYaw(lean, -0.7 * lean, 0.0).ToRotationMatrix().matrix()
    together = torso @ foot
    found = inclined(foot_axes(*foot_angles(foot)), (lean, -0.7 * lean))
    assert found == pytest.approx((together[2, 1], -together[2, 0]), abs=1e-12)


def wrench_of(x):
    """Return eq. 3 to 5 for x = (sin alpha_x, sin alpha_y, z), summed over points of the pads."""
    wrench = np.zeros(3)
    cosines = np.sqrt(1 - np.square(x[:2]))
    nodes = np.array([-1, 1]) / np.sqrt(3) / 2
    for pad in PADS:
        for a in nodes:
            for b in nodes:
                f_x, f_y = pad.x + a * pad.length, pad.y + b * pad.width
                force = AREA_STIFFNESS * pad.area / 4 * (f_x * x[1] - f_y * x[0] - x[2])
                wrench += force * np.array([f_y * cosines[0], -f_x * cosines[1], 1.0])
    return wrench


@pytest.mark.parametrize("x", [(0.17, -0.1, -0.002), (-0.3, 0.25, -0.004), (0.0, 0.0, -0.001)])
def test_gradient_is_the_derivative_of_eq_6_at_any_angle(x):
    x, step = np.array(x), 1e-6
    numeric = np.array(
        [(wrench_of(x + step * e) - wrench_of(x - step * e)) / (2 * step) for e in np.eye(3)]
    ).T
    cosines = np.diag([*np.sqrt(1 - np.square(x[:2])), 1.0])
    gradient = cosines @ sensed_gradient(ALL, MODEL, x[:2], wrench_of(x))
    scale = np.sqrt(np.outer(np.diag(U), np.diag(U)))
    assert gradient / scale == pytest.approx(numeric / scale, abs=1e-7)


def test_small_angles_err_where_they_are_not_small():
    """By the cosine of 10 degrees, 1.5 %, in the torque's own gradient."""
    x = np.array([np.sin(np.radians(10.0)), 0.0, -0.002])
    exact = np.sqrt(1 - x[0] ** 2) * sensed_gradient(ALL, MODEL, x[:2], wrench_of(x))[0, 0]
    assert U[0, 0] / exact - 1 == pytest.approx(0.015, abs=0.04)
    assert abs(U[0, 0] / exact - 1) > 0.01


def test_a_turned_wrench_is_the_same_about_other_axes():
    wrench, yaw = np.array([5.0, -3.0, 400.0]), 0.35
    rotation = RollPitchYaw(0.0, 0.0, yaw).ToRotationMatrix().matrix()
    assert turned(wrench, yaw)[:2] == pytest.approx((rotation.T @ [5.0, -3.0, 0.0])[:2])
    assert turned(wrench, yaw)[2] == 400.0


def test_servos_in_series_are_those_of_the_command_gradient():
    assert behind_servos(U, SERVOS) == pytest.approx(command_gradient(U, SERVOS))
    one = contact_matrix(PADS[:1], AREA_STIFFNESS)
    assert behind_servos(one, SERVOS) == pytest.approx(command_gradient(one, SERVOS))
    assert not behind_servos(np.zeros((3, 3)), SERVOS).any()


def test_with_all_pads_it_is_the_inverse_of_the_gradient():
    drive = np.array([300.0, -200.0, 4000.0])
    gradient = behind_servos(U, SERVOS)
    found = safe_motion(gradient, drive, np.array([9.0, 9.0, 9.0]), MODEL)
    expected = np.linalg.solve(gradient, drive)
    assert np.abs(found / expected - 1).max() < 1e-12


def test_a_direction_without_stiffness_is_free_and_another_one_is_not():
    """On its front pads a foot can turn about their line; it can press them down, and roll."""
    gradient = sensed_gradient(FRONT, MODEL, LEVEL, (0.0, 0.0, 0.0))
    ahead = np.array([0.0, 1.0, 0.095])  # The pads' middles stay where they are.
    assert safe_motion(gradient, np.zeros(3), 0.3 * ahead, MODEL) == pytest.approx(
        0.3 * ahead, rel=0.02
    )
    down = np.array([0.0, 0.0, -0.01])
    pressed = safe_motion(gradient, gradient @ down, np.zeros(3), MODEL)
    assert (gradient @ pressed)[2] == pytest.approx((gradient @ down)[2], rel=0.02)
    roll = np.array([0.1, 0.0, 0.0])
    assert safe_motion(gradient, gradient @ roll, np.zeros(3), MODEL) == pytest.approx(roll)


def test_motion_is_bounded_and_continuous_while_pads_open_one_after_the_other():
    drive, free = np.array([300.0, -200.0, 4000.0]), np.array([0.2, -0.1, 0.05])
    rates = []
    for pad in range(4):
        for s in np.linspace(1.0, 0.0, 2000):
            share = np.array([0.0] * pad + [s] + [1.0] * (3 - pad))
            gradient = behind_servos(sensed_gradient(share, MODEL, LEVEL, np.zeros(3)), SERVOS)
            rates.append(safe_motion(gradient, drive, free, MODEL) * LENGTHS)
    rates = np.array(rates)
    full = np.abs(rates[0]).max()
    assert rates[-1] == pytest.approx(free * LENGTHS)
    assert np.abs(rates).max() < 10 * full
    assert np.abs(np.diff(rates, axis=0)).max() < 0.01 * np.abs(rates).max()


def test_a_direction_is_kept_smoothly():
    shares = np.array([kept(s) for s in np.linspace(0, 0.4, 4001)])
    assert shares[0] == kept(0.05) == 0.0 and kept(0.25) == shares[-1] == 1.0
    assert (np.diff(shares) >= 0).all() and np.diff(shares).max() < 1e-3
