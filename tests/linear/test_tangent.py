"""Coordinates of small motions of floating bases."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from lola_drake.linear.tangent import Tangent, tangent_of

TANGENT = Tangent(9, (2,))


@pytest.fixture
def state():
    quaternion = np.array([0.5, -0.3, 0.7, 0.2])
    return np.concatenate([[3.0, -1.0], quaternion / np.linalg.norm(quaternion), [0.1, 2.0, 4.0]])


def test_lift_and_project_are_inverse_to_each_other(state):
    product = TANGENT.project(state) @ TANGENT.lift(state)
    np.testing.assert_allclose(product, np.eye(8), atol=1e-14)


def test_a_motion_is_found_again_as_the_difference(state):
    motion = np.array([1.0, 2.0, 0.4, -0.9, 1.3, 0.0, -1.0, 5.0])
    moved = TANGENT.move(state, motion)
    assert np.linalg.norm(moved[2:6]) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(TANGENT.difference(moved, state), motion, atol=1e-14)


def test_lift_is_the_derivative_of_a_motion(state):
    step = 1e-7
    for k, column in enumerate(TANGENT.lift(state).T):
        motion = step * np.eye(8)[k]
        ahead, behind = TANGENT.move(state, motion), TANGENT.move(state, -motion)
        np.testing.assert_allclose((ahead - behind) / (2 * step), column, atol=1e-9)


def test_the_rotation_vector_turns_with_the_angular_velocity():
    plant = MultibodyPlant(1e-3)
    plant.AddRigidBody("box", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.2, 0.3))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    tangent = tangent_of(plant, 13)
    assert (tangent.quaternions, tangent.dimension) == ((0,), 12)
    velocity = np.array([0.3, -0.2, 0.5, 0.0, 0.0, 0.0])
    rates = plant.MapVelocityToQDot(context, velocity)
    state = np.concatenate([plant.GetPositions(context), np.zeros(6)])
    motion = tangent.project(state) @ np.concatenate([rates, np.zeros(6)])
    np.testing.assert_allclose(motion[:3], velocity[:3], atol=1e-15)
