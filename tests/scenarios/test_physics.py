"""The simulated physics: contact against U x, sensors against Newton, the same run twice."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest
from momentum import load, upper_momentum
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from lola_drake.plant import add_plant
from lola_drake.robot import PADS
from lola_drake.scenario import Ground, load_scenario
from lola_drake.simulation import simulate
from lola_drake.theory.contact_model import contact_matrix
from lola_drake.world import build_simulation


class PressedFoot:
    """LOLA with every joint locked, its left foot held at a height and at angles of our choice."""

    def __init__(self, ground: Ground):
        builder = DiagramBuilder()
        self.plant, _ = add_plant(builder, ground)
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.plant_context = self.plant.GetMyMutableContextFromRoot(self.context)
        instance = self.plant.GetModelInstanceByName("lola")
        for port in (
            self.plant.get_actuation_input_port(),
            self.plant.get_desired_state_input_port(instance),
        ):
            port.FixValue(self.plant_context, np.zeros(port.size()))
        q = np.zeros(self.plant.num_positions())
        q[0] = 1.0
        # The right leg is bent out of the way.
        q[7 + 4], q[7 + 5] = -1.0, 1.5
        self.plant.SetPositions(self.plant_context, q)
        for index in self.plant.GetJointIndices():
            joint = self.plant.get_joint(index)
            if joint.num_velocities() and joint.name() != "tvt":
                joint.Lock(self.plant_context)

    def wrench(self, roll: float, pitch: float, height: float) -> np.ndarray:
        """Return T_x, T_y, F_z at the TCP in W."""
        tcp = self.plant.GetFrameByName("tcp_l")
        torso = self.plant.GetBodyByName("torso")
        X_TcpTorso = tcp.CalcPose(self.plant_context, torso.body_frame()).inverse()
        rotation = RotationMatrix(RollPitchYaw(roll, pitch, 0.0))
        X_WTcp = RigidTransform(rotation, [0.3, 0.2, height])
        self.plant.SetFloatingBaseBodyPoseInWorldFrame(
            self.plant_context, torso, X_WTcp @ X_TcpTorso
        )
        results = self.plant.get_contact_results_output_port().Eval(self.plant_context)
        total = np.zeros(3)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            force, arm = info.F_Ac_W(), info.contact_surface().centroid()
            sign = 1.0 if force.translational()[2] > 0 else -1.0
            f = sign * force.translational()
            moment = sign * force.rotational() + np.cross(arm - X_WTcp.translation(), f)
            total += [moment[0], moment[1], f[2]]
        return total


@pytest.fixture(scope="module")
def pressed_foot():
    return PressedFoot(Ground())


@pytest.mark.parametrize("height", [-0.0008, -0.0015, -0.0025])
@pytest.mark.parametrize(
    ("roll", "pitch"),
    [(0, 0), (0.004, 0), (-0.004, 0), (0, 0.004), (0, -0.004), (0.003, 0.003), (-0.002, 0.004)],
)
def test_pressed_foot_agrees_with_the_contact_model(pressed_foot, roll, pitch, height):
    deepest = -height
    if 0.11 * abs(roll) + 0.135 * abs(pitch) > deepest:
        pytest.skip("a pad would lift off, where the model does not hold")
    area = sum(pad.area for pad in PADS)
    stiffness = contact_matrix(PADS, Ground().stiffness / area)
    expected = stiffness @ [np.sin(roll), np.sin(pitch), height]
    actual = pressed_foot.wrench(roll, pitch, height)
    # 2 %, and where nothing is expected no more than the force sensor's noise.
    allowed = np.maximum(0.02 * np.abs(expected), [0.1, 0.1, 2.0])
    assert (np.abs(actual - expected) < allowed).all(), (actual, expected)


def test_a_contact_gives_back_no_more_than_it_takes(pressed_foot):
    """LOLA falls on one stiff leg and slides: its energy never exceeds what it had before."""
    simulator = Simulator(pressed_foot.diagram, pressed_foot.context.Clone())
    plant = pressed_foot.plant
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    (free_joint,) = (
        plant.get_joint(index)
        for index in plant.GetJointIndices()
        if plant.get_joint(index).num_velocities() == 6
    )
    free_joint.Unlock(context)
    torso, foot = plant.GetBodyByName("torso"), plant.GetFrameByName("tcp_l")
    X_FootTorso = foot.CalcPose(context, torso.body_frame()).inverse()
    start = RigidTransform([0.0, 0.0, 0.02]) @ X_FootTorso
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, torso, start)
    velocity = np.zeros(plant.num_velocities())
    velocity[3] = 0.3
    plant.SetVelocities(context, velocity)
    energy, touching = [], []
    results = plant.get_contact_results_output_port()
    for k in range(350):
        energy.append(plant.CalcKineticEnergy(context) + plant.CalcPotentialEnergy(context))
        touching.append(results.Eval(context).num_hydroelastic_contacts() > 0)
        simulator.AdvanceTo((k + 1) * 1e-3)
    energy, free = np.array(energy), ~np.array(touching)
    assert 0.2 < np.mean(touching) < 0.9
    assert np.diff(energy)[free[1:] & free[:-1]] == pytest.approx(0.0, abs=0.01)
    assert energy.max() < energy[0] + 1e-6 * abs(energy[0])
    assert energy[-1] < energy[0] - 5.0


def test_forces_and_moments_are_newtons_while_walking():
    """What the force sensors read is the rate of momentum of everything above them."""
    scenario = load_scenario("walk_flat", ["sensors.ideal=true", "duration=3"])
    diagram = build_simulation(scenario)
    plant = diagram.GetSubsystemByName("plant")
    sensor = diagram.GetSubsystemByName("foot_force_sensor")
    simulator = Simulator(diagram)
    context = simulator.get_context()
    plant_context = plant.GetMyContextFromRoot(context)
    simulator.AdvanceTo(1.8)
    worst, before, gravity_before, frames_before = np.zeros(6), None, None, None
    for k in range(1000):
        # Between two ticks, so that rounding never decides which of them is over.
        simulator.AdvanceTo((1800.5 + k) * 1e-3)
        momentum, gravity = upper_momentum(plant, plant_context)
        if before is not None:
            reading = sensor.GetOutputPort("measured_wrench").Eval(
                sensor.GetMyContextFromRoot(context)
            )
            carried = sum(load(frames_before[f], reading, f) for f in "lr")
            residual = (momentum - before) / 1e-3 - gravity_before - carried
            worst = np.maximum(worst, np.abs(residual))
        before, gravity_before = momentum, gravity
        frames_before = {
            f: plant.GetFrameByName(f"foot_{f}").CalcPoseInWorld(plant_context) for f in "lr"
        }
    # The sensors' noise in the scenarios is 2 N and 0.1 Nm; about the origin, arms are ~1 m.
    assert worst[3:].max() < 2.0
    assert worst[:3].max() < 2.0


_DIGEST = """
import hashlib
from lola_drake import load_scenario, simulate
result = simulate(load_scenario("walk_flat", ["duration=2.5", "seed=7"]))
data = b"".join(result.signals[name].tobytes() for name in sorted(result.signals))
print(hashlib.sha256(data).hexdigest())
"""


def test_same_seed_gives_the_same_bits_in_one_and_in_two_processes():
    scenario = load_scenario("walk_flat", ["duration=2.5", "seed=7"])
    digests = set()
    for _ in range(2):
        signals = simulate(scenario).signals
        data = b"".join(signals[name].tobytes() for name in sorted(signals))
        digests.add(hashlib.sha256(data).hexdigest())
    other = subprocess.run(
        [sys.executable, "-c", _DIGEST], capture_output=True, text=True, check=True
    )
    digests.add(other.stdout.split()[-1])
    assert len(digests) == 1


def test_another_seed_gives_other_noise():
    first, second = (
        simulate(load_scenario("stand", ["duration=0.2", f"seed={seed}"])) for seed in (1, 2)
    )
    assert np.abs(first.signals["measured_wrench"] - second.signals["measured_wrench"]).max() > 1.0
