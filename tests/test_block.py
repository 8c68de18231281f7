"""What a block declares: what its arguments mean, and what is said if they mean nothing."""

from dataclasses import dataclass

import numpy as np
import pytest
import yaml
from pydrake.common.value import Value
from ticking import Ticking

from lola_drake.block import Argument, Block, BlockError, Part, Reading, State, law
from lola_drake.block_system import BlockSystem, gain_of, set_gain
from lola_drake.blocks.com_dynamics import ComDynamics, ComDynamicsParams
from lola_drake.parameters import parameter
from lola_drake.signals import (
    CONTACT,
    GAIT_PHASE,
    MEASURED_WRENCH,
    PERIOD,
    TASK_MODIFICATION,
    TASK_REFERENCE,
    Field,
    Signal,
)
from lola_drake.theory.noise import Noise

LEVEL = Signal("level", "What has come in until now.", (Field("sum", ("",), "-"),))
DOUBLE = Signal("double_level", "Twice that.", (Field("sum", ("",), "-"),))


@dataclass(frozen=True)
class TankParams:
    """The parameters of a tank."""

    inflow: float = parameter(
        2.0, "what comes in", "1/s", minimum=0, maximum=5, symbol="k", slider=(0, 5, 0.1)
    )
    leak: float = parameter(0.5, "what goes out", "1/s", minimum=0, maximum=5)
    capacity: float = parameter(9.0, "its end", "-", minimum=1, maximum=20, slider=(1, 20, 1))

    @property
    def half(self) -> float:
        """Return half of what comes in."""
        return 0.5 * self.inflow


class Tank(Block):
    """A tank that is filled from one foot's switches."""

    Params = TankParams
    state = (State(LEVEL, hidden=True), TASK_MODIFICATION)
    signals = (LEVEL, DOUBLE)
    parts = {
        "pads": Part(CONTACT, "pads"),
        "blend": Part(GAIT_PHASE, "blend"),
        "force": Part(MEASURED_WRENCH, ("F", "T")),
        "toes": Part(TASK_REFERENCE, "toes"),
    }
    objects = {"things": Reading("thing_port", Value[object], 2)}

    def read_things(self, thing):
        """Return two numbers of it."""
        return [len(thing), 1.0]

    @law
    def contact_wrench(double_level, level, inflow, half, leak, size, foot, time, hiss):
        """Return what is in it."""
        return (double_level[0] + level[0], inflow + half + leak, size + foot + time + hiss[0])

    @law
    def double_level(level):
        """Return twice the level."""
        return (2 * level[0],)

    @law
    def next_level(level, pads, blend, force, toes, things, com_dynamics_rate, capacity):
        """Fill it."""
        return (min(level[0] + pads[0] + blend + force[5] + toes + things[0], capacity),)

    @law
    def next_task_modification(task_modification):
        """Leave it."""
        return task_modification


CONSTANTS = {"size": 3.0, "hiss": Noise(np.ones(1), 0, 1)}


def tank(foot="r", **changes):
    return Tank(TankParams(), foot, **(CONSTANTS | changes))


def block_of(*laws, name="Odd", **declared):
    """Return a class of blocks with these laws."""
    return type(name, (Block,), declared | {f.__name__: law(f) for f in laws})


def message(cls, *args, **kwargs):
    """Return what is said when a block is created; it is one line."""
    with pytest.raises(BlockError) as caught:
        cls(*args, **kwargs)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_each_name_says_where_an_argument_comes_from():
    arguments = dict(
        zip(("double_level", "level"), tank().arguments["contact_wrench"], strict=False)
    )
    assert arguments == {
        "double_level": Argument("output", "double_level"),
        "level": Argument("state", "level"),
    }
    assert tank().arguments["contact_wrench"][2:] == (
        Argument("gain", "inflow"),
        Argument("constant", "half"),
        Argument("constant", "leak"),
        Argument("constant", "size"),
        Argument("constant", "foot"),
        Argument("time", "time"),
        Argument("noise", "hiss"),
    )
    assert tank().arguments["next_level"][5:] == (
        Argument("object", "things"),
        Argument("input", "com_dynamics_rate"),
        Argument("gain", "capacity"),
    )


