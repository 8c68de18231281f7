"""A law of one's own in place of a block: what may take its place, and what is refused."""

import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem

from lola_drake.block import Block, BlockError, Part, law
from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.blocks.imu_stabilizer import ImuStabilizer, ImuStabilizerParams
from lola_drake.fused_layout import Layout
from lola_drake.scenario import Scenario, load_scenario
from lola_drake.signals import TASK_REFERENCE, Field, Signal
from lola_drake.simulation import ENGINES, make_world, simulate, start
from lola_drake.swap import swapped
from lola_drake.world import build_fused, build_simulation

SHORT = {"duration": 0.05}


class PassOn(Block):
    """No stabiliser at all."""

    @law
    def modified_wrench(ideal_wrench):
        return ideal_wrench


class StiffFoot(HybridForceControl):
    """A foot that stays as it is planned."""

    @law
    def next_task_modification(task_modification):
        return (0.0, 0.0, 0.0)


class System(LeafSystem):
    """The same as `PassOn`, as a system of Drake's."""

    def __init__(self, output="modified_wrench", size=6, **inputs):
        super().__init__()
        for name, entries in (inputs or {"ideal_wrench": 6}).items():
            self.DeclareVectorInputPort(name, entries)

        def calculate(context, vector):
            vector.SetFromVector(self.get_input_port(0).Eval(context)[:size])

        self.DeclareVectorOutputPort(output, size, calculate)


@pytest.fixture(scope="module")
def blocks():
    world = make_world(Scenario())
    return world.sensors | world.controller


def refusal(blocks, **replacements):
    """Return what is said of a replacement; it is one line."""
    with pytest.raises(BlockError) as caught:
        swapped(blocks, replacements)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_nothing_is_swapped_without_replacements(blocks):
    assert swapped(blocks, {}) == blocks


def test_a_class_takes_the_place_of_a_block(blocks):
    result = swapped(blocks, {"imu_stabilizer": PassOn})
    assert list(result) == list(blocks)
    assert type(result["imu_stabilizer"]) is PassOn
    assert all(result[name] is blocks[name] for name in blocks if name != "imu_stabilizer")


def test_a_class_takes_the_place_of_the_blocks_of_both_feet(blocks):
    result = swapped(blocks, {"force_control": StiffFoot})
    for foot in "lr":
        made = result[f"force_control_{foot}"]
        assert (type(made), made.foot) == (StiffFoot, foot)
        assert made.params is blocks["force_control_l"].params
        assert made.constants.keys() == blocks["force_control_l"].constants.keys()


class Firm(Block):
    """A foot that stays as it is planned, without a force law."""

    parts = {"w_id": Part(TASK_REFERENCE, "w"), "w_dot_id": Part(TASK_REFERENCE, "w_dot")}

    @law
    def task_command(w_id, w_dot_id):
        return (*w_id, *w_dot_id)

    @law
    def contact_wrench(w_id):
        return (0.0, 0.0, 0.0)

    @law
    def task_modification(w_id):
        return (0.0, 0.0, 0.0)


def test_what_only_its_class_knows_a_replacement_need_not_give(blocks):
    known = blocks["force_control_l"]
    made = swapped(blocks, {"force_control": Firm})["force_control_l"]
    assert set(known.outputs) - set(made.outputs) == {s.name for s in known.signals}


def test_signals_of_its_base_are_known_to_a_block():
    class Deaf(StiffFoot):
        signals = (Signal("deaf", "Made up.", (Field("n", ("",), "-"),)),)

    assert [s.name for s in Deaf.signals] == ["force_rate", "grip", "deaf"]


def test_a_class_takes_the_place_of_one_foots_block(blocks):
    result = swapped(blocks, {"force_control_r": StiffFoot})
    assert type(result["force_control_l"]) is HybridForceControl
    assert (type(result["force_control_r"]), result["force_control_r"].foot) == (StiffFoot, "r")


def test_an_instance_takes_the_place_of_a_block(blocks):
    one = ImuStabilizer(ImuStabilizerParams(stiffness=7.0))
    assert swapped(blocks, {"imu_stabilizer": one})["imu_stabilizer"] is one


