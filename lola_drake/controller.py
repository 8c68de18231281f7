"""The walking controller: the paper's Fig. 2 as a Diagram of blocks."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from lola_drake.blocks.com_dynamics import ComDynamics
from lola_drake.blocks.force_distribution import ForceDistribution
from lola_drake.blocks.hybrid_force_control import FootSensor, HybridForceControl
from lola_drake.blocks.imu_stabilizer import ImuStabilizer
from lola_drake.blocks.inverse_kinematics import InverseKinematics
from lola_drake.blocks.joint_servos import JointServos
from lola_drake.blocks.walking_pattern import WalkingPattern, standing_request
from lola_drake.robot import (
    PADS,
    Kinematics,
    foot_sensor_geometry,
    leg_model,
    posture,
    solve_posture,
)
from lola_drake.scenario import Scenario
from lola_drake.signals import FEET
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.contact_model import contact_matrix

PERIOD = 0.001
"""The control period (s), as on LOLA (paper)."""


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
        control = scenario.active_control()
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
        area = sum(pad.area for pad in PADS)
        stiffness = contact_matrix(PADS, control.force.model_stiffness / area)
        sensor = FootSensor(*foot_sensor_geometry(kinematics))
        force_control, com_dynamics = {}, {}
        for foot in FEET:
            force_control[foot] = add(
                f"force_control_{foot}",
                HybridForceControl(control.force, foot, stiffness, sensor, PERIOD),
            )
            com_dynamics[foot] = add(
                f"com_dynamics_{foot}",
                ComDynamics(
                    control.com_dynamics, foot, stance.inertia, control.force.limits(), PERIOD
                ),
            )
        inverse_kinematics = add(
            "inverse_kinematics",
            InverseKinematics(control.inverse_kinematics, kinematics, stance.q, PERIOD),
        )
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

        sources = {
            port: (system, port)
            for system in (pattern, stabilizer, distribution, inverse_kinematics)
            for port in (
                system.get_output_port(i).get_name() for i in range(system.num_output_ports())
            )
        }
        external = {"walk_command", "torso_orientation", "measured_wrench", "contact"}
        for foot in FEET:
            for system in (force_control[foot], com_dynamics[foot]):
                for i in range(system.num_output_ports()):
                    port = system.get_output_port(i).get_name()
                    sources[f"{port}_{foot}"] = (system, port)
        exported = {}
        systems = [
            (pattern, ""),
            (stabilizer, ""),
            (distribution, ""),
            *((force_control[foot], foot) for foot in FEET),
            *((com_dynamics[foot], foot) for foot in FEET),
            (inverse_kinematics, ""),
            (servos, ""),
        ]
        for system, foot in systems:
            for i in range(system.num_input_ports()):
                port = system.get_input_port(i)
                name = port.get_name()
                source = sources.get(name) or sources.get(f"{name}_{foot}")
                if source is not None:
                    builder.Connect(source[0].GetOutputPort(source[1]), port)
                elif name in external and name in exported:
                    builder.ConnectInput(exported[name], port)
                elif name in external:
                    exported[name] = builder.ExportInput(port, name)
                else:
                    raise LookupError(f"no block provides {system.get_name()}.{name}")
        for name in ("joint_desired_state", "joint_feedforward"):
            builder.ExportOutput(servos.GetOutputPort(name), name)
        for name, (system, port) in sources.items():
            builder.ExportOutput(system.GetOutputPort(port), name)
        builder.BuildInto(self)
