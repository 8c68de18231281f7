"""Inverse kinematics: the task is followed, the null space is used, the limits are kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.multibody.tree import JacobianWrtVariable

from lola_drake.blocks.inverse_kinematics import (
    InverseKinematics,
    InverseKinematicsParams,
    null_space_motion,
    resolve_rates,
)
from lola_drake.robot import JOINT_INDEX, Kinematics, posture, solve_posture
from lola_drake.signals import JOINT_COMMAND, JOINTS
from lola_drake.theory.constants import GRAVITY

PERIOD, N = 0.001, len(JOINTS)
BENT = posture(hip=0.4, knee=0.8)
HEAD_AND_TOES = [JOINT_INDEX[name] for name in ("tvp", "tvt", "tzfl", "tzfr")]
unit = st.floats(-1.0, 1.0)


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@given(arrays(float, (4, 7), elements=unit), arrays(float, 4, elements=unit))
def test_wish_does_not_disturb_the_task(jacobian, rates):
    jacobian = jacobian + np.eye(4, 7) * 5  # far from singular
    wish = np.linspace(-1, 1, 7)
    got = resolve_rates(jacobian, rates, np.ones(7), wish, np.zeros((4, 4)))
    np.testing.assert_allclose(jacobian @ got, rates, atol=1e-10)
    null = np.eye(7) - np.linalg.pinv(jacobian) @ jacobian
    np.testing.assert_allclose(got, np.linalg.pinv(jacobian) @ rates + null @ wish, atol=1e-10)


@given(arrays(float, (4, 7), elements=unit), arrays(float, 4, elements=unit))
def test_joint_without_mobility_keeps_its_wish(jacobian, rates):
    jacobian = jacobian + np.eye(4, 7) * 5
    mobility, wish = np.array([1, 1, 1, 1, 1, 0, 1.0]), np.linspace(-1, 1, 7)
    got = resolve_rates(jacobian, rates, mobility, wish, np.zeros((4, 4)))
    assert got[5] == wish[5]
    np.testing.assert_allclose(jacobian @ got, rates, atol=1e-9)


def test_singular_task_is_damped():
    jacobian = np.array([[1.0, 0, 0], [1.0, 0, 0]])
    got = resolve_rates(jacobian, np.array([1.0, -1]), np.ones(3), np.zeros(3), 1e-4 * np.eye(2))
    assert np.abs(got).max() < 1.0


def test_null_space_motion_descends_its_cost():
    lower, upper, comfort = np.full(3, -0.5), np.full(3, 0.5), np.array([0.2, 0.0, 0.0])
    q = np.array([0.2, 0.7, -0.9])
    got = null_space_motion(q, comfort, lower, upper, 2.0, 5.0)
    np.testing.assert_allclose(got, [0.0, -1.4 - 1.0, 1.8 + 2.0])


class Solver:
    """The block, stepped tick by tick with commands for both feet."""

    def __init__(self, kinematics, initial=BENT, **params):
        kinematics.update(initial)
        self.w = kinematics.w.copy()
        self.w_dot, self.reference, self.wrench = np.zeros(12), np.zeros(28), np.zeros(12)
        self.kinematics = kinematics
        self.block = InverseKinematics(
            InverseKinematicsParams(**params), kinematics, initial, PERIOD
        )
        self.context = self.block.CreateDefaultContext()

    def step(self):
        """Return the joint command of this tick."""
        inputs = {
            "task_command_l": np.r_[self.w[:6], self.w_dot[:6]],
            "task_command_r": np.r_[self.w[6:], self.w_dot[6:]],
            "task_reference": self.reference,
            "desired_wrench": self.wrench,
        }
        for name, value in inputs.items():
            self.block.GetInputPort(name).FixValue(self.context, value)
        command = self.block.GetOutputPort("joint_command").Eval(self.context).copy()
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        return command

    def reached(self):
        """Return w at the commanded angles."""
        self.kinematics.update(self.context.get_discrete_state_vector().value())
        return self.kinematics.w.copy()


def test_task_in_reach_is_held(kinematics):
    solver = Solver(kinematics)
    for _ in range(20):
        command = solver.step()
    np.testing.assert_allclose(command[:N], BENT, atol=1e-12)
    np.testing.assert_allclose(command[N : 2 * N], 0, atol=1e-9)


def test_moving_task_is_followed(kinematics):
    """A foot on a circle of 5 cm in a second: within 10 um and 20 urad, the damping's part."""
    solver = Solver(kinematics)
    start = solver.w.copy()
    direction = np.array([0.05, 0.0, 0.05, 0.1, -0.1, 0.1])
    for k in range(1000):
        phase = 2 * np.pi * PERIOD * np.array([k, k + 1])
        solver.w[:6] = start[:6] + direction * (1 - np.cos(phase[0]))
        solver.w_dot[:6] = direction * 2 * np.pi * np.sin(phase[0])
        solver.step()
        wanted = start[:6] + direction * (1 - np.cos(phase[1]))
        error = np.abs(solver.reached() - np.r_[wanted, start[6:]])
        assert error[[0, 1, 2, 6, 7, 8]].max() < 2e-5
        assert error[[3, 4, 5, 9, 10, 11]].max() < 1e-4


