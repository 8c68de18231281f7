"""The whole controller: its symmetry, its ports, its delay, and its gains as parameters."""

import numpy as np
import pytest
from mirror import MIRRORED_JOINTS

from lola_drake.block_system import gain_of, set_gain
from lola_drake.blocks.foot_force_control import FORCE_CONTROLLED
from lola_drake.blocks.force_laws import FORCE_LAWS, law_class
from lola_drake.blocks.hybrid_force_control import HybridForceControl, HybridForceControlParams
from lola_drake.blocks.joint_servos import JointServosParams, servo_gains
from lola_drake.blocks.sensed_force_control import SensedForceControl
from lola_drake.controller import (
    WalkingController,
    controller_blocks,
    initial_stance,
    pads_matrix,
    servo_compliances,
)
from lola_drake.robot import Kinematics
from lola_drake.scenario import VARIANTS, Control, Scenario
from lola_drake.signals import JOINTS, PERIOD
from lola_drake.theory.contact_model import command_gradient
from lola_drake.theory.kinematics import FOOT_TASK

SENSORS = ("torso_orientation", "measured_wrench", "contact")
TICKS = 50

KEEP_THEIR_SIGN = {"tha", "tsa", "taa", "tvt"}
"""Adduction (the left axes are -x where the right ones are +x) and the head's tilt."""
SIGNS = np.array([1.0 if name[:3] in KEEP_THEIR_SIGN else -1.0 for name in JOINTS])
ORIENTATION_SIGNS = np.array([-1.0, 1.0, -1.0, 1.0])
WRENCH_SIGNS = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


class Loop:
    """A standing controller that is stepped tick by tick with given sensor signals."""

    def __init__(self, variant="dyn", delay_ticks=1, law="hybrid", sensed=False):
        force = HybridForceControlParams(sensed_area=sensed, exact_angles=sensed)
        servos = JointServosParams(delay_ticks=delay_ticks)
        control = Control(law=law, force=force, servos=servos)
        scenario = Scenario(variant=variant, control=control)
        kinematics = Kinematics()
        self.stance = initial_stance(scenario, kinematics)
        blocks = controller_blocks(scenario, kinematics, self.stance)
        self.controller = WalkingController(blocks)
        self.context = self.controller.CreateDefaultContext()
        self.controller.GetInputPort("walk_command").FixValue(self.context, np.zeros(3))

    def feed(self, sensed):
        for name in SENSORS:
            self.controller.GetInputPort(name).FixValue(self.context, sensed[name])

    def step(self, sensed):
        self.feed(sensed)
        updates = self.controller.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(updates)
        self.context.SetTime(self.context.get_time() + PERIOD)

    def output(self, name):
        return self.controller.GetOutputPort(name).Eval(self.context).copy()

    def halve(self, block, gain):
        system = self.controller.GetSubsystemByName(block)
        set_gain(system, self.context, gain, 0.5 * gain_of(system, self.context, gain))


def quiet():
    return {
        "torso_orientation": np.zeros(4),
        "measured_wrench": np.tile([0.0, 0.0, 280.0, 0.0, 0.0, 0.0], 2),
        "contact": np.ones(8),
    }


def restless():
    """Return sensor signals without any symmetry for some ticks, the same every time."""
    random = np.random.default_rng(3)
    ticks = []
    for k in range(TICKS):
        wrench = random.uniform(-1.0, 1.0, 12) * np.tile([30.0, 30.0, 200.0, 8.0, 8.0, 8.0], 2)
        wrench[[2, 8]] += 200.0
        contact = random.integers(0, 2, 8).astype(float)
        contact[:4] *= k % 3 != 0
        contact[4:] *= k % 3 != 1
        orientation = random.uniform(-1.0, 1.0, 4) * [0.05, 0.05, 0.4, 0.4]
        ticks.append(
            {"torso_orientation": orientation, "measured_wrench": wrench, "contact": contact}
        )
    return ticks


def mirrored(sensed):
    left, right = np.split(sensed["measured_wrench"], 2)
    pads = sensed["contact"].reshape(2, 2, 2)
    return {
        "torso_orientation": ORIENTATION_SIGNS * sensed["torso_orientation"],
        "measured_wrench": np.r_[WRENCH_SIGNS * right, WRENCH_SIGNS * left],
        "contact": pads[::-1, :, ::-1].ravel(),
    }


