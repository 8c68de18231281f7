"""The whole controller: its ports, its symmetry, and the delay of the closed loop in ticks."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from lola_drake.controller import PERIOD, WalkingController, initial_stance
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario, load_scenario
from lola_drake.signals import JOINTS
from lola_drake.simulation import build_simulation
from lola_drake.theory.constants import GRAVITY

N = len(JOINTS)
SWING = 2
"""Where the state of the walking pattern holds the foot that swings next."""

MIRRORED_FOOT = np.array([1, -1, 1, -1, 1, -1])
"""F and T seen in a mirror beside the robot: a force to the left becomes one to the right."""
MIRRORED_PADS = [5, 4, 7, 6, 1, 0, 3, 2]


def sensor_signals(time):
    """Return made-up sensor signals without any symmetry, as they could occur in walking."""
    phase = np.outer(2 * np.pi * np.array([0.7, 1.3, 2.1]), [time]).ravel()
    waves = np.sin(np.add.outer(phase, np.arange(12.0)))
    wrench = np.tile([0.0, 0.0, 294.0, 0.0, 0.0, 0.0], 2)
    wrench += np.tile([20.0, 20.0, 100.0, 5.0, 5.0, 1.0], 2) * waves[0]
    contact = (waves[1, :8] > -0.5).astype(float)
    return {
        "walk_command": np.zeros(3),
        "torso_orientation": [0.01, 0.01, 0.05, 0.05] * waves[2, :4],
        "measured_wrench": wrench,
        "contact": contact,
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

    def __init__(self, scenario, steps=None, swing=0):
        self.controller = WalkingController(scenario, steps)
        self.context = self.controller.CreateDefaultContext()
        pattern = self.controller.GetSubsystemByName("walking_pattern")
        state = pattern.GetMyMutableContextFromRoot(self.context).get_mutable_discrete_state()
        state.get_mutable_value()[SWING] = swing

    def step(self, signals):
        """Return the joint command and the servos' desired states in this tick."""
        for name, value in signals.items():
            self.controller.GetInputPort(name).FixValue(self.context, value)
        outputs = [
            self.controller.GetOutputPort(name).Eval(self.context).copy()
            for name in ("joint_command", "joint_desired_state", "joint_feedforward")
        ]
        update = self.controller.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(update)
        self.context.SetTime(self.context.get_time() + PERIOD)
        return outputs


def test_stance_carries_the_plan():
    scenario = Scenario()
    kinematics = Kinematics()
    stance = initial_stance(scenario, kinematics)
    kinematics.update(stance.q)
    assert kinematics.w[2] == pytest.approx(kinematics.w[8])
    sink = 0.5 * kinematics.mass * GRAVITY / scenario.pattern.ground_stiffness
    assert -kinematics.w[2] == pytest.approx(scenario.pattern.com_height + sink)


def test_every_signal_between_the_blocks_is_an_output():
    controller = WalkingController(Scenario())
    inputs = {controller.get_input_port(i).get_name() for i in range(controller.num_input_ports())}
    outputs = {
        controller.get_output_port(i).get_name() for i in range(controller.num_output_ports())
    }
    per_foot = ("task_command", "contact_wrench", "task_modification", "com_dynamics_rate")
    assert inputs == {"walk_command", "torso_orientation", "measured_wrench", "contact"}
    assert outputs == {f"{name}_{foot}" for name in per_foot for foot in "lr"} | {
        "task_reference",
        "gait_phase",
        "ideal_wrench",
        "planned_motion",
        "modified_wrench",
        "desired_wrench",
        "joint_command",
        "joint_desired_state",
        "joint_feedforward",
    }


@pytest.mark.parametrize("variant", ["dyn", "ref", "original"])
@pytest.mark.parametrize("walking", [False, True], ids=["standing", "walking"])
def test_mirrored_input_gives_mirrored_output(mirror_joints, variant, walking):
    """Also in walking, where one robot starts with its left and the other with its right foot.

    Without the retreat from the joint limits, which are those of the real robot and not symmetric.
    """
    overrides = {
        "variant": variant,
        "walk.start_time": 0.0,
        "pattern.first_double_support": 0.3,
        "control.inverse_kinematics.limit_gain": 0.0,
    }
    scenario = load_scenario("stand", overrides)
    steps = np.array([[0.3, 0.03, 0.1], [0.25, -0.02, 0.05]]) if walking else None
    robot = Running(scenario, steps, swing=0)
    image = Running(scenario, None if steps is None else steps * [1, -1, -1], swing=1)
    for k in range(700 if walking else 100):
        signals = sensor_signals(PERIOD * k)
        outputs, reflections = robot.step(signals), image.step(mirrored(signals))
        for output, reflection in zip(outputs, reflections, strict=True):
            expected = np.reshape(output, (-1, N)) @ mirror_joints.T
            np.testing.assert_allclose(np.reshape(reflection, (-1, N)), expected, atol=2e-7)


def first_difference(signal, other):
    """Return the first tick in which two records of a signal differ."""
    return int(np.flatnonzero(np.any(signal != other, axis=1))[0])


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

    Within that tick it runs through stabiliser, distribution, force control and inverse
    kinematics to the joint command; one more tick, the bus, and it is at the servos.
    """
    push, ticks = 20, 30
    calm, pushed = records(None, ticks), records(push, ticks)
    reached = {
        name: first_difference(calm[name], pushed[name]) - push
        for name in (
            "measured_wrench",
            "contact_wrench_l",
            "task_command_l",
            "joint_command",
            "joint_desired_state",
            "torso_orientation",
            "modified_wrench",
        )
    }
    assert reached == {
        "measured_wrench": 1,
        "contact_wrench_l": 1,
        "task_command_l": 1,
        "joint_command": 1,
        "joint_desired_state": 2,
        "torso_orientation": 3,
        "modified_wrench": 2,
    }
