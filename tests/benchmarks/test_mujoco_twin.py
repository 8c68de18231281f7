"""The same robot in another engine: an independent check of masses, statics and dynamics."""

import importlib
import sys

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator

from lola_drake.benchmarks.bare_plant import Motion, bare_plant, record_motion
from lola_drake.benchmarks.bench_tables import mujoco_tables
from lola_drake.blocks.joint_servos import set_servo_gains
from lola_drake.errors import LolaError
from lola_drake.robot import add_lola, posture
from lola_drake.scenario import load_scenario
from lola_drake.signals import JOINTS, PERIOD

mujoco = pytest.importorskip("mujoco")

from lola_drake.benchmarks import bench_mujoco  # noqa: E402
from lola_drake.benchmarks.bench_mujoco import GROUPS, torque_comparison  # noqa: E402
from lola_drake.benchmarks.mujoco_twin import Twin, inverse_dynamics  # noqa: E402
from lola_drake.mujoco_model import mujoco_model, to_qpos, to_qvel  # noqa: E402

STAND = load_scenario("stand")
TICKS = 700


@pytest.fixture(scope="module")
def drake():
    """Return the robot alone in Drake, with the servos' gains."""
    plant = MultibodyPlant(0.001)
    add_lola(plant)
    plant.Finalize()
    set_servo_gains(plant, STAND.control.servos)
    return plant


@pytest.fixture(scope="module")
def model():
    return mujoco_model(STAND.control.servos, STAND.ground)


@pytest.fixture(scope="module")
def stance():
    """Return the robot's start in Drake and the commands that hold it there."""
    rest = bare_plant(STAND, np.zeros((1, 72)))
    plant = rest.GetSubsystemByName("plant")
    q = plant.GetPositions(plant.CreateDefaultContext())
    return q, np.tile(np.concatenate([q[7:], np.zeros(48)]), (TICKS + 1, 1))


@pytest.fixture(scope="module")
def shaken(stance):
    """Return how the robot in Drake moves on the ground while its targets swing to and fro."""
    q, commands = stance
    commands = commands.copy()
    commands[:, : len(JOINTS)] += 0.02 * np.sin(0.02 * np.arange(TICKS + 1))[:, None]
    commands[:, -len(JOINTS) :] = 1.0
    simulator = Simulator(bare_plant(STAND, commands))
    simulator.AdvanceTo(0.1)
    return record_motion(simulator, 60)


def some_state():
    """Return positions and velocities that are special in no way."""
    random = np.random.default_rng(1)
    quaternion = random.standard_normal(4)
    q = np.r_[quaternion / np.linalg.norm(quaternion), 0.3, -0.2, 1.1, posture(0.4, 0.7)]
    return q, random.standard_normal(30)


def test_joints_are_the_same_in_the_same_order(drake, model):
    assert [model.joint(i).name for i in range(1, model.njnt)] == list(JOINTS)
    assert [model.actuator(i).name for i in range(model.nu)] == list(JOINTS)
    limits = np.array([drake.GetPositionLowerLimits()[7:], drake.GetPositionUpperLimits()[7:]])
    np.testing.assert_allclose(model.jnt_range[1:].T, limits)
    np.testing.assert_allclose(model.jnt_actfrcrange[1:, 1], drake.GetEffortUpperLimits())
    assert model.jnt_actfrclimited[1:].all()


def test_servos_have_the_same_gains_and_rotors(drake, model):
    for i, joint in enumerate(JOINTS):
        actuator = drake.GetJointActuatorByName(joint)
        gains = actuator.get_controller_gains()
        np.testing.assert_allclose(model.actuator_biasprm[i, 1:3], [-gains.p, -gains.d])
        np.testing.assert_allclose(model.dof_armature[6 + i], actuator.default_reflected_inertia())


def test_masses_and_com_are_the_same(drake, model):
    context, data = drake.CreateDefaultContext(), mujoco.MjData(model)
    q, _ = some_state()
    drake.SetPositions(context, q)
    data.qpos = to_qpos(q)
    mujoco.mj_forward(model, data)
    for index in drake.GetBodyIndices(drake.GetModelInstanceByName("lola")):
        body = drake.get_body(index)
        twin = model.body(body.name())
        assert twin.mass[0] == pytest.approx(body.default_mass())
        place = body.EvalPoseInWorld(context).translation()
        np.testing.assert_allclose(data.body(body.name()).xpos, place, atol=1e-12)
    com = drake.CalcCenterOfMassPositionInWorld(context)
    np.testing.assert_allclose(data.subtree_com[0], com, atol=1e-12)


def test_momentum_is_the_same(drake, model):
    """Catches a wrong order of quaternions, a wrong frame of rates, and wrong inertias."""
    context, data = drake.CreateDefaultContext(), mujoco.MjData(model)
    q, v = some_state()
    drake.SetPositions(context, q)
    drake.SetVelocities(context, v)
    data.qpos, data.qvel = to_qpos(q), to_qvel(q, v)
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    com = drake.CalcCenterOfMassPositionInWorld(context)
    momentum = drake.CalcSpatialMomentumInWorldAboutPoint(context, com)
    np.testing.assert_allclose(data.subtree_angmom[0], momentum.rotational(), atol=1e-9)
    total = data.subtree_linvel[0] * model.body_mass.sum()
    np.testing.assert_allclose(total, momentum.translational(), atol=1e-9)


