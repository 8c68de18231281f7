"""The predecessor's law [23] against its equations, and against the paper's law."""

import numpy as np
import pytest
from ticking import Ticking

from lola_drake.block_system import BlockSystem
from lola_drake.blocks.configuration_force_control import (
    ConfigurationForceControl,
    foot_law,
)
from lola_drake.blocks.foot_force_control import FORCE_CONTROLLED, modification_rate
from lola_drake.blocks.hybrid_force_control import HybridForceControlParams, force_control_rate
from lola_drake.blocks.inverse_kinematics import InverseKinematicsParams
from lola_drake.robot import JOINT_INDEX, PADS, Kinematics, foot_sensor_geometry, posture
from lola_drake.signals import GAIT_PHASE, TASK_REFERENCE
from lola_drake.theory.contact_model import Pad, ServoCompliance, command_gradient, contact_matrix
from lola_drake.theory.foot_wrench import FootSensor
from lola_drake.theory.kinematics import FOOT_TASK
from lola_drake.theory.pad_springs import behind_servos, opened_by_servos, solved, spring_gradient

POINTS = np.array([[pad.x, pad.y] for pad in PADS])
RIGID = np.column_stack([POINTS[:, 1], -POINTS[:, 0], np.ones(4)])
"""The points' heights by sin gamma_x, sin gamma_y and z of a rigid foot."""
STIFFNESS = np.array([3e4, 2e4, 4e4, 5e4])


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@pytest.fixture
def bent(kinematics):
    """Return joint angles without any symmetry, with the kinematics brought there."""
    q = posture(hip=0.4, knee=0.8) + 0.05 * np.sin(np.arange(24.0))
    kinematics.update(q)
    return q


def spring_wrench(sunk):
    """Return T_x, T_y, F_z of springs that are pressed in by `sunk` (m), from r x F."""
    total = np.zeros(3)
    for (x, y), depth, stiffness in zip(POINTS, sunk, STIFFNESS, strict=True):
        force = np.array([0.0, 0.0, stiffness * depth])
        total += [*np.cross([x, y, 0.0], force)[:2], force[2]]
    return total


def test_gradient_of_the_springs_is_that_of_their_wrench():
    heights = np.array([1e-3, -2e-3, 0.5e-3, 3e-3])
    gradient = spring_gradient(POINTS, np.eye(4), STIFFNESS)
    np.testing.assert_allclose(gradient @ heights, spring_wrench(-heights))


def test_springs_under_a_rigid_foot_are_pads_without_extent():
    side = 1e-6
    pads = [Pad(x=x, y=y, length=side, width=side) for x, y in POINTS]
    expected = contact_matrix(pads, 3e4 / side**2)
    gradient = spring_gradient(POINTS, RIGID, np.full(4, 3e4))
    np.testing.assert_allclose(gradient, expected, atol=1e-6 * np.abs(expected).max())


def test_springs_are_softer_in_rotation_than_pads_with_extent():
    area = sum(pad.area for pad in PADS)
    springs = spring_gradient(POINTS, RIGID, np.full(4, 1.2e5 / 4))
    pads = contact_matrix(PADS, 1.2e5 / area)
    assert springs[2, 2] == pytest.approx(pads[2, 2])
    assert springs[0, 0] / pads[0, 0] == pytest.approx(1 / (1 + 0.04**2 / 12 / 0.09**2))
    assert springs[1, 1] / pads[1, 1] == pytest.approx(1 / (1 + 0.08**2 / 12 / 0.095**2))


def test_springs_behind_the_servos_are_in_series_with_them():
    compliance = np.array([[1e-4, 2e-5, 1e-6], [2e-5, 1.5e-4, 3e-6], [1e-6, 3e-6, 1e-6]])
    gradient = spring_gradient(POINTS, RIGID, STIFFNESS)
    loop = opened_by_servos(gradient, compliance, 0.6)
    series = behind_servos(loop, gradient)
    np.testing.assert_allclose(series, command_gradient(gradient, 0.6 * compliance), rtol=1e-9)


@pytest.mark.parametrize("foot", [0, 1])
def test_height_rates_of_the_pads_are_those_of_their_heights(kinematics, bent, foot):
    _, rates = kinematics.pads(foot)
    step = 1e-6
    for joint in range(24):
        heights = []
        for sign in (1, -1):
            q = bent.copy()
            q[joint] += sign * step
            kinematics.update(q)
            heights.append(pad_heights(kinematics, foot))
        difference = (heights[0] - heights[1]) / (2 * step)
        np.testing.assert_allclose(rates[:, joint], difference, atol=1e-7)


