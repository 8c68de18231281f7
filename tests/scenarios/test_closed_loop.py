"""What holds for the loop as a whole: its symmetry while it walks, and its delay in ticks."""

import numpy as np
import pytest
from mirror import MIRRORED_JOINTS, mirror_signs
from pydrake.systems.analysis import Simulator

from lola_drake.controller import WalkingController, controller_blocks, initial_stance
from lola_drake.robot import Kinematics
from lola_drake.scenario import load_scenario
from lola_drake.signals import JOINTS, PERIOD
from lola_drake.world import build_simulation

MIRRORED_FOOT = np.array([1, -1, 1, -1, 1, -1])
"""F and T seen in a mirror beside the robot: a force to the left becomes one to the right."""
MIRRORED_PADS = [5, 4, 7, 6, 1, 0, 3, 2]


@pytest.fixture(scope="module")
def mirror_joints():
    """Return the matrix that takes joint angles to those of the robot in the mirror."""
    signs = mirror_signs(Kinematics().plant)
    return (np.eye(len(JOINTS)) * signs)[MIRRORED_JOINTS]


def sensor_signals(time):
    """Return made-up sensor signals without any symmetry, as they could occur in walking."""
    slow, medium, fast = (
        np.sin(2 * np.pi * rate * time + np.arange(12.0)) for rate in (0.7, 1.3, 2.1)
    )
    wrench = np.tile([0.0, 0.0, 294.0, 0.0, 0.0, 0.0], 2)
    return {
        "walk_command": np.zeros(3),
        "torso_orientation": [0.01, 0.01, 0.05, 0.05] * fast[:4],
        "measured_wrench": wrench + np.tile([20.0, 20.0, 100.0, 5.0, 5.0, 1.0], 2) * slow,
        "contact": (medium[:8] > -0.5).astype(float),
    }


def mirrored(signals):
    """Return the signals of the robot in the mirror."""
    left, right = signals["measured_wrench"].reshape(2, 6) * MIRRORED_FOOT
    return {
        "walk_command": signals["walk_command"] * [1, -1, -1],
        "torso_orientation": signals["torso_orientation"] * [-1, 1, -1, 1],
        "measured_wrench": np.concatenate([right, left]),
        "contact": signals["contact"][MIRRORED_PADS],
    }


class Running:
    """A controller of its own, fed with sensor signals tick by tick."""

    def __init__(self, scenario, steps):
        kinematics = Kinematics()
        stance = initial_stance(scenario, kinematics)
        blocks = controller_blocks(scenario, kinematics, stance, steps)
        self.controller = WalkingController(blocks)
        self.context = self.controller.CreateDefaultContext()

    def step(self, signals):
        """Return the joint command of this tick: q, q' and torque, one row each."""
        for name, value in signals.items():
            self.controller.GetInputPort(name).FixValue(self.context, value)
        command = self.controller.GetOutputPort("joint_command").Eval(self.context)
        update = self.controller.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(update)
        self.context.SetTime(self.context.get_time() + PERIOD)
        return command.reshape(3, len(JOINTS)).copy()


@pytest.mark.parametrize("variant", ["dyn", "original"])
def test_mirrored_walk_is_the_mirror_image(mirror_joints, variant):
    """One robot starts with its left and turns to the left, the other with its right to the right.

    The first step goes so far to the side that this foot has to set out.
    Without the retreat from the joint limits, which are those of the real robot, not symmetric.
    """
    overrides = {
        "variant": variant,
        "walk.start_time": 0.0,
        "pattern.first_double_support": 0.3,
        "control.inverse_kinematics.limit_gain": 0.0,
    }
    scenario = load_scenario("stand", overrides)
    steps = np.array([[0.15, 0.05, 0.1, 0.02], [0.25, -0.02, 0.05, -0.01]])
    robot, image = Running(scenario, steps), Running(scenario, steps * [1, -1, -1, 1])
    for k in range(900):
        signals = sensor_signals(PERIOD * k)
        command, reflection = robot.step(signals), image.step(mirrored(signals))
        np.testing.assert_allclose(reflection, command @ mirror_joints.T, rtol=1e-7, atol=2e-7)


def records(push_at, ticks):
    """Return outputs of the closed loop tick by tick; the torso gets a push before one of them."""
    diagram = build_simulation(load_scenario("stand", {"sensors.imu.delay_ticks": 3}))
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant = diagram.GetSubsystemByName("plant")
    ports = {
        port.get_name(): (port, system.GetMyContextFromRoot(context))
        for system in diagram.GetSystems()
        if system.get_name() in ("controller", "imu", "foot_force_sensor")
        for port in (system.get_output_port(i) for i in range(system.num_output_ports()))
    }
    rows = {name: [] for name in ports}
    for k in range(ticks):
        if k == push_at:
            plant_context = plant.GetMyMutableContextFromRoot(context)
            velocities = plant.GetVelocities(plant_context)
            velocities[:3] += 0.05
            plant.SetVelocities(plant_context, velocities)
        for name, (port, own) in ports.items():
            rows[name].append(port.Eval(own).copy())
        simulator.AdvanceTo(PERIOD * (k + 1))
    return {name: np.array(row) for name, row in rows.items()}


def test_delay_of_the_loop_in_ticks():
    """A push in tick n is felt by the feet in n + 1 and by the IMU in n + 3, its bus delay.

    Within that tick it runs through distribution, force control and inverse kinematics to the
    joint command; one more tick, the bus, and it is at the servos.
    """
    push, ticks = 20, 30
    calm, pushed = records(None, ticks), records(push, ticks)
    expected = {
        "measured_wrench": 1,
        "contact_wrench_l": 1,
        "task_command_l": 1,
        "joint_command": 1,
        "joint_desired_state": 2,
        "torso_orientation": 3,
    }
    for name, delay in expected.items():
        differs = np.any(calm[name] != pushed[name], axis=1)
        assert np.flatnonzero(differs)[0] == push + delay, name
