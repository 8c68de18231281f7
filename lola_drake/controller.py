"""The walking controller: the paper's Fig. 2 as a Diagram of blocks."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from lola_drake.blocks.com_dynamics import ComDynamics
from lola_drake.blocks.configuration_force_control import ConfigurationForceControl
from lola_drake.blocks.force_distribution import ForceDistribution
from lola_drake.blocks.hybrid_force_control import (
    FORCE_CONTROLLED,
    FootSensor,
    HybridForceControl,
)
from lola_drake.blocks.imu_stabilizer import ImuStabilizer
from lola_drake.blocks.inverse_kinematics import InverseKinematics
from lola_drake.blocks.joint_servos import JointServos, JointServosParams, servo_gains
from lola_drake.blocks.walking_pattern import WalkingPattern, standing_request
from lola_drake.robot import (
    FOOT_TASK,
    PADS,
    Kinematics,
    foot_sensor_geometry,
    leg_model,
    posture,
    solve_posture,
)
from lola_drake.scenario import Scenario
from lola_drake.signals import FEET, PERIOD
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.contact_model import ServoCompliance, contact_matrix


@dataclass(frozen=True)
class Stance:
    """How the robot stands at the start.

    Attributes:
        q: joint angles (rad), shape (24,).
        p_PT: the torso in the plan's frame (m), shape (3,).
        inertia: theta_xx, theta_yy (kg m^2) about the CoM, and the mass (kg), shape (3,).
    """

    q: np.ndarray
    p_PT: np.ndarray
    inertia: np.ndarray


def initial_stance(scenario: Scenario, kinematics: Kinematics) -> Stance:
    """Return the posture in which the plan begins, with level feet and an upright torso."""
    request = standing_request(scenario.pattern)
    sink = 0.5 * kinematics.mass * GRAVITY / scenario.pattern.ground_stiffness
    w = np.zeros(12)
    for i, foot in zip((0, 6), request.feet, strict=True):
        w[i : i + 3] = foot[:3] - request.com - [0.0, 0.0, sink]
    q = solve_posture(kinematics, w, posture(hip=0.4, knee=0.8))
    p_TCom, theta = kinematics.centroidal_inertia(q)
    inertia = np.array([theta[0, 0], theta[1, 1], kinematics.mass])
    return Stance(q=q, p_PT=request.com - p_TCom, inertia=inertia)


def servo_compliances(
    kinematics: Kinematics, q: np.ndarray, servos: JointServosParams
) -> list[ServoCompliance]:
    """Return how each foot gives way to its own wrench: J K^-1 J^T, with the servos' stiffness K.

    Args:
        kinematics: the controller's model.
        q: joint angles (rad), shape (24,).
        servos: their parameters.
    """
    kinematics.update(q)
    stiffness, _ = servo_gains(kinematics.plant, servos)
    rows = [kinematics.jacobian[FOOT_TASK * foot + FORCE_CONTROLLED] for foot in range(len(FEET))]
    return [
        ServoCompliance(jacobian @ (jacobian / stiffness).T, 1 / servos.position_gain)
        for jacobian in rows
    ]


def pads_matrix(scenario: Scenario) -> np.ndarray:
    """Return U of eq. 8 for all pads of a foot, as stiff as the controller takes the ground."""
    return contact_matrix(PADS, scenario.pattern.ground_stiffness / sum(pad.area for pad in PADS))


class WalkingController(Diagram):
    """Everything between sensors and joints; every signal is also an output, for logs.

    .. pydrake_system::

        name: WalkingController
        input_ports:
        - walk_command
        - torso_orientation
        - measured_wrench
        - contact
        output_ports:
        - joint_desired_state
        - joint_feedforward
        - (every signal between the blocks)
    """

    def __init__(self, scenario: Scenario, steps: np.ndarray | None = None):
        """Create the controller of a scenario.

        Args:
            scenario: its parameters.
            steps: (forward, left, turn) per step, shape (n, 3); None to follow `walk_command`.
        """
        super().__init__()
        kinematics = Kinematics()
        self.stance = stance = initial_stance(scenario, kinematics)
        control = scenario.control
        builder = DiagramBuilder()
        add = builder.AddNamedSystem

        pattern = add(
            "walking_pattern",
            WalkingPattern(
                scenario.pattern,
                leg_model(kinematics),
                PERIOD,
                steps=steps,
                start_time=scenario.walk.start_time,
            ),
        )
        stabilizer = add("imu_stabilizer", ImuStabilizer(control.stabilizer))
        distribution = add("force_distribution", ForceDistribution(control.distribution, PERIOD))
        add_motion = _add_configuration_space if scenario.variant == "original" else _add_task_space
        motion = add_motion(builder, scenario, kinematics, stance)
        servos = add(
            "joint_servos",
            JointServos(
                control.servos,
                kinematics.velocity_limits,
                kinematics.effort_limits,
                stance.q,
                PERIOD,
            ),
        )

        _connect_by_name(
            builder, [(pattern, ""), (stabilizer, ""), (distribution, ""), *motion, (servos, "")]
        )
        builder.BuildInto(self)


_Blocks = list[tuple[LeafSystem, str]]
"""Blocks, each with the foot that it serves, "l", "r", or "" for both."""


def _add_task_space(
    builder: DiagramBuilder, scenario: Scenario, kinematics: Kinematics, stance: Stance
) -> _Blocks:
    """Add the paper's force control and CoM dynamics of each foot, and the inverse kinematics."""
    control = scenario.active_control()
    sensor = FootSensor(*foot_sensor_geometry(kinematics))
    pads, servos = pads_matrix(scenario), servo_compliances(kinematics, stance.q, control.servos)
    force_control = [
        (HybridForceControl(control.force, foot, pads, compliance, sensor, PERIOD), foot)
        for foot, compliance in zip(FEET, servos, strict=True)
    ]
    com_dynamics = [
        (
            ComDynamics(control.com_dynamics, foot, stance.inertia, control.force.limits(), PERIOD),
            foot,
        )
        for foot in FEET
    ]
    for name, blocks in (("force_control", force_control), ("com_dynamics", com_dynamics)):
        for block, foot in blocks:
            builder.AddNamedSystem(f"{name}_{foot}", block)
    inverse_kinematics = builder.AddNamedSystem(
        "inverse_kinematics",
        InverseKinematics(control.inverse_kinematics, kinematics, stance.q, PERIOD),
    )
    return [*force_control, *com_dynamics, (inverse_kinematics, "")]