def test_drift_is_removed(kinematics):
    solver = Solver(kinematics)
    solver.w[2] += 0.01
    errors = []
    for _ in range(40):
        errors.append(solver.w[2] - solver.reached()[2])
        solver.step()
    np.testing.assert_allclose(errors, 0.01 * 0.9 ** np.arange(40), rtol=0.02, atol=2e-5)


def test_null_space_returns_to_the_comfort_pose_without_moving_the_feet(kinematics):
    solver = Solver(kinematics)
    disturbed = BENT.copy()
    disturbed[JOINT_INDEX["tba"]] += 0.05
    disturbed[JOINT_INDEX["tafl"]] += 0.3
    disturbed = solve_posture(kinematics, solver.w, disturbed)
    solver.context.SetDiscreteState(disturbed)
    distances = []
    for _ in range(3000):
        command = solver.step()
        distances.append(np.linalg.norm(command[:N] - BENT))
        assert np.abs(solver.reached() - solver.w).max() < 1e-5
    assert np.all(np.diff(distances) <= 1e-12)
    assert distances[-1] < 0.02 * distances[0]


def test_toes_and_head_are_prescribed(kinematics):
    solver = Solver(kinematics)
    solver.reference[12:14] = [0.1, 0.2]
    solver.w += 0.01 * np.sin(np.arange(12.0))
    for _ in range(200):
        command = solver.step()
    np.testing.assert_allclose(command[HEAD_AND_TOES], [0, 0, 0.1, -0.2], atol=1e-8)


def test_redundant_joints_retreat_from_their_limits(kinematics):
    """Also where the comfort pose lies next to a limit."""
    lower, upper = kinematics.position_limits
    comfort = BENT.copy()
    arm = JOINT_INDEX["taar"]
    comfort[arm] = upper[arm] - 0.01
    solver = Solver(kinematics, initial=comfort, limit_margin=0.2, limit_gain=20.0)
    for _ in range(2000):
        q = solver.step()[:N]
    assert np.all(q >= lower)
    assert np.all(q <= upper)
    assert q[arm] < upper[arm] - 0.15


def test_feedforward_torque_carries_the_robot(kinematics):
    """Standing on both feet, -J^T lambda is what gravity asks of the legs' joints."""
    solver = Solver(kinematics)
    half = 0.5 * kinematics.mass * GRAVITY
    x = 0.5 * (solver.w[0] + solver.w[6])
    solver.wrench[:6] = [0.0, x * half, half, 0.0, x * half, half]
    torque = solver.step()[JOINT_COMMAND.slice("torque")]
    plant, context = kinematics.plant, kinematics.context
    kinematics.update(BENT)
    gravity = -plant.CalcGravityGeneralizedForces(context)
    contact = np.zeros(plant.num_velocities())
    for foot in "lr":
        frame, world = plant.GetFrameByName(f"tcp_{foot}"), plant.world_frame()
        jacobian = plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world
        )
        contact += jacobian.T @ [0, x * half, 0, 0, 0, half]
    expected = gravity - contact
    np.testing.assert_allclose(expected[:6], 0, atol=0.5)
    np.testing.assert_allclose(torque, expected[6:], atol=1e-6)
