"""The walking controller: the paper's Fig. 2 as blocks, and as a Diagram of them."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPortIndex,
    LeafSystem,
    OutputPort,
)

from lola_drake.block import Block
from lola_drake.block_system import system_of
from lola_drake.blocks.adaptive_walking_pattern import AdaptiveWalkingPattern
from lola_drake.blocks.com_dynamics import ComDynamics
from lola_drake.blocks.configuration_force_control import ConfigurationForceControl
from lola_drake.blocks.foot_force_control import FORCE_CONTROLLED, FootForceControlParams
from lola_drake.blocks.force_distribution import ForceDistribution
from lola_drake.blocks.force_laws import FORCE_LAWS, law_class
from lola_drake.blocks.height_adaptation import HeightAdaptivePattern, bumpless
from lola_drake.blocks.imu_stabilizer import ImuStabilizer
from lola_drake.blocks.inverse_kinematics import InverseKinematics
from lola_drake.blocks.joint_servos import JointServos, JointServosParams, servo_gains
from lola_drake.blocks.walking_pattern import (
    WalkingPattern,
    WalkingPatternParams,
    standing_request,
)
from lola_drake.robot import (
    PADS,
    Kinematics,
    foot_sensor_geometry,
    leg_model,
    posture,
    solve_posture,
)
from lola_drake.scenario import Control, Scenario
from lola_drake.signals import FEET, of_foot, split_foot
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.contact_model import ServoCompliance, contact_matrix
from lola_drake.theory.foot_wrench import FootSensor
from lola_drake.theory.kinematics import FOOT_TASK
from lola_drake.theory.sensed_contact import pad_model

Blocks = Mapping[str, Block | LeafSystem]
"""Blocks by their names, those of one foot ending in _l or _r; a system of Drake's may be one."""


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


def controller_blocks(
    scenario: Scenario, kinematics: Kinematics, stance: Stance, steps: np.ndarray | None = None
) -> dict[str, Block]:
    """Return the blocks of a scenario's controller, by name.

    Args:
        scenario: its parameters.
        kinematics: the controller's model of the robot.
        stance: how the robot stands at the start.
        steps: (forward, left, turn, up) per step, shape (n, 4); None to follow `walk_command`.
    """
    control = scenario.active_control()
    law = FORCE_LAWS[control.law]
    motion = _configuration_space if law is ConfigurationForceControl else _task_space
    return {
        "walking_pattern": _pattern_class(scenario.pattern)(
            scenario.pattern,
            leg_model(kinematics),
            steps=steps,
            start_time=scenario.walk.start_time,
        ),
        "imu_stabilizer": ImuStabilizer(control.stabilizer),
        "force_distribution": ForceDistribution(control.distribution),
        **motion(scenario, kinematics, stance),
        "joint_servos": JointServos(
            control.servos, kinematics.velocity_limits, kinematics.effort_limits, stance.q
        ),
    }


def _pattern_class(params: WalkingPatternParams) -> type[WalkingPattern]:
    """Return the walking pattern with what is switched on, and no more."""
    if params.height_adaptation:
        return HeightAdaptivePattern
    return AdaptiveWalkingPattern if params.adaptive else WalkingPattern


def _task_space(scenario: Scenario, kinematics: Kinematics, stance: Stance) -> dict[str, Block]:
    """Return the force control and the CoM dynamics of each foot, and the inverse kinematics."""
    control = scenario.active_control()
    known: dict[str, Any] = {
        **shared(control.force),
        "inverse_contact_matrix": np.linalg.inv(pads_matrix(scenario)),
        "sole": pad_model(PADS, area_stiffness(scenario)),
        "sensor": FootSensor(*foot_sensor_geometry(kinematics)),
        "standing_wrench": (0.0, 0.0, 0.5 * kinematics.mass * GRAVITY),
    }
    compliances = servo_compliances(kinematics, stance.q, control.servos)
    blocks: dict[str, Block] = {}
    force_law = law_class(control.law, control.of_law())
    if scenario.pattern.height_adaptation:
        force_law = bumpless(force_law)
    for foot, servos in zip(FEET, compliances, strict=True):
        blocks[of_foot("force_control", foot)] = force_law(
            control.of_law(), foot, compliance=servos.matrix, relaxation=servos.relaxation, **known
        )
    return (
        blocks
        | _com_dynamics(control, stance)
        | {
            "inverse_kinematics": InverseKinematics(
                control.inverse_kinematics, kinematics, stance.q
            )
        }
    )


def shared(params: FootForceControlParams) -> dict[str, Any]:
    """Return what is the same for all force laws of a foot, by the names that their laws know."""
    names = (*(field.name for field in fields(FootForceControlParams)), "limits", "rate_limits")
    return {name: getattr(params, name) for name in names}


def _configuration_space(
    scenario: Scenario, kinematics: Kinematics, stance: Stance
) -> dict[str, Block]:
    """Return the force control of [23], which solves the inverse kinematics of both feet itself."""
    control = scenario.active_control()
    return {
        "configuration_force_control": ConfigurationForceControl(
            control.force,
            control.inverse_kinematics,
            kinematics,
            FootSensor(*foot_sensor_geometry(kinematics)),
            stance.q,
            scenario.pattern.ground_stiffness,
            servo_compliances(kinematics, stance.q, control.servos),
        )
    } | _com_dynamics(control, stance)


def _com_dynamics(control: Control, stance: Stance) -> dict[str, Block]:
    """Return the CoM dynamics of each foot."""
    return {
        of_foot("com_dynamics", foot): ComDynamics(
            control.com_dynamics,
            foot,
            inertia=stance.inertia,
            modification_limits=control.force.limits,
        )
        for foot in FEET
    }


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
    return contact_matrix(PADS, area_stiffness(scenario))


def area_stiffness(scenario: Scenario) -> float:
    """Return c_A,z of the pads, as stiff as the controller takes the ground (N/m^3)."""
    return scenario.pattern.ground_stiffness / sum(pad.area for pad in PADS)


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

    def __init__(self, blocks: Blocks):
        """Create the controller of blocks that read each other's outputs by name."""
        super().__init__()
        builder = DiagramBuilder()
        systems = {name: add_block(builder, name, block) for name, block in blocks.items()}
        _connect_by_name(builder, systems)
        builder.BuildInto(self)


def add_block(builder: DiagramBuilder, name: str, block: Block | LeafSystem) -> LeafSystem:
    """Add a block to a diagram, or a system of Drake's in its place, and return the system."""
    system = system_of(block) if isinstance(block, Block) else block
    return builder.AddNamedSystem(name, system)


def _connect_by_name(builder: DiagramBuilder, systems: Mapping[str, LeafSystem]) -> None:
    """Connect every input to the output of its name, and export all that is left over.

    A block of one foot gets that foot's signal where there is one. Inputs that no block provides
    come from outside; every output goes there too.
    """
    outputs: dict[str, OutputPort] = {}
    inputs: dict[str, InputPortIndex] = {}
    for block, system in systems.items():
        _, foot = split_foot(block)
        for i in range(system.num_output_ports()):
            output = system.get_output_port(i)
            outputs[of_foot(output.get_name(), foot)] = output
    for block, system in systems.items():
        _, foot = split_foot(block)
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            name = port.get_name()
            source = outputs.get(of_foot(name, foot)) or outputs.get(name)
            if source is not None:
                builder.Connect(source, port)
            elif name in inputs:
                builder.ConnectInput(inputs[name], port)
            else:
                inputs[name] = builder.ExportInput(port, name)
    for name, output in outputs.items():
        builder.ExportOutput(output, name)