def _add_configuration_space(
    builder: DiagramBuilder, scenario: Scenario, kinematics: Kinematics, stance: Stance
) -> _Blocks:
    """Add the force control of [23], which solves the inverse kinematics of both feet itself."""
    control = scenario.active_control()
    block = builder.AddNamedSystem(
        "configuration_force_control",
        ConfigurationForceControl(
            control.force,
            control.inverse_kinematics,
            kinematics,
            FootSensor(*foot_sensor_geometry(kinematics)),
            scenario.pattern.ground_stiffness,
            servo_compliances(kinematics, stance.q, control.servos),
            stance.q,
            PERIOD,
        ),
    )
    return [(block, "")]


def _connect_by_name(builder: DiagramBuilder, blocks: _Blocks) -> None:
    """Connect every input to the output of its name, and export all that is left over.

    A foot's signals carry its name as a suffix. Inputs that no block provides come from outside;
    every output goes there too.
    """
    outputs = {}
    for block, foot in blocks:
        for i in range(block.num_output_ports()):
            port = block.get_output_port(i)
            outputs[f"{port.get_name()}_{foot}" if foot else port.get_name()] = port
    inputs = {}
    for block, foot in blocks:
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            name = port.get_name()
            source = outputs.get(name) or outputs.get(f"{name}_{foot}")
            if source is not None:
                builder.Connect(source, port)
            elif name in inputs:
                builder.ConnectInput(inputs[name], port)
            else:
                inputs[name] = builder.ExportInput(port, name)
    for name, port in outputs.items():
        builder.ExportOutput(port, name)