def mirrored_joints(values):
    return (SIGNS * values.reshape(-1, len(JOINTS))[:, MIRRORED_JOINTS]).ravel()


def ticks_until_joints_move(sensor, value, delay_ticks):
    """Return after how many ticks one disturbed sample reaches the joints."""
    disturbed, free = Loop(delay_ticks=delay_ticks), Loop(delay_ticks=delay_ticks)
    impulse = quiet() | {sensor: value}
    for k in range(10):
        outputs = [loop.output("joint_desired_state") for loop in (disturbed, free)]
        if not np.array_equal(*outputs):
            return k
        disturbed.step(impulse if k == 0 else quiet())
        free.step(quiet())
    return None


@pytest.mark.parametrize(
    ("variant", "law"), [*(("dyn", law) for law in FORCE_LAWS), ("ref", "hybrid")]
)
def test_mirrored_sensors_give_mirrored_joints(variant, law):
    one, other = Loop(variant, law=law), Loop(variant, law=law)
    for sensed in restless():
        one.step(sensed)
        other.step(mirrored(sensed))
        for name in ("joint_desired_state", "joint_feedforward"):
            expected = mirrored_joints(one.output(name))
            np.testing.assert_allclose(other.output(name), expected, rtol=0, atol=1e-7)


def test_the_sensed_contact_and_exact_angles_are_their_own_mirror_image():
    one, other = Loop(sensed=True), Loop(sensed=True)
    for sensed in restless():
        one.step(sensed)
        other.step(mirrored(sensed))
        expected = mirrored_joints(one.output("joint_desired_state"))
        found = other.output("joint_desired_state")
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)


@pytest.mark.parametrize("area", [False, True])
@pytest.mark.parametrize("angles", [False, True])
def test_only_where_it_is_asked_for_the_contact_is_sensed(area, angles):
    params = HybridForceControlParams(sensed_area=area, exact_angles=angles)
    expected = SensedForceControl if area or angles else HybridForceControl
    assert law_class("hybrid", params) is expected


def test_sensors_without_symmetry_move_the_joints_without_symmetry():
    loop = Loop()
    for sensed in restless():
        loop.step(sensed)
    moved = loop.output("joint_desired_state")
    assert np.abs(moved - mirrored_joints(moved)).max() > 1e-2


def test_standing_posture_is_its_own_mirror_image():
    q = Loop().stance.q
    np.testing.assert_allclose(mirrored_joints(q), q, atol=1e-9)


@pytest.mark.parametrize("variant", ["dyn", "original"])
def test_inputs_come_from_the_user_and_the_sensors(variant):
    controller = Loop(variant).controller
    inputs = [controller.get_input_port(i).get_name() for i in range(controller.num_input_ports())]
    assert sorted(inputs) == sorted(["walk_command", *SENSORS])


@pytest.mark.parametrize("variant", ["dyn", "original"])
def test_every_output_of_every_block_is_exported(variant):
    controller = Loop(variant).controller
    expected = [
        block.get_output_port(i).get_name() + (suffix if suffix in ("_l", "_r") else "")
        for block in controller.GetSystems()
        for suffix in [block.get_name()[-2:]]
        for i in range(block.num_output_ports())
    ]
    names = [controller.get_output_port(i).get_name() for i in range(controller.num_output_ports())]
    assert sorted(names) == sorted(expected)


@pytest.mark.parametrize("variant", ["dyn", "original"])
def test_every_output_has_a_finite_value(variant):
    loop = Loop(variant)
    loop.feed(quiet())
    for i in range(loop.controller.num_output_ports()):
        port = loop.controller.get_output_port(i)
        assert np.isfinite(port.Eval(loop.context)).all(), port.get_name()


@pytest.mark.parametrize("delay_ticks", [1, 4])
@pytest.mark.parametrize(
    ("sensor", "value"),
    [
        ("torso_orientation", [0.01, 0.0, 0.0, 0.0]),
        ("torso_orientation", [0.0, 0.0, 0.0, 0.1]),
        ("measured_wrench", np.tile([0.0, 0.0, 300.0, 0.0, 0.0, 0.0], 2)),
    ],
)
def test_a_sample_reaches_the_joints_after_the_delay_of_the_bus_alone(sensor, value, delay_ticks):
    assert ticks_until_joints_move(sensor, np.array(value), delay_ticks) == delay_ticks


