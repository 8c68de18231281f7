"""The inverse kinematics: the task, the null space, the limits, and the holding torque."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.tree import MultibodyForces
from ticking import Ticking

from lola_drake.blocks.inverse_kinematics import (
    InverseKinematics,
    InverseKinematicsParams,
    resolved_rates,
    wished_rates,
)
from lola_drake.robot import JOINT_INDEX, Kinematics, posture
from lola_drake.signals import (
    DESIRED_WRENCH,
    GAIT_PHASE,
    IDEAL_WRENCH,
    JOINT_COMMAND,
    PERIOD,
    TASK_REFERENCE,
)
from lola_drake.theory.constants import GRAVITY

Q, Q_DOT = JOINT_COMMAND.slice("q"), JOINT_COMMAND.slice("q_dot")
TORQUE = JOINT_COMMAND.slice("torque")
SEEDS = st.integers(0, 2**32 - 1)
RESTING = np.zeros(2), np.zeros(2), 0.0
"""Toes, their rates, and no correction of the joints that are prescribed."""


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@pytest.fixture
def bent():
    return posture(hip=0.4, knee=0.8)


class Joints(Ticking):
    """The block; at the start it is where it shall be."""

    def __init__(self, kinematics, q, **params):
        self.params = InverseKinematicsParams(**params)
        self.kinematics = kinematics
        super().__init__(InverseKinematics(self.params, kinematics, q))
        kinematics.update(q)
        self.w = kinematics.w.copy()
        self.reference, self.desired = np.zeros(TASK_REFERENCE.size), np.zeros(DESIRED_WRENCH.size)
        self.ideal, self.load = np.zeros(IDEAL_WRENCH.size), np.array([0.5, 0.5])
        self.ask(self.w, np.zeros(12))

    def ask(self, w, w_dot):
        for foot, own in (("l", slice(0, 6)), ("r", slice(6, 12))):
            self.fix(f"task_command_{foot}", np.r_[w[own], w_dot[own]])
        self.fix("task_reference", self.reference)
        self.fix("desired_wrench", self.desired)
        self.fix("ideal_wrench", self.ideal)
        self.fix("gait_phase", self.load, GAIT_PHASE.slice("load"))

    def command(self):
        return self.output("joint_command")

    def step(self, ticks=1):
        super().step(ticks)
        return self.q()

    def q(self):
        return self.state("joint_angles")

    def task(self):
        self.kinematics.update(self.q())
        return self.kinematics.w.copy()


def test_feet_that_shall_stay_stay(kinematics, bent):
    joints = Joints(kinematics, bent)
    joints.step(100)
    assert joints.task() == pytest.approx(joints.w, abs=1e-4)


@pytest.mark.parametrize("entry", range(12))
def test_one_tick_follows_the_task_to_first_order(kinematics, bent, entry):
    joints = Joints(kinematics, bent, damping=1e-9)
    w_dot = np.zeros(12)
    w_dot[entry] = 0.1
    joints.ask(joints.w, w_dot)
    joints.step()
    assert joints.task() - joints.w == pytest.approx(PERIOD * w_dot, abs=1e-6)


def test_error_of_the_task_decays_by_the_drift_correction(kinematics, bent):
    joints = Joints(kinematics, bent, damping=1e-9)
    shift = np.zeros(12)
    shift[[0, 8, 11]] = 0.005, 0.005, 0.02
    joints.ask(joints.w + shift, np.zeros(12))
    joints.step(10)
    left = joints.w + shift - joints.task()
    assert left == pytest.approx(0.9**10 * shift, abs=2e-4)


def test_moving_task_is_followed(kinematics, bent):
    joints = Joints(kinematics, bent)
    w, w_dot = joints.w.copy(), np.zeros(12)
    w_dot[[0, 2, 6]] = 0.3, 0.1, -0.3
    for _ in range(200):
        joints.ask(w, w_dot)
        joints.step()
        w = w + PERIOD * w_dot
    assert joints.task() == pytest.approx(w, abs=2e-3)


@given(SEEDS)
def test_wish_does_not_disturb_the_task(seed):
    random = np.random.default_rng(seed)
    jacobian, rates = random.normal(size=(12, 24)), random.normal(size=12)
    for wish in (np.zeros(24), 10 * random.normal(size=24)):
        q_dot = resolved_rates(jacobian, rates, np.ones(24), wish, 1e-12)
        assert jacobian @ q_dot == pytest.approx(rates, abs=1e-6)


@given(SEEDS)
def test_wish_in_the_null_space_is_granted(seed):
    random = np.random.default_rng(seed)
    jacobian = random.normal(size=(12, 24))
    wish = random.normal(size=24)
    wish -= np.linalg.pinv(jacobian) @ jacobian @ wish
    q_dot = resolved_rates(jacobian, np.zeros(12), np.ones(24), wish, 1e-12)
    assert q_dot == pytest.approx(wish, abs=1e-6)


@given(SEEDS)
def test_joint_without_mobility_keeps_its_wish(seed):
    random = np.random.default_rng(seed)
    jacobian, rates, wish = (random.normal(size=shape) for shape in ((12, 24), 12, 24))
    mobility = np.ones(24)
    mobility[[3, 7]] = 0.0
    q_dot = resolved_rates(jacobian, rates, mobility, wish, 1e-12)
    assert np.array_equal(q_dot[[3, 7]], wish[[3, 7]])
    assert jacobian @ q_dot == pytest.approx(rates, abs=1e-5)


@given(SEEDS, st.floats(-12, 0))
def test_damping_bounds_the_rates_however_small_the_singular_value(seed, exponent):
    random = np.random.default_rng(seed)
    u, _, vt = np.linalg.svd(random.normal(size=(12, 24)), full_matrices=False)
    sizes = np.ones(12)
    sizes[-1] = 10**exponent
    damping = 1e-4
    rates = random.normal(size=12)
    q_dot = resolved_rates((u * sizes) @ vt, rates, np.ones(24), np.zeros(24), damping)
    assert np.linalg.norm(q_dot) <= np.linalg.norm(rates) / (2 * np.sqrt(damping)) + 1e-9


def test_stretched_legs_that_shall_get_longer_move_no_joint_fast(kinematics):
    joints = Joints(kinematics, posture(hip=0.0, knee=0.0))
    w_dot = np.zeros(12)
    w_dot[[2, 8]] = -0.3
    joints.ask(joints.w, w_dot)
    bound = np.linalg.norm(w_dot) / (2 * np.sqrt(joints.params.damping))
    q_dot = joints.command()[Q_DOT]
    assert np.isfinite(q_dot).all()
    assert np.linalg.norm(q_dot - _wish(joints)) <= bound


def _wish(joints):
    """Return the null space motion at the joint limits, where the comfort pose is reached."""
    lower, upper = joints.kinematics.position_limits
    margin, q = joints.params.limit_margin, joints.q()
    gains = joints.params.comfort_gain, joints.params.limit_gain
    return wished_rates(q, q, lower + margin, upper - margin, *gains, *RESTING)


def test_null_space_returns_to_the_comfort_pose():
    q, comfort, far = np.zeros(24), np.zeros(24), np.full(24, 9.0)
    q[[3, 7]] = 0.3, -0.2
    expected = np.zeros(24)
    expected[[3, 7]] = -0.6, 0.4
    assert wished_rates(q, comfort, -far, far, 2.0, 5.0, *RESTING) == pytest.approx(expected)


def test_null_space_retreats_from_the_limits_alone():
    q = np.zeros(24)
    q[[3, 7, 9]] = 1.2, -1.3, 0.9
    lower, upper = np.full(24, -1.0), np.full(24, 1.0)
    expected = np.zeros(24)
    expected[[3, 7]] = -1.0, 1.5
    assert wished_rates(q, q, lower, upper, 2.0, 5.0, *RESTING) == pytest.approx(expected)


@pytest.mark.parametrize(("name", "side"), [("tefr", 0), ("tefr", 1), ("taal", 0), ("taal", 1)])
def test_joint_near_its_limit_is_pushed_away(kinematics, bent, name, side):
    joint = JOINT_INDEX[name]
    limit, inwards = kinematics.position_limits[side][joint], 1 - 2 * side
    bent[joint] = limit + 0.02 * inwards
    joints = Joints(kinematics, bent)
    q = joints.step(200)
    assert inwards * (q[joint] - bent[joint]) > 0.03
    assert joints.task() == pytest.approx(joints.w, abs=2e-3)


def test_toes_follow_their_plan(kinematics, bent):
    joints = Joints(kinematics, bent)
    joints.reference[TASK_REFERENCE.slice("toe_rates")] = 0.5, -0.3
    for k in range(100):
        joints.reference[TASK_REFERENCE.slice("toes")] = 0.5 * k * PERIOD, -0.3 * k * PERIOD
        joints.ask(joints.w, np.full(12, 0.02))
        joints.step()
    toes = joints.q()[[JOINT_INDEX["tzfl"], JOINT_INDEX["tzfr"]]]
    assert toes == pytest.approx([0.05, 0.03])


def test_head_returns_to_zero_by_the_drift_correction(kinematics, bent):
    head = [JOINT_INDEX["tvp"], JOINT_INDEX["tvt"]]
    bent[head] = 0.2, -0.1
    joints = Joints(kinematics, bent)
    joints.ask(joints.w, np.full(12, 0.1))
    assert joints.step(10)[head] == pytest.approx(0.9**10 * np.array([0.2, -0.1]))


def test_command_is_where_its_rates_lead(kinematics, bent):
    joints = Joints(kinematics, bent)
    joints.ask(joints.w, np.full(12, 0.1))
    command = joints.command()
    assert command[Q] == pytest.approx(bent + PERIOD * command[Q_DOT])
    assert np.array_equal(joints.step(), command[Q])


def standing_wrench(kinematics, q, left=0.5, horizontal=(0.0, 0.0)):
    """Return T_x, T_y, F_z of each foot for the left foot's share, so that nothing turns."""
    kinematics.update(q)
    shares = np.array([left, 1 - left])
    forces, (pull_x, pull_y) = kinematics.mass * GRAVITY * shares, np.outer(horizontal, shares)
    x, y, z = kinematics.w.reshape(2, 6)[:, :3].T
    rest = -np.array([y @ forces - z @ pull_y, z @ pull_x - x @ forces])
    return np.array(
        [
            [left * rest[0], left * rest[1], forces[0]],
            [(1 - left) * rest[0], (1 - left) * rest[1], forces[1]],
        ]
    ).ravel()