def test_inverse_dynamics_in_the_air_are_the_same(drake, model):
    """Gravity, inertia with rotors, velocity-dependent forces and damping, to the last digits."""
    context, forces = drake.CreateDefaultContext(), MultibodyForces(drake)
    q, v = some_state()
    v_dot = np.random.default_rng(2).standard_normal(30)
    drake.SetPositions(context, q)
    drake.SetVelocities(context, v)
    drake.CalcForceElementsContribution(context, forces)
    expected = to_qvel(q, drake.CalcInverseDynamics(context, v_dot, forces))
    damping = [drake.GetJointByName(joint).default_damping() for joint in JOINTS]
    expected[6:] += damping * v_dot[6:] * PERIOD  # it counts at the end of the step
    motion = Motion(q[None], v[None], v_dot[None], np.zeros((1, 24)), np.zeros((1, 4, 6)))
    np.testing.assert_allclose(inverse_dynamics(model, motion)[0], expected, atol=1e-9)


def test_torques_of_a_motion_on_the_ground_are_the_same(model, shaken):
    """With the recorded loads on the soles, as far as Drake's step keeps its own equations."""
    assert np.abs(shaken.v_dot).max() > 1.0
    content = torque_comparison(model, shaken)
    assert set(content["joint_torque"]) == set(GROUPS)
    assert all(group["relative"] < 1e-3 for group in content["joint_torque"].values())
    assert content["unexplained"]["force_N"] < 0.1
    assert content["unexplained"]["torque_Nm"] < 0.1


def test_every_joint_is_in_one_group():
    beginnings = tuple(b for group in GROUPS.values() for b in group)
    assert all(sum(joint.startswith(b) for b in beginnings) == 1 for joint in JOINTS)


def test_servo_gives_the_torque_of_its_law(model, stance):
    q, commands = stance
    command = commands[0] + np.random.default_rng(3).uniform(-1e-3, 1e-3, 72)
    twin = Twin(model, q, command[None])
    twin.AdvanceTo(PERIOD)
    stiffness, damping = -model.actuator_biasprm[:, 1:3].T
    expected = stiffness * (command[:24] - q[7:]) + damping * command[24:48] + command[48:]
    np.testing.assert_allclose(twin.joint_torques(), expected, atol=1e-9)


@pytest.fixture(scope="module")
def content():
    """Return a comparison of robots that only stand, and not for long."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench_mujoco, "SETTLE", 1.0)
        patch.setattr(bench_mujoco, "AVERAGE", 0.5)
        patch.setattr(bench_mujoco, "steady_walk", lambda repeats: (STAND, 0.05, 0.1))
        return bench_mujoco.bench_mujoco(repeats=1)


def test_robots_stand_alike(content):
    statics = content["statics"]
    drake, same, own = (
        statics[name] for name in ("drake", "mujoco_same_ground", "mujoco_own_contact")
    )
    assert same["mass_kg"] == own["mass_kg"] == pytest.approx(drake["mass_kg"])
    assert same["com_height_m"] == pytest.approx(drake["com_height_m"], abs=5e-5)
    # Drake's ground gives way by one millimetre, MuJoCo's own hardly at all.
    assert own["com_height_m"] == pytest.approx(drake["com_height_m"] + 1e-3, abs=2e-4)
    for stand in (drake, same, own):
        for force in stand["vertical_force_N"].values():
            assert force == pytest.approx(drake["mass_kg"] * 9.81 / 2, rel=0.01)
    torque = statics["joint_torque_Nm"]
    for difference in torque["difference_rms"].values():
        assert difference < 0.05 * torque["rms"]


def test_comparison_has_the_promised_names(content):
    engines = {"drake", "mujoco_same_ground", "mujoco_own_contact"}
    assert set(content["step_us"]["standing"]) == set(content["step_us"]["walking"]) == engines
    assert content["strides_upright"] == dict.fromkeys(engines, 1)
    assert set(content["drake_over_mujoco"]["walking"]) == engines - {"drake"}


def test_a_fall_in_mujoco_is_told(model, stance):
    """What it took while it lay on the ground is no time of a step."""
    q, commands = stance
    lying = q.copy()
    lying[:4], lying[6] = [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0], 0.3
    engines = {
        "drake": Twin(model, q, commands),
        "mujoco_same_ground": Twin(model, lying, commands),
    }
    taken = bench_mujoco._step_times(engines, 0.0, 0.1, 2)
    assert {name: len(times) for name, times in taken.items()} == {
        "drake": 2,
        "mujoco_same_ground": 0,
    }
    assert bench_mujoco._spreads(taken)["mujoco_same_ground"] is None


def test_tables_show_every_engine_and_joint_group(content):
    times, standing, torques = mujoco_tables(content)
    rows = list(times.columns[0].cells)
    assert "standing, mujoco same ground (us)" in rows
    assert "walking, mujoco own contact (us)" in rows
    assert [column.header for column in standing.columns][1] == "drake"
    assert list(torques.columns[0].cells) == list(GROUPS)


def test_a_missing_package_is_said_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    monkeypatch.delitem(sys.modules, "lola_drake.mujoco_model")
    with pytest.raises(LolaError, match=r"pip install 'lola_drake\[bench\]'"):
        importlib.import_module("lola_drake.mujoco_model")