@pytest.mark.parametrize("delay_ticks", [1, 4])
def test_a_contact_switch_goes_through_the_integrator_one_tick_later(delay_ticks):
    one_foot = np.repeat([1.0, 0.0], 4)
    assert ticks_until_joints_move("contact", one_foot, delay_ticks) == delay_ticks + 1


def test_without_com_dynamics_a_contact_switch_does_nothing():
    loops = [Loop("ref"), Loop("ref")]
    for _ in range(10):
        loops[0].step(quiet() | {"contact": np.repeat([1.0, 0.0], 4)})
        loops[1].step(quiet())
    assert np.array_equal(*(loop.output("joint_desired_state") for loop in loops))


@pytest.mark.parametrize(
    ("block", "kind", "gains"),
    [
        ("imu_stabilizer", "dyn", 4),
        ("force_control_l", "dyn", 2),
        ("force_control_r", "dyn", 2),
        ("com_dynamics_l", "dyn", 2),
        ("com_dynamics_r", "dyn", 2),
        ("configuration_force_control", "original", 2),
        ("force_control_l", "damping", 3),
        ("force_control_r", "second_order", 3),
        ("force_control_l", "two_dof", 3),
    ],
)
def test_every_gain_is_a_parameter_that_changes_the_motion(block, kind, gains):
    """Of the paper's law in a variant, or of a rival."""
    system = Loop(**kind_of(kind)).controller.GetSubsystemByName(block)
    context = system.CreateDefaultContext()
    assert context.num_numeric_parameter_groups() == len(system.gain_index) == gains
    assert all(context.get_numeric_parameter(i).size() == 1 for i in range(gains))
    before = _motion(kind)
    for gain in system.gain_index:
        assert not np.array_equal(_motion(kind, block, gain), before), gain


def kind_of(name):
    """Return a variant, or a law, as what `Loop` is told."""
    return {"variant": name} if name in VARIANTS else {"law": name}


def _motion(kind, block=None, gain=None):
    """Return where the joints end when one gain is halved."""
    loop = Loop(**kind_of(kind))
    if block is not None:
        loop.halve(block, gain)
    for sensed in restless():
        loop.step(sensed)
    return loop.output("joint_desired_state")


@pytest.fixture(scope="module")
def stance():
    kinematics = Kinematics()
    return kinematics, initial_stance(Scenario(), kinematics)


@pytest.mark.parametrize("foot", [0, 1])
def test_a_foot_gives_way_to_its_wrench_as_its_servos_do(stance, foot):
    """The joints turn by the wrench's torques over the servos' stiffness."""
    kinematics, (q, servos) = stance[0], (stance[1].q, JointServosParams())
    stiffness, damping = servo_gains(kinematics.plant, servos)
    controlled = FOOT_TASK * foot + FORCE_CONTROLLED
    compliance = servo_compliances(kinematics, q, servos)[foot]
    assert damping / stiffness == pytest.approx(np.full(len(JOINTS), compliance.relaxation))
    for wrench in 0.01 * np.diag([10.0, 10.0, 100.0]):
        kinematics.update(q)
        before, torque = kinematics.w[controlled].copy(), kinematics.jacobian[controlled].T @ wrench
        kinematics.update(q + torque / stiffness)
        moved = kinematics.w[controlled] - before
        np.testing.assert_allclose(
            compliance.matrix @ wrench, moved, atol=1e-3 * np.abs(moved).max()
        )
        assert moved @ wrench > 0


def test_feet_give_way_in_the_mirror(stance):
    left, right = servo_compliances(stance[0], stance[1].q, JointServosParams())
    mirror = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(right.matrix, left.matrix * np.outer(mirror, mirror), atol=1e-9)


def test_the_gradient_is_softer_than_the_pads(stance):
    pads = pads_matrix(Scenario())
    compliance, _ = servo_compliances(stance[0], stance[1].q, JointServosParams())
    in_the_end = np.diag(command_gradient(pads, compliance.matrix)) / np.diag(pads)
    assert in_the_end == pytest.approx([0.74, 0.72, 0.77], abs=0.01)
    within = np.diag(command_gradient(pads, compliance.within(0.02))) / np.diag(pads)
    assert within == pytest.approx([0.83, 0.81, 0.85], abs=0.01)