@pytest.mark.parametrize(
    ("foot", "pads", "blend", "force", "toes"),
    [
        ("l", slice(0, 4), 4, slice(0, 6), 12),
        ("r", slice(4, 8), 5, slice(6, 12), 13),
        ("", None, slice(4, 6), None, slice(12, 14)),
    ],
)
def test_parts_are_those_of_the_blocks_own_foot(foot, pads, blend, force, toes):
    parts = {"blend": Tank.parts["blend"], "toes": Tank.parts["toes"]}
    if foot:
        parts = Tank.parts
    found = {name: part.where(foot) for name, part in parts.items()}
    expected = {"pads": pads, "blend": blend, "force": force, "toes": toes}
    assert found == {name: expected[name] for name in parts}


def test_a_part_that_is_a_single_number_is_one():
    one = block_of(lambda_of("x"), parts={"x": Part(GAIT_PHASE, "step_index")}, signals=(LEVEL,))
    assert one().arguments["level"] == (Argument("input", "gait_phase", 6),)


def lambda_of(*names):
    """Return a law `level` with arguments of these names."""
    space = {}
    exec(f"def level({', '.join(names)}): return (0.0,)", space)
    return space["level"]


def test_a_part_may_be_several_fields_in_a_row():
    assert Part(GAIT_PHASE, ("support", "blend")).where("") == slice(0, 6)


def test_a_field_that_is_none_is_an_error():
    with pytest.raises(KeyError, match="gait_phase has no field 'colour'"):
        Part(GAIT_PHASE, "colour").where("l")


def test_gains_are_the_parameters_with_a_slider():
    assert list(tank().gains) == ["inflow", "capacity"]
    assert tank().gains["inflow"].metadata["symbol"] == "k"


def test_ports_are_in_the_order_of_the_declaration():
    assert list(tank().outputs) == ["contact_wrench", "double_level", "task_modification"]
    assert list(tank().inputs) == [
        "contact",
        "gait_phase",
        "measured_wrench",
        "task_reference",
        "thing_port",
        "com_dynamics_rate",
    ]
    system = BlockSystem(tank())
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
    assert (inputs, outputs) == (list(tank().inputs), list(tank().outputs))


def test_the_card_stands_at_the_end_of_the_docstring():
    told, card = Tank.__doc__.split("\n\n.. pydrake_system::\n")
    assert told == "A tank that is filled from one foot's switches."
    assert yaml.safe_load(card) == {
        "name": "Tank",
        "input_ports": list(tank().inputs),
        "output_ports": list(tank().outputs),
    }


def test_a_block_without_inputs_has_none_on_its_card():
    card = yaml.safe_load(block_of(lambda_of(), signals=(LEVEL,)).__doc__.split("::\n")[1])
    assert card == {"name": "Odd", "output_ports": ["level"]}


def test_constants_are_given_or_parameters_or_made_of_them():
    assert [tank().constant(name) for name in ("size", "leak", "half")] == [3.0, 0.5, 1.0]
    assert [tank(foot).constant("foot") for foot in "lr"] == [0, 1]