def pad_heights(kinematics, foot):
    """Return the heights of the pads' centres over the CoM, found on another way."""
    plant, context = kinematics.plant, kinematics.context
    com = plant.CalcCenterOfMassPositionInWorld(context)
    name = "lr"[foot]
    tcp, toe = plant.GetFrameByName(f"tcp_{name}"), plant.GetFrameByName(f"zf{name}")
    straight = plant.CreateDefaultContext()
    heights = []
    for i, pad in enumerate(PADS):
        p_TcpPad = np.array([pad.x, pad.y, 0.0])
        if i < 2:
            p_WPad = tcp.CalcPoseInWorld(context) @ p_TcpPad
        else:
            p_ToePad = toe.CalcPose(straight, tcp).inverse() @ p_TcpPad
            p_WPad = toe.CalcPoseInWorld(context) @ p_ToePad
        heights.append(p_WPad[2] - com[2])
    return np.array(heights)


@pytest.mark.parametrize("foot", [0, 1])
def test_with_straight_toes_the_gradient_goes_through_the_task(kinematics, bent, foot):
    """Where the foot is rigid, eq. 9 and eq. 7 say the same: dlambda/dq = dlambda/dw J."""
    toes = [JOINT_INDEX["tzfl"], JOINT_INDEX["tzfr"]]
    q = bent.copy()
    q[toes] = 0.0
    kinematics.update(q)
    points, rates = pads(kinematics, foot)
    by_joints = spring_gradient(points, rates, STIFFNESS)
    by_task = spring_gradient(points, RIGID, STIFFNESS)
    task = kinematics.jacobian[FOOT_TASK * foot + FORCE_CONTROLLED]
    legs = np.delete(np.arange(24), toes)
    scale = np.abs(by_joints).max(axis=1, keepdims=True)
    np.testing.assert_allclose(
        (by_joints / scale)[:, legs], (by_task @ task / scale)[:, legs], atol=1e-9
    )


def pads(kinematics, foot):
    """Return where the pads' centres are relative to the TCP, and the rates of their heights."""
    points, rates = kinematics.pads(foot)
    return points - kinematics.w[FOOT_TASK * foot :][:2], rates


def law(kinematics, foot=0, *, blend, force_rate=(3.0, -4.0, 900.0), deviation=(0.02, -0.01, 0.03)):
    points, rates = pads(kinematics, foot)
    return foot_law(
        force_by_joints=spring_gradient(points, rates, STIFFNESS),
        force_by_task=spring_gradient(points, RIGID, STIFFNESS),
        task_by_joints=kinematics.jacobian[FOOT_TASK * foot + FORCE_CONTROLLED],
        force_rate=np.array(force_rate),
        deviation=np.array(deviation),
        blend=np.full(3, blend),
        position_gain=6.0,
    )


def test_force_control_makes_the_error_decay(kinematics, bent):
    """Eq. 14: joint rates that satisfy the rows change the springs' forces by e / delta."""
    error, time_constant = np.array([5.0, -7.0, 60.0]), 0.02
    rows, _, drive = law(kinematics, blend=1.0, force_rate=error / time_constant)
    q_dot = np.linalg.lstsq(rows, drive, rcond=None)[0]
    points, rates = pads(kinematics, 0)
    changed = spring_gradient(points, rates, STIFFNESS) @ q_dot
    np.testing.assert_allclose(changed, error / time_constant)


def test_position_control_returns_to_the_plan(kinematics, bent):
    rows, task_rows, drive = law(kinematics, blend=0.0)
    np.testing.assert_allclose(solved(task_rows, drive), [-0.12, 0.06, -0.18])
    np.testing.assert_allclose(rows, kinematics.jacobian[FORCE_CONTROLLED])


@pytest.mark.parametrize("blend", [0.0, 0.4, 1.0])
def test_with_the_same_stiffness_it_is_the_papers_law(kinematics, bent, blend):
    """With an uncoupled U (equal springs about the TCP) eq. 16 gives the same modification."""
    force_rate, deviation = np.array([3.0, -4.0, 900.0]), np.array([0.02, -0.01, 0.03])
    matrix = spring_gradient(POINTS, RIGID, np.full(4, 3e4))
    _, task_rows, drive = foot_law(
        np.zeros((3, 24)), matrix, np.zeros((3, 24)), force_rate, deviation, np.full(3, blend), 6.0
    )
    expected = modification_rate(
        np.array(force_control_rate(np.linalg.inv(matrix), 0.02 * force_rate, np.zeros(3), 0.02)),
        np.zeros(3),
        deviation,
        np.full(3, blend),
        6.0,
    )
    np.testing.assert_allclose(solved(task_rows, drive), expected, rtol=1e-9)


