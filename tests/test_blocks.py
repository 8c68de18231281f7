"""Every block as a Drake system: its ports are those of its port card, and what feeds through."""

import inspect
import textwrap

import pytest
import yaml
from pydrake.systems.framework import LeafSystem

from lola_drake import signals
from lola_drake.controller import WalkingController
from lola_drake.scenario import load_scenario
from lola_drake.signals import Signal
from lola_drake.simulation import build_simulation

SIZES = {
    signal.name: signal.size for signal in vars(signals).values() if isinstance(signal, Signal)
}
SIZES |= {"joint_desired_state": 48, "joint_feedforward": 24, "plant_state": 61}
EVERYTHING = "everything"

FEED_THROUGH = {
    "WalkingPattern": {},
    "ImuStabilizer": {"modified_wrench": EVERYTHING},
    "ForceDistribution": {"desired_wrench": EVERYTHING},
    "HybridForceControl": {
        "task_command": EVERYTHING,
        "contact_wrench": {"task_reference", "measured_wrench"},
    },
    "ComDynamics": {},
    "InverseKinematics": {"joint_command": EVERYTHING},
    "ConfigurationForceControl": {
        "joint_command": EVERYTHING,
        "task_command_l": EVERYTHING,
        "task_command_r": EVERYTHING,
        "contact_wrench_l": {"measured_wrench"},
        "contact_wrench_r": {"measured_wrench"},
        "task_modification_l": {"task_reference"},
        "task_modification_r": {"task_reference"},
    },
    "JointServos": {},
    "Imu": {},
    "FootForceSensor": {},
    "ContactSwitches": {},
}
"""Which inputs reach an output within the same tick; outputs that are not named are state."""


def _blocks():
    """Return one block of every class, as they stand in the closed loops."""
    found = {}
    for variant in ("dyn", "original"):
        diagram = build_simulation(load_scenario("stand", {"variant": variant}))
        for system in diagram.GetSystems():
            inner = system.GetSystems() if isinstance(system, WalkingController) else [system]
            for block in inner:
                if type(block).__module__.startswith("lola_drake.blocks"):
                    found[type(block).__name__] = (block, diagram)
    return found


BLOCKS = _blocks()


@pytest.fixture(params=sorted(FEED_THROUGH))
def block(request):
    return BLOCKS[request.param][0]


def ports(block):
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    return inputs, outputs


def test_all_blocks_are_listed():
    assert set(BLOCKS) == set(FEED_THROUGH)
    assert all(isinstance(block, LeafSystem) for block, _ in BLOCKS.values())


def test_ports_are_those_of_the_port_card(block):
    doc = inspect.getdoc(type(block))
    card = yaml.safe_load(textwrap.dedent(doc.split(".. pydrake_system::")[1]))
    inputs, outputs = ports(block)
    assert card["name"] == type(block).__name__
    assert card["input_ports"] == [port.get_name() for port in inputs]
    assert card["output_ports"] == [port.get_name() for port in outputs]


def test_vector_ports_are_as_wide_as_their_signals(block):
    for port in (p for side in ports(block) for p in side):
        name = port.get_name()
        if name in ("reaction_forces", "contact_results"):
            continue
        assert port.size() == (SIZES.get(name) or SIZES[name[:-2]]), name


def test_direct_feed_through(block):
    inputs, outputs = ports(block)
    got = {}
    for o, output in enumerate(outputs):
        reached = {
            port.get_name() for i, port in enumerate(inputs) if block.HasDirectFeedthrough(i, o)
        }
        if reached:
            got[output.get_name()] = reached
    everything = {port.get_name() for port in inputs}
    expected = {
        name: everything if reached == EVERYTHING else reached
        for name, reached in FEED_THROUGH[type(block).__name__].items()
    }
    assert got == expected


def test_every_state_is_discrete_and_of_the_control_period(block):
    context = block.CreateDefaultContext()
    assert context.num_continuous_states() == 0
    assert context.num_abstract_states() == 0
    assert bool(context.num_discrete_state_groups()) == (type(block).__name__ != "ImuStabilizer")
    if context.num_discrete_state_groups():
        timing = block.GetUniquePeriodicDiscreteUpdateAttribute()
        assert (timing.period_sec(), timing.offset_sec()) == (0.001, 0.0)