def inverse_dynamics(kinematics, q, wrench, left=0.5, horizontal=(0.0, 0.0)):
    """Return what the plant needs to keep its posture: the torso's wrench (6), torques (24).

    Horizontal forces, which the feet share, accelerate all of it alike.
    """
    pulls = np.outer([left, 1 - left], horizontal)
    kinematics.update(q)
    plant, context = kinematics.plant, kinematics.context
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    for foot, (t_x, t_y, f_z), pull in zip("lr", wrench.reshape(2, 3), pulls, strict=True):
        frame = plant.GetFrameByName(f"tcp_{foot}")
        p_BTcp = frame.GetFixedPoseInBodyFrame().translation()
        frame.body().AddInForce(
            context,
            p_BTcp,
            SpatialForce([t_x, t_y, 0.0], [*pull, f_z]),
            plant.world_frame(),
            forces,
        )
    acceleration = np.zeros(plant.num_velocities())
    acceleration[3:5] = np.divide(horizontal, kinematics.mass)
    needed = plant.CalcInverseDynamics(context, acceleration, forces)
    return needed[:6], needed[6:]


@pytest.mark.parametrize("left", [0.5, 0.8, 0.0])
def test_feedforward_torque_is_the_static_one_of_the_plant(kinematics, bent, left):
    joints = Joints(kinematics, bent)
    wrench = standing_wrench(kinematics, bent, left)
    joints.desired[:6] = wrench
    joints.ask(joints.w, np.zeros(12))
    torso, torque = inverse_dynamics(kinematics, bent, wrench)
    assert torso == pytest.approx(np.zeros(6), abs=1e-6)
    assert joints.command()[TORQUE] == pytest.approx(torque, abs=1e-6)
    assert np.abs(torque).max() > 30.0


