"""Every block's ports, their sizes, what feeds through directly, and its period."""

import ast
import inspect
from pathlib import Path

import numpy as np
import pytest
import yaml

from lola_drake import signals
from lola_drake.block_system import BlockSystem
from lola_drake.blocks.foot_force_control import FootForceControl
from lola_drake.scenario import Scenario
from lola_drake.signals import JOINTS, PERIOD, Signal
from lola_drake.world import build_simulation

FEEDTHROUGH = {
    "walking_pattern": {
        "task_reference": set(),
        "gait_phase": set(),
        "ideal_wrench": set(),
        "planned_motion": set(),
    },
    "imu_stabilizer": {
        "modified_wrench": {
            "ideal_wrench",
            "torso_orientation",
            "gait_phase",
            "task_modification_l",
            "task_modification_r",
        }
    },
    "force_distribution": {
        "desired_wrench": {"modified_wrench", "ideal_wrench", "gait_phase", "task_reference"}
    },
    "force_control_l": {
        "task_command": {
            "task_reference",
            "gait_phase",
            "desired_wrench",
            "measured_wrench",
            "com_dynamics_rate",
            "torso_orientation",
        },
        "force_rate": {"task_reference", "desired_wrench", "measured_wrench"},
        "grip": {"task_reference", "measured_wrench"},
        "contact_wrench": {"task_reference", "measured_wrench"},
        "task_modification": set(),
    },
    "com_dynamics_l": {"com_dynamics_rate": set()},
    "inverse_kinematics": {
        "joint_command": {
            "task_command_l",
            "task_command_r",
            "task_reference",
            "desired_wrench",
            "ideal_wrench",
            "gait_phase",
        }
    },
    "configuration_force_control": {
        "joint_command": {
            "task_reference",
            "gait_phase",
            "desired_wrench",
            "ideal_wrench",
            "measured_wrench",
            "com_dynamics_rate_l",
            "com_dynamics_rate_r",
            "torso_orientation",
        },
        "contact_wrench_l": {"measured_wrench"},
        "contact_wrench_r": {"measured_wrench"},
        "task_modification_l": {"task_reference"},
        "task_modification_r": {"task_reference"},
    },
    "joint_servos": {"joint_desired_state": set(), "joint_feedforward": set()},
    "imu": {"torso_orientation": set()},
    "foot_force_sensor": {"measured_wrench": set()},
    "contact_switches": {"contact": set(), "ground_force": set()},
}
"""Which inputs every output needs at once, by block."""
FEEDTHROUGH["force_control_r"] = FEEDTHROUGH["force_control_l"]
FEEDTHROUGH["com_dynamics_r"] = FEEDTHROUGH["com_dynamics_l"]
for _foot in "lr":
    FEEDTHROUGH["configuration_force_control"][f"task_command_{_foot}"] = FEEDTHROUGH[
        "configuration_force_control"
    ]["joint_command"]

SIZES = {signal.name: signal.size for signal in vars(signals).values() if type(signal) is Signal}
SIZES |= {signal.name: signal.size for signal in FootForceControl.signals}
SIZES |= {"joint_desired_state": 2 * len(JOINTS), "joint_feedforward": len(JOINTS)}
FROM_PLANT = {"reaction_forces", "contact_results"}
STATELESS = {"imu_stabilizer"}

EVERY_BLOCK = pytest.mark.parametrize("name", FEEDTHROUGH)


@pytest.fixture(scope="module")
def blocks():
    found = {}
    for variant in ("dyn", "original"):
        simulation = build_simulation(Scenario(variant=variant))
        controller = simulation.GetSubsystemByName("controller")
        for system in (*simulation.GetSystems(), *controller.GetSystems()):
            if isinstance(system, BlockSystem):
                found[system.get_name()] = system
    return found


def ports(block):
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    return inputs, outputs


def names(some_ports):
    return [port.get_name() for port in some_ports]


def card(block):
    """Return what the docstring's card tells."""
    _, found, text = type(block.block).__doc__.partition(".. pydrake_system::\n")
    assert found
    return yaml.safe_load(text)


def test_the_table_names_every_block(blocks):
    assert set(blocks) == set(FEEDTHROUGH)


@EVERY_BLOCK
def test_ports_are_those_of_the_card(blocks, name):
    inputs, outputs = ports(blocks[name])
    told = card(blocks[name])
    assert names(inputs) == told["input_ports"]
    assert names(outputs) == told["output_ports"]


@EVERY_BLOCK
def test_card_is_called_as_the_block(blocks, name):
    assert card(blocks[name])["name"] == type(blocks[name].block).__name__


@EVERY_BLOCK
def test_sizes_are_those_of_the_signals(blocks, name):
    inputs, outputs = ports(blocks[name])
    for port in (*inputs, *outputs):
        if port.get_name() not in FROM_PLANT:
            signal = port.get_name().removesuffix("_l").removesuffix("_r")
            assert port.size() == SIZES[signal], port.get_name()


@EVERY_BLOCK
def test_outputs_need_at_once_what_the_table_says(blocks, name):
    block = blocks[name]
    inputs, outputs = ports(block)
    found = {
        output.get_name(): {
            port.get_name()
            for i, port in enumerate(inputs)
            if block.HasDirectFeedthrough(input_port=i, output_port=j)
        }
        for j, output in enumerate(outputs)
    }
    assert found == FEEDTHROUGH[name]


@EVERY_BLOCK
def test_a_block_with_an_empty_table_has_no_feedthrough_at_all(blocks, name):
    assert blocks[name].HasAnyDirectFeedthrough() == any(FEEDTHROUGH[name].values())


@EVERY_BLOCK
def test_state_is_discrete(blocks, name):
    context = blocks[name].CreateDefaultContext()
    assert context.num_continuous_states() == 0
    assert context.num_abstract_states() == 0


@EVERY_BLOCK
def test_state_changes_every_millisecond_from_the_start(blocks, name):
    timing = blocks[name].GetUniquePeriodicDiscreteUpdateAttribute()
    if name in STATELESS:
        assert timing is None and blocks[name].CreateDefaultContext().is_stateless()
    else:
        assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, 0.0)


@pytest.mark.parametrize("variant", ["dyn", "original"])
def test_the_loop_is_open_where_the_sensors_and_the_bus_are(variant):
    controller = build_simulation(Scenario(variant=variant)).GetSubsystemByName("controller")
    through = {
        output.get_name()
        for j, output in enumerate(ports(controller)[1])
        if any(controller.HasDirectFeedthrough(i, j) for i in range(controller.num_input_ports()))
    }
    assert {"joint_command", "modified_wrench", "desired_wrench"} <= through
    assert not through & {"joint_desired_state", "joint_feedforward", "task_reference"}


def test_period_is_a_millisecond():
    assert np.isclose(PERIOD, 1e-3)


def test_blocks_are_laws_and_hardly_speak_of_drake():
    """Counted is what names something of pydrake's, functions that do from first line to last."""
    counted = 0
    for file in Path(inspect.getfile(FootForceControl)).parent.glob("*.py"):
        nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
        imports = [n for n in nodes if isinstance(n, ast.ImportFrom) and "pydrake" in str(n.module)]
        names = {name.name for statement in imports for name in statement.names}
        speaking = [
            node
            for node in nodes
            if isinstance(node, (ast.FunctionDef, ast.Assign))
            and any(isinstance(n, ast.Name) and n.id in names for n in ast.walk(node))
        ]
        lines = {
            line for n in imports + speaking for line in range(n.lineno, (n.end_lineno or 0) + 1)
        }
        counted += len(lines)
    assert 0 < counted <= 150