def test_the_state_begins_with_zero_unless_it_is_told():
    block = Tank(TankParams(), "l", initial={"level": [4.0]}, **CONSTANTS)
    assert block.initial["level"] == [4.0]
    assert np.array_equal(block.initial["task_modification"], np.zeros(3))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"foot": "x"}, "Tank: foot: 'x' is not allowed, it must be 'l' or 'r', or '' for none"),
        ({"foot": ["l"]}, "is not allowed, it must be 'l' or 'r'"),
        ({"initial": 5}, "Tank: initial: 5 is no mapping of the parts: "),
        ({"initial": {"levl": [1.0]}}, "Tank: initial: no part 'levl', there are: "),
        ({"initial": {"task_modification": [1.0]}}, "is not allowed, it must be 3 numbers"),
        ({"initial": {"level": 4.0}}, "initial['level']: 4.0 is not allowed, it must be 1 numbers"),
        ({"initial": {"level": "full"}}, "initial['level']: 'full' is not allowed"),
        ({"initial": {"level": [float("nan")]}}, "initial['level']: [nan] is not allowed"),
        ({"initial": {"level": [None, [1]]}}, "it must be 1 numbers"),
    ],
)
def test_a_foot_and_a_start_that_cannot_be_are_one_line(arguments, message):
    with pytest.raises(BlockError) as caught:
        Tank(TankParams(), **({"foot": "l"} | arguments), **CONSTANTS)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_the_system_does_what_the_laws_say():
    running = Ticking(tank("r"))
    running.fix("contact", np.arange(8.0))
    running.fix("gait_phase", [0, 0, 0, 0, 0.25, 0.5, 0, 0])
    running.fix("measured_wrench", np.arange(12.0) / 100)
    running.fix("task_reference", np.arange(28.0) / 1000)
    running.system.GetInputPort("thing_port").FixValue(running.context, Value[object]([7, 7]))
    running.step()
    level = 4.0 + 0.5 + 0.11 + 0.013 + 2.0
    assert running.state("level") == pytest.approx([level])
    assert running.output("double_level") == pytest.approx([2 * level])
    hiss = CONSTANTS["hiss"](1)[0]
    expected = [3 * level, 2.0 + 1.0 + 0.5, 3.0 + 1.0 + PERIOD + hiss]
    assert running.output("contact_wrench") == pytest.approx(expected)
    running.step()
    assert running.state("level") == [9.0]  # its capacity


def test_a_gain_that_is_turned_acts_at_once():
    running = Ticking(tank())
    assert gain_of(running.system, running.context, "inflow") == 2.0
    before = running.output("contact_wrench")
    set_gain(running.system, running.context, "inflow", 3.5)
    assert gain_of(running.system, running.context, "inflow") == 3.5
    # Only the gain has changed, not what is made of the parameter.
    assert running.output("contact_wrench") - before == pytest.approx([0.0, 1.5, 0.0])


def test_gains_of_two_contexts_are_their_own():
    system = BlockSystem(tank())
    one, other = system.CreateDefaultContext(), system.CreateDefaultContext()
    set_gain(system, one, "capacity", 5.0)
    assert (gain_of(system, one, "capacity"), gain_of(system, other, "capacity")) == (5.0, 9.0)


def test_an_unknown_argument_is_named():
    said = message(block_of(lambda_of("gait_phase", "gait_phas"), signals=(LEVEL,)))
    expected = "argument 'gait_phas' is no signal, state, gain or constant of the block"
    assert said == f"Odd.level: its {expected}"


def test_a_constant_that_is_not_given_is_named():
    assert "Tank.contact_wrench: its argument 'size'" in message(
        Tank, TankParams(), "l", hiss=CONSTANTS["hiss"]
    )


def test_parameters_that_are_not_given_are_named():
    assert "'inflow'" in message(Tank, None, "l", **CONSTANTS)


@pytest.mark.parametrize(("field", "foot"), [("colour", "l"), ("pads", ""), ("pads_", "l")])
def test_a_part_that_is_none_is_named(field, foot):
    wrong = block_of(lambda_of("x"), parts={"x": Part(CONTACT, field)}, signals=(LEVEL,))
    assert message(wrong, foot=foot) == f"Odd.x: contact has no field {field!r}"


def test_an_argument_of_a_step_in_python_is_checked_too():
    class Stepping(Block):
        state = (CONTACT,)

        def next_state(self, contact, other):
            """Return the next state."""
            return (contact,)

    assert message(Stepping).startswith("Stepping.next_state: its argument 'other' is no signal")
    given = Stepping(other=1.0)
    assert given.arguments["next_state"] == (
        Argument("state", "contact"),
        Argument("constant", "other"),
    )