def test_a_function_of_the_block_takes_its_place(blocks):
    def softer(block):
        return ImuStabilizer(ImuStabilizerParams(stiffness=0.5 * block.params.stiffness))

    assert swapped(blocks, {"imu_stabilizer": softer})["imu_stabilizer"].params.stiffness == 1000.0


def test_a_system_of_drakes_takes_the_place_of_a_block(blocks):
    system = System()
    assert swapped(blocks, {"imu_stabilizer": system})["imu_stabilizer"] is system
    assert isinstance(
        swapped(blocks, {"imu_stabilizer": lambda block: System()})["imu_stabilizer"], System
    )


def test_an_unknown_name_is_refused_with_what_may_be_meant(blocks):
    said = refusal(blocks, imu_stabiliser=PassOn)
    assert said == "no block is called 'imu_stabiliser', did you mean imu_stabilizer?"


def test_a_block_of_another_variant_is_refused(blocks):
    assert "no block is called 'configuration_force_control'" in refusal(
        blocks, configuration_force_control=PassOn
    )


def test_one_instance_for_both_feet_is_refused(blocks):
    said = refusal(blocks, force_control=blocks["force_control_l"])
    expected = "give a class, or one block each for force_control_l and force_control_r"
    assert said == f"force_control: {expected}"


@pytest.mark.parametrize("thing", [3, "text", None, np.zeros(2), lambda block: None])
def test_what_is_no_block_is_refused(blocks, thing):
    said = refusal(blocks, imu_stabilizer=thing)
    assert said.startswith("imu_stabilizer: ")
    assert said.endswith("is neither a Block nor a LeafSystem")


def test_a_missing_output_is_refused(blocks):
    class Silent(Block):
        @law
        def com_dynamics_rate():
            return (0.0, 0.0, 0.0)

    assert refusal(blocks, imu_stabilizer=Silent) == (
        "imu_stabilizer: Silent gives no 'modified_wrench', as it must"
    )
    assert refusal(blocks, imu_stabilizer=System("wrench")) == (
        "imu_stabilizer: System gives no 'modified_wrench', as it must"
    )


def test_an_output_of_another_size_is_refused(blocks):
    class Short(Block):
        signals = (Signal("modified_wrench", "Two.", (Field("F", ("x", "y"), "N"),)),)

        @law
        def modified_wrench():
            return (0.0, 0.0)

    for replacement, name in ((Short, "Short"), (System(size=2), "System")):
        assert refusal(blocks, imu_stabilizer=replacement) == (
            f"imu_stabilizer: 'modified_wrench' of {name} has 2 entries, it must have 6"
        )


@pytest.mark.parametrize("name", ["ideal_wrench", "torso_orientation", "contact_wrench_l"])
def test_an_input_of_another_size_is_refused(blocks, name):
    size = {"ideal_wrench": 6, "torso_orientation": 4, "contact_wrench_l": 3}[name]
    assert refusal(blocks, imu_stabilizer=System(**({"ideal_wrench": 6} | {name: 5}))) == (
        f"imu_stabilizer: input {name!r} of System has 5, there is {size} entries"
    )


def test_a_systems_input_that_is_no_signal_is_refused(blocks):
    assert refusal(blocks, imu_stabilizer=System(ideal_wrench=6, colour=3)) == (
        "imu_stabilizer: input 'colour' of System has 3, there is no signal of that name"
    )


def test_an_argument_that_is_nothing_is_refused(blocks):
    class Odd(Block):
        @law
        def modified_wrench(ideal_wrench, colour):
            return ideal_wrench

    assert refusal(blocks, imu_stabilizer=Odd).startswith(
        "Odd.modified_wrench: its argument 'colour' is no signal"
    )


def test_a_signal_that_no_block_gives_is_refused(blocks):
    class OfWhichFoot(Block):
        @law
        def modified_wrench(ideal_wrench, contact_wrench):
            return ideal_wrench

    expected = "imu_stabilizer: no block gives its input 'contact_wrench'"
    assert refusal(blocks, imu_stabilizer=OfWhichFoot) == expected
    system = System(ideal_wrench=6, contact_wrench=3)
    assert refusal(blocks, imu_stabilizer=system) == expected


