"""The closed loop as a Drake Diagram: plant, sensors and controller, block by block or fused."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    Multiplexer,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import PiecewisePolynomial

from lola_drake.atomic_file import reason
from lola_drake.block import Block, BlockError
from lola_drake.blocks.contact_switches import ContactSwitches
from lola_drake.blocks.foot_force_sensor import FootForceSensor
from lola_drake.blocks.imu import Imu
from lola_drake.controller import (
    Blocks,
    Stance,
    WalkingController,
    add_block,
    controller_blocks,
    initial_stance,
)
from lola_drake.fused import FusedSystem
from lola_drake.logged import LOGGED
from lola_drake.plant import add_plant, pad_joints, set_start, sole_joints
from lola_drake.pushes import connect_pushes
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario, ScenarioError, as_scenario
from lola_drake.servos import DRIVE_FEEDBACK, DampingServos, ImplicitServos
from lola_drake.signals import (
    JOINT_DESIRED_STATE,
    JOINT_FEEDFORWARD,
    PERIOD,
)
from lola_drake.swap import Replacement, load_laws, swapped
from lola_drake.theory.constants import GRAVITY
from lola_drake.walk import Walk

if TYPE_CHECKING:
    from lola_drake.mujoco_plant import MujocoPlant, MujocoServos

    Plant: TypeAlias = MultibodyPlant | MujocoPlant
    Servos: TypeAlias = ImplicitServos | DampingServos | MujocoServos


@dataclass(frozen=True)
class World:
    """The plant in its start pose, and the blocks that sense and control it.

    Attributes:
        builder: of the diagram that has the plant.
        plant: in that diagram, of Drake or MuJoCo.
        servos: in the plant.
        stance: how the robot stands at the start.
        sensors, controller: the blocks, by name.
    """

    builder: DiagramBuilder
    plant: "Plant"
    servos: "Servos"
    stance: Stance
    sensors: Blocks
    controller: Blocks


def make_world(
    scenario: Scenario,
    blocks: Mapping[str, Replacement] | None = None,
    servos: type[ImplicitServos | DampingServos] = ImplicitServos,
) -> World:
    """Return the plant of a scenario, and its blocks, some of them replaced.

    The servos are those of Drake's plant; MuJoCo's has its own.
    """
    builder, kinematics = DiagramBuilder(), Kinematics()
    with _posture(scenario):
        stance = initial_stance(scenario, kinematics)
    if scenario.plant == "mujoco":
        plant, driven = _mujoco_plant(builder, scenario, stance)
    else:
        plant, driven = _drake_plant(builder, scenario, stance, servos)
    sensors = _sensor_blocks(scenario, kinematics)
    most = 1 + int(scenario.duration / scenario.pattern.step_time)
    steps = scenario.walk.planned(most) if scenario.walk.steps else None
    controller = controller_blocks(scenario, kinematics, stance, steps)
    all_blocks = swapped(sensors | controller, load_laws(scenario.blocks) | dict(blocks or {}))
    return World(
        builder,
        plant,
        driven,
        stance,
        {name: all_blocks[name] for name in sensors},
        {name: all_blocks[name] for name in controller},
    )


@contextmanager
def _posture(scenario: Scenario) -> Iterator[None]:
    """Say which keys ask for a posture that the robot cannot take."""
    try:
        yield
    except ValueError as error:
        keys = "pattern.com_height, step_width and zmp_forward"
        raise ScenarioError(f"{scenario.name}: {reason(error)}; see {keys}") from None


def _drake_plant(
    builder: DiagramBuilder,
    scenario: Scenario,
    stance: Stance,
    servos: type[ImplicitServos | DampingServos],
) -> tuple["Plant", "Servos"]:
    plant, _ = add_plant(builder, scenario.terrain, scenario.model_errors)
    driven = servos(plant, scenario.real_servos())
    plant.Finalize()
    connect_pushes(builder, plant, scenario.pushes)
    set_start(plant, scenario.start, scenario.terrain, stance.q, stance.p_PT)
    return plant, driven


def _mujoco_plant(
    builder: DiagramBuilder, scenario: Scenario, stance: Stance
) -> tuple["Plant", "Servos"]:
    from lola_drake.mujoco_plant import MujocoPlant, MujocoServos

    robot = Kinematics().plant
    set_start(robot, scenario.start, scenario.terrain, stance.q, stance.p_PT)
    q = robot.GetPositions(robot.CreateDefaultContext())
    plant = MujocoPlant(scenario, q, sole_joints(robot), pad_joints(robot))
    return builder.AddNamedSystem("plant", plant), MujocoServos(plant)


def _sensor_blocks(scenario: Scenario, kinematics: Kinematics) -> dict[str, Block]:
    sensors, robot, seed = scenario.active_sensors(), kinematics.plant, scenario.seed
    half_weight = 0.5 * kinematics.mass * GRAVITY
    standing = np.tile([0.0, 0.0, half_weight, 0.0, 0.0, 0.0], 2)
    soles, pads = sole_joints(robot), pad_joints(robot)
    missed = sensors.missed
    return {
        "imu": Imu(sensors.imu, seed, missed),
        "foot_force_sensor": FootForceSensor(sensors.foot_force, soles, standing, seed, missed),
        "contact_switches": ContactSwitches(sensors.contact, pads, kinematics.tree, missed),
    }


@contextmanager
def _loops_in_one_line() -> Iterator[None]:
    """Say which signals wait for one another; Drake tells that in many lines."""
    try:
        yield
    except RuntimeError as error:
        if "algebraic loop" not in str(error):
            raise
        signals = re.findall(r"OutputPort\[\d+\] \((\w+)\)", str(error))
        waiting = ", ".join(dict.fromkeys(signals))
        raise BlockError(f"these signals wait for one another: {waiting}") from None


@_loops_in_one_line()
def build_simulation(
    scenario: Scenario | str | Path, blocks: Mapping[str, Replacement] | None = None
) -> Diagram:
    """Return the closed loop of a scenario as a Drake Diagram, in its start pose.

    Args:
        scenario: its parameters, the name of one that comes with the package, or a file's path.
        blocks: laws of your own by the names of the blocks that they replace, see `swapped`.

    Raises:
        BlockError: if such a law does not fit.
        ScenarioError: if the scenario's plant is none of Drake's.
    """
    scenario = as_scenario(scenario)
    if scenario.plant != "drake":
        raise ScenarioError(
            f"plant: {scenario.plant!r} runs in the fused engine alone; diagrams, linear "
            "models and the live view need 'drake'"
        )
    world = make_world(scenario, blocks)
    builder, plant = world.builder, world.plant
    controller = builder.AddNamedSystem("controller", WalkingController(world.controller))
    sensors = [add_block(builder, name, block) for name, block in world.sensors.items()]
    command = builder.AddNamedSystem("walk_command", _command_source(scenario.walk))
    sources = {
        port.get_name(): port
        for system in sensors
        for port in (system.get_output_port(i) for i in range(system.num_output_ports()))
    } | _plant_ports(plant)
    sources["walk_command"] = command.get_output_port()
    for system in (controller, *sensors):
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            builder.Connect(sources[port.get_name()], port)
    world.servos.connect(
        builder,
        controller.GetOutputPort(JOINT_DESIRED_STATE.name),
        controller.GetOutputPort(JOINT_FEEDFORWARD.name),
    )
    _add_log(builder, [port for _, port in log_ports(controller, plant, command, *sensors)])
    diagram = builder.Build()
    diagram.set_name("lola")
    return diagram


def build_fused(world: World, scenario: Scenario, *, compile_laws: bool | None = None) -> Diagram:
    """Return the closed loop with all of sensors and controller in one system, for speed.

    It does what the diagram of blocks does. The log has what the fused system says of every tick.
    """
    builder, plant = world.builder, world.plant
    parts = {**world.sensors, "drive_guard": world.servos.guard(), **world.controller}
    blocks = {name: block for name, block in parts.items() if isinstance(block, Block)}
    if own := parts.keys() - blocks.keys():
        raise BlockError(f"{', '.join(sorted(own))}: without a declared law it cannot be fused")
    fused = builder.AddNamedSystem("fused", FusedSystem(blocks, compile_laws=compile_laws))
    command = builder.AddNamedSystem("walk_command", _command_source(scenario.walk))
    layout, state = fused.layout, fused.GetOutputPort("state")
    feedback = world.servos.connect(
        builder,
        _cut(builder, state, layout.signals[JOINT_DESIRED_STATE.name]),
        _cut(builder, state, layout.signals[JOINT_FEEDFORWARD.name]),
    )
    sources = _plant_ports(plant) | {
        "walk_command": command.get_output_port(),
        DRIVE_FEEDBACK.name: feedback,
    }
    for i in range(fused.num_input_ports()):
        port = fused.get_input_port(i)
        builder.Connect(sources[port.get_name()], port)
    _add_log(builder, [_cut(builder, fused.GetOutputPort("tick"), layout.visible)])
    diagram = builder.Build()
    diagram.set_name("lola")
    return diagram


def _cut(builder: DiagramBuilder, port: OutputPort, where: slice) -> OutputPort:
    """Return a port with some entries of another one, without a call into Python."""
    sizes = [where.start, where.stop - where.start, port.size() - where.stop]
    cut = builder.AddSystem(Demultiplexer([size for size in sizes if size]))
    builder.Connect(port, cut.get_input_port())
    return cut.get_output_port(1 if where.start else 0)


def _plant_ports(plant: "Plant") -> dict[str, OutputPort]:
    """Return what sensors may read of the plant, by the names of their inputs."""
    return {
        "plant_state": plant.get_state_output_port(),
        "reaction_forces": plant.get_reaction_forces_output_port(),
    }


def _command_source(walk: Walk) -> System:
    if not walk.command:
        return ConstantVectorSource([0.0, 0.0, 0.0])
    times = [0.0, *(command.time for command in walk.command)]
    values = [(0.0, 0.0, 0.0), *((c.v_x, c.v_y, c.turn_rate) for c in walk.command)]
    if times[1] == 0.0:
        times, values = times[1:], values[1:]
    # The hold needs a last break, where the last command goes on.
    times, values = [*times, times[-1] + 1.0], [*values, values[-1]]
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.transpose(values)))


def _add_log(builder: DiagramBuilder, ports: list[OutputPort]) -> None:
    """Log signals in one wide sink, one after the other."""
    multiplexer = builder.AddNamedSystem(
        "log_multiplexer", Multiplexer([port.size() for port in ports])
    )
    for i, port in enumerate(ports):
        builder.Connect(port, multiplexer.get_input_port(i))
    total = multiplexer.get_output_port().size()
    log = builder.AddNamedSystem("log", VectorLogSink(total, publish_period=PERIOD))
    builder.Connect(multiplexer.get_output_port(), log.get_input_port())


def log_ports(
    controller: Diagram, plant: "Plant", command: System, *sensors: System
) -> list[tuple[str, OutputPort]]:
    """Return the logged ports of a diagram of blocks, by their names in the record."""
    ports = {
        port.get_name(): port
        for system in (controller, *sensors)
        for port in (system.get_output_port(i) for i in range(system.num_output_ports()))
    }
    ports["walk_command"] = command.get_output_port()
    ports = {name: port for name, port in ports.items() if name in LOGGED}
    # The plant first: then all of Python runs in one go, while it is warm in the caches.
    first = {
        "plant_state": plant.get_state_output_port(),
        "joint_torque": plant.get_net_actuation_output_port(),
    }
    return list((first | ports).items())