def test_a_late_foot_seeks_the_ground_until_it_touches():
    kinematics, q = Kinematics(), posture(hip=0.4, knee=0.8)
    kinematics.update(q)
    feet = Ticking(configuration_force_control(kinematics, q))
    reference, phase = np.zeros(TASK_REFERENCE.size), np.zeros(GAIT_PHASE.size)
    for foot, name in enumerate("lr"):
        reference[TASK_REFERENCE.slice(f"w_{name}")] = kinematics.w[FOOT_TASK * foot :][:FOOT_TASK]
    feet.fix("task_reference", reference)

    def step(ticks, support, pads):
        phase[GAIT_PHASE.slice("support")] = phase[GAIT_PHASE.slice("blend")] = support
        feet.fix("gait_phase", phase)
        feet.fix("contact", np.repeat(pads, 4))
        feet.step(ticks)
        return feet.output("task_modification_l")[2]

    step(1, [0.0, 1.0], [0.0, 1.0])
    assert step(200, [1.0, 1.0], [0.0, 1.0]) == pytest.approx(-0.25 * (0.17 - 0.025), abs=2e-3)
    reached = step(1, [1.0, 1.0], [1.0, 1.0])
    assert step(100, [1.0, 1.0], [0.0, 1.0]) == pytest.approx(reached, abs=2e-3)
    assert feet.output("task_modification_r")[2] == pytest.approx(0, abs=4e-3)


@pytest.mark.parametrize(("foot", "other"), ["lr", "rl"])
def test_com_dynamics_move_a_loaded_foot_as_they_say(foot, other):
    """As in eq. 21 of the paper's law: without an error their rate is all that the foot does."""
    kinematics, q = Kinematics(), posture(hip=0.4, knee=0.8)
    kinematics.update(q)
    feet = Ticking(configuration_force_control(kinematics, q))
    reference, rate = np.zeros(TASK_REFERENCE.size), np.array([0.2, -0.1, -0.05])
    for k, name in enumerate("lr"):
        reference[TASK_REFERENCE.slice(f"w_{name}")] = kinematics.w[FOOT_TASK * k :][:FOOT_TASK]
    feet.fix("task_reference", reference)
    feet.fix("gait_phase", 1.0, GAIT_PHASE.slice("blend"))
    feet.fix("measured_wrench", np.tile([0.0, 0.0, 300.0, 0.0, 0.0, 0.0], 2))
    felt = [feet.output(f"contact_wrench_{name}") for name in "lr"]
    feet.fix("desired_wrench", np.concatenate(felt), slice(0, 6))
    feet.fix(f"com_dynamics_rate_{foot}", rate)
    moved = {name: feet.output(f"task_command_{name}")[[9, 10, 8]] for name in "lr"}
    assert moved[foot] == pytest.approx(rate, rel=0.02, abs=1e-3)
    assert moved[other] == pytest.approx(np.zeros(3), abs=2e-3)


def configuration_force_control(kinematics, q):
    sensor = FootSensor(*foot_sensor_geometry(kinematics))
    params = HybridForceControlParams()
    return ConfigurationForceControl(
        params,
        InverseKinematicsParams(),
        kinematics,
        sensor,
        q,
        3e5,
        [ServoCompliance(1e-6 * np.eye(3), 0.014)] * 2,
    )


def test_only_the_commands_depend_on_everything_but_the_switches(kinematics):
    block = BlockSystem(configuration_force_control(kinematics, posture(hip=0.4, knee=0.8)))
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    passed_on = {
        output.get_name(): {
            port.get_name()
            for port in inputs
            if block.HasDirectFeedthrough(port.get_index(), output.get_index())
        }
        for output in outputs
    }
    for name, sources in passed_on.items():
        kind = name.removesuffix("_l").removesuffix("_r")
        expected = {
            "joint_command": {port.get_name() for port in inputs} - {"contact"},
            "task_command": {port.get_name() for port in inputs} - {"contact"},
            "contact_wrench": {"measured_wrench"},
            "task_modification": {"task_reference"},
        }[kind]
        assert sources == expected, name