def test_what_is_for_the_other_foot_or_none_is_refused(blocks):
    right = blocks["force_control_r"]
    assert refusal(blocks, force_control_l=right) == (
        "force_control_l: HybridForceControl is one of the foot 'r', it must be one of the foot 'l'"
    )
    neither = ImuStabilizer(ImuStabilizerParams(), "l")
    assert refusal(blocks, imu_stabilizer=neither) == (
        "imu_stabilizer: ImuStabilizer is one of the foot 'l', it must be one of no foot"
    )


def test_what_another_block_gives_is_refused(blocks):
    class Both(PassOn):
        @law
        def desired_wrench(ideal_wrench):
            return (*ideal_wrench, *ideal_wrench)

    assert refusal(blocks, imu_stabilizer=Both) == (
        "imu_stabilizer and force_distribution both give 'desired_wrench'"
    )


def test_laws_that_wait_for_one_another_are_refused(blocks):
    class Loop(Block):
        @law
        def modified_wrench(desired_wrench):
            return desired_wrench[:6]

    with pytest.raises(BlockError) as caught:
        Layout(swapped(blocks, {"imu_stabilizer": Loop}))
    assert str(caught.value).endswith("wait for one another: modified_wrench, desired_wrench")
    with pytest.raises(BlockError, match="these signals wait for one another: ") as caught:
        build_simulation("stand", {"imu_stabilizer": Loop})
    assert {"modified_wrench", "desired_wrench"} <= set(
        str(caught.value).split(": ")[1].split(", ")
    )
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 200


def test_a_system_may_read_what_carries_an_object(blocks):
    class Switches(LeafSystem):
        def __init__(self, block):
            super().__init__()
            model = block.objects["pad_reactions"].model
            self.DeclareAbstractInputPort("reaction_forces", model())
            for name, size in (("contact", 8), ("ground_force", 6)):
                self.DeclareVectorOutputPort(name, size, lambda context, vector: None)

    made = swapped(blocks, {"contact_switches": Switches})["contact_switches"]
    assert isinstance(made, Switches)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_class_and_an_instance_run_the_same_in_both_engines(engine):
    scenario = load_scenario("stand", SHORT)
    plain = simulate(scenario, engine=engine)
    assert not np.array_equal(plain.signals["modified_wrench"], plain.signals["ideal_wrench"])
    for replacement in (PassOn, PassOn()):
        blocks = {"imu_stabilizer": replacement, "force_control": StiffFoot}
        swap = simulate(scenario, blocks=blocks, engine=engine)
        assert np.array_equal(swap.signals["modified_wrench"], swap.signals["ideal_wrench"])
        for foot in "lr":
            assert np.abs(plain.signals[f"task_modification_{foot}"]).max() > 1e-5
            assert not swap.signals[f"task_modification_{foot}"].any()


def test_with_a_system_of_drakes_the_diagram_runs():
    """It does the same, but for the fused engine, which knows blocks alone."""
    scenario = load_scenario("stand", SHORT)
    run = start(scenario, {"imu_stabilizer": System()})
    assert run.fused is None
    run.advance(scenario.duration)
    expected = simulate(scenario, blocks={"imu_stabilizer": PassOn}, engine="diagram")
    for name, values in run.result(0.0).signals.items():
        assert np.array_equal(values, expected.signals[name]), name


def test_servos_without_a_bus_run_in_the_diagram():
    class NoBus(Block):
        @law
        def joint_desired_state(joint_command):
            return joint_command[:48]

        @law
        def joint_feedforward(joint_command):
            return joint_command[48:]

    scenario = load_scenario("stand", SHORT)
    run = start(scenario, {"joint_servos": NoBus}, "fused")
    assert run.fused is None
    run.advance(scenario.duration)
    assert not run.fallen
    assert np.array_equal(run.signal("joint_desired_state"), run.signal("joint_command")[:48])


def test_what_declares_no_law_is_not_fused():
    scenario = Scenario()
    world = make_world(scenario, {"imu_stabilizer": System()})
    with pytest.raises(BlockError, match="^imu_stabilizer: without a declared law"):
        build_fused(world, scenario)