def test_an_output_that_is_no_signal_is_named():
    def colour():
        return (1.0,)

    assert message(block_of(colour)) == "Odd: no signal is called 'colour'"


def test_a_state_without_a_law_is_named():
    assert message(block_of(state=(CONTACT,))) == "Odd.next_contact: no law gives it"


def test_the_next_value_of_no_state_is_named():
    def next_contct(contact):
        return contact

    def next_contact(contact):
        return contact

    wrong = block_of(next_contact, next_contct, state=(CONTACT,))
    assert message(wrong) == "Odd.next_contct: it has no such state"


def test_the_next_state_is_no_argument():
    def next_contact(contact):
        return contact

    def contact_wrench(next_contact):
        return (0.0, 0.0, 0.0)

    wrong = block_of(contact_wrench, next_contact, state=(CONTACT,))
    assert "Odd.contact_wrench: its argument 'next_contact' is no signal" in message(wrong)


def test_outputs_that_wait_for_one_another_are_named():
    def contact_wrench(double_level):
        return (0.0, 0.0, 0.0)

    def double_level(contact_wrench):
        return (0.0,)

    wrong = block_of(contact_wrench, double_level, lambda_of(), signals=(LEVEL, DOUBLE))
    expected = "these outputs wait for one another: contact_wrench, double_level"
    assert message(wrong) == f"Odd: {expected}"


def test_laws_are_inherited_and_may_be_replaced():
    class Fuller(Tank):
        """Twice as full."""

        @law
        def double_level(level, size):
            return (4 * level[0] + size,)

    block = Fuller(TankParams(), "l", **CONSTANTS)
    assert list(block.outputs) == list(tank().outputs)
    assert block.laws["double_level"]([1.0], 3.0) == (7.0,)
    assert Tank.laws["double_level"]([1.0]) == (2.0,)
    assert Fuller.__doc__.startswith("Twice as full.")


def test_in_place_of_another_it_knows_what_that_one_knows():
    class Other(Block):
        """Shares a part of the state, the foot and a constant."""

        Params = TankParams
        state = (TASK_MODIFICATION,)

        @law
        def next_task_modification(task_modification, size, foot, leak):
            return (size, foot, leak)

    start = {"task_modification": [0.1, 0.2, 0.3], "level": [1.0]}
    params = TankParams(leak=0.7)
    other = Other.in_place_of(Tank(params, "r", initial=start, **CONSTANTS))
    assert (other.foot, other.constant("size"), other.params) == ("r", 3.0, params)
    assert other.initial.keys() == {"task_modification"}
    assert np.array_equal(other.initial["task_modification"], [0.1, 0.2, 0.3])


def test_in_place_of_another_it_has_parameters_of_its_own_class():
    class Other(Block):
        Params = ComDynamicsParams

        @law
        def contact_wrench(gain, size):
            return (gain, size, 0.0)

    other = Other.in_place_of(tank())
    assert other.params == ComDynamicsParams()
    assert list(other.gains) == ["gain", "decay_gain"]


def test_in_place_of_another_without_a_class_of_parameters_it_has_those():
    class Other(Block):
        @law
        def contact_wrench(inflow, leak):
            return (inflow, leak, 0.0)

    assert Other.in_place_of(tank()).params == TankParams()


def test_in_place_of_a_block_that_lacks_something_it_is_an_error():
    class Other(Block):
        @law
        def contact_wrench(colour):
            return (colour, 0.0, 0.0)

    with pytest.raises(BlockError, match="Other.contact_wrench: its argument 'colour' is no"):
        Other.in_place_of(tank())


def test_a_block_of_one_foot_has_that_foots_ports():
    constants = {"inertia": np.ones(3), "modification_limits": np.ones(3)}
    left, right = (ComDynamics(ComDynamicsParams(), foot, **constants) for foot in "lr")
    assert list(left.inputs) == list(right.inputs)
    where = [block.arguments["next_com_dynamics_rate"][1].where for block in (left, right)]
    assert where == [slice(0, 3), slice(3, 6)]