def test_horizontal_feedforward_holds_the_planned_horizontal_forces(kinematics, bent):
    left, horizontal = 0.8, (90.0, -30.0)
    wrench = standing_wrench(kinematics, bent, left, horizontal)
    torso, torque = inverse_dynamics(kinematics, bent, wrench, left, horizontal)
    # Nobody asks the feet for a torque about z.
    assert np.delete(torso, 2) == pytest.approx(np.zeros(5), abs=1e-6)
    for part in (0.0, 1.0):
        joints = Joints(kinematics, bent, horizontal_feedforward=part)
        joints.desired[:6] = wrench
        joints.ideal[:2], joints.load[:] = horizontal, (left, 1 - left)
        joints.ask(joints.w, np.zeros(12))
        missing = np.abs(joints.command()[TORQUE] - torque).max()
        assert missing < 1e-6 if part else missing > 10.0


def test_feedforward_scales_the_torque(kinematics, bent):
    torques = []
    for part in (1.0, 0.4, 0.0):
        joints = Joints(kinematics, bent, feedforward=part)
        joints.desired[:6] = standing_wrench(kinematics, bent)
        joints.ask(joints.w, np.zeros(12))
        torques.append(joints.command()[TORQUE])
    assert torques[1] == pytest.approx(0.4 * torques[0])
    assert torques[2] == pytest.approx(np.zeros(24))
