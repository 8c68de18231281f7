"""Every block's laws: as plain Python, as machine code, and on AutoDiffXd."""

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff

from lola_drake.block_system import BlockSystem, machine_value, plain_value, sample_arguments
from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.blocks.hybrid_force_control import HybridForceControlParams
from lola_drake.compiled import compiled, compiling
from lola_drake.scenario import PREDECESSOR, Control, Scenario
from lola_drake.simulation import make_world

CONVERTIBLE = {
    "imu_stabilizer",
    "force_distribution",
    "force_control_l",
    "force_control_r",
    "com_dynamics_l",
    "com_dynamics_r",
}
RIVALS = ("damping", "second_order", "two_dof")
CONVERTIBLE |= {f"{law}.force_control_{foot}" for law in RIVALS for foot in "lr"}
"""Blocks of plain algebra, which Drake can differentiate."""


def all_blocks():
    """Return every block by its name; those of the rival force laws as `law.force_control_l`."""
    world = make_world(Scenario())
    found = world.sensors | world.controller
    for name in FORCE_LAWS:
        rivals = make_world(Scenario(control=Control(law=name))).controller
        for key, block in rivals.items():
            if type(block) is FORCE_LAWS[name]:
                found[key if name in ("hybrid", PREDECESSOR) else f"{name}.{key}"] = block
    switches = HybridForceControlParams(sensed_area=True, exact_angles=True)
    sensed = make_world(Scenario(control=Control(force=switches))).controller
    return found | {f"sensed.{n}": sensed[n] for n in ("force_control_l", "force_control_r")}


BLOCKS = all_blocks()
LAWS = [(name, law) for name, block in BLOCKS.items() for law in block.laws]
EVERY_LAW = pytest.mark.parametrize(("name", "law"), LAWS, ids=[".".join(law) for law in LAWS])
EVERY_CONVERTIBLE = pytest.mark.parametrize("name", sorted(CONVERTIBLE))


def size_of(block, argument):
    """Return how many numbers an argument is; None for a single one."""
    kind, name, where = argument
    if kind in ("gain", "time") or isinstance(where, int):
        return None
    if kind == "state":
        return len(block.initial[name])
    if kind == "object":
        return block.objects[name].size
    if kind == "noise":
        return block.constant(name).size
    size = block.signal(name).size
    return len(range(size)[where]) if where is not None else size


def random_arguments(block, law, seed):
    """Return what the law may get, as machine code takes it; some is far out of proportion."""
    random = np.random.default_rng(seed)
    scale, values = 10.0 ** random.uniform(-2, 2), []
    for argument in block.arguments[law]:
        if argument.kind == "constant":
            values.append(machine_value(block.constant(argument.name)))
        elif argument.kind == "gain":
            values.append(getattr(block.params, argument.name) * float(random.uniform(0.5, 1.5)))
        else:
            size = size_of(block, argument)
            values.append(
                float(scale * random.normal()) if size is None else scale * random.normal(size=size)
            )
    return values


@pytest.mark.skipif(not compiling(), reason="laws are not compiled here")
@EVERY_LAW
def test_machine_code_gives_the_same_bits(name, law):
    block = BLOCKS[name]
    plain = block.laws[law]
    machine = compiled(plain, sample_arguments(block, law))
    for seed in range(10):
        values = random_arguments(block, law, seed)
        expected = np.array(plain(*map(plain_value, values)), dtype=float)
        np.testing.assert_array_equal(np.array(machine(*values)), expected, strict=True)
        arrays = np.array(plain(*values), dtype=float)
        np.testing.assert_array_equal(arrays, expected, err_msg="arrays instead of lists")


@EVERY_LAW
def test_a_law_gives_as_many_numbers_as_its_signal_has(name, law):
    block = BLOCKS[name]
    step = law.removeprefix("next_")
    size = len(block.initial[step]) if law.startswith("next_") else block.signal(law).size
    assert len(block.laws[law](*random_arguments(block, law, 0))) == size


@EVERY_LAW
def test_a_law_leaves_its_arguments_alone(name, law):
    block = BLOCKS[name]
    values, kept = (random_arguments(block, law, 0) for _ in range(2))
    first = np.array(block.laws[law](*values), dtype=float)
    assert [plain_value(value) for value in values] == [plain_value(value) for value in kept]
    assert np.array_equal(np.array(block.laws[law](*values), dtype=float), first)


@pytest.mark.parametrize("name", BLOCKS)
def test_blocks_of_plain_algebra_can_be_differentiated(name):
    assert (BlockSystem(BLOCKS[name]).ToAutoDiffXdMaybe() is not None) == (name in CONVERTIBLE)


@pytest.mark.parametrize(
    ("name", "law"), [(name, law) for name, law in LAWS if name in CONVERTIBLE]
)
def test_derivatives_of_a_law_are_its_difference_quotients(name, law):
    """Along a direction in all that is no constant, gains as well."""
    block = BLOCKS[name]
    function, values = block.laws[law], random_arguments(block, law, 3)
    free = [i for i, argument in enumerate(block.arguments[law]) if argument.kind != "constant"]
    random, step = np.random.default_rng(4), 1e-6
    direction = {i: random.normal(size=np.shape(values[i])) * np.abs(values[i]) for i in free}

    def at(distance):
        return [v + distance * direction[i] if i in direction else v for i, v in enumerate(values)]

    def of(arguments):
        return np.array(function(*map(plain_value, arguments)), dtype=float)

    quotient = (of(at(step)) - of(at(-step))) / (2 * step)
    dual = [
        on_autodiff(v, direction[i]) if i in direction else plain_value(v)
        for i, v in enumerate(values)
    ]
    # A result that nothing reaches may be a plain number.
    found = np.array(function(*dual)) + AutoDiffXd(0.0, [0.0])
    np.testing.assert_allclose(ExtractValue(found)[:, 0], of(values), rtol=1e-14)
    np.testing.assert_allclose(
        ExtractGradient(found)[:, 0], quotient, rtol=1e-5, atol=1e-7 * np.abs(quotient).max()
    )


def on_autodiff(value, slope):
    """Return a value, as a list unless it is a number, that moves with this slope."""
    if np.ndim(value) == 0:
        return AutoDiffXd(float(value), [float(slope)])
    return InitializeAutoDiff(value[:, None], slope[:, None])[:, 0].tolist()


@EVERY_CONVERTIBLE
def test_its_system_on_autodiff_gives_the_same_outputs_and_next_state(name):
    block = BLOCKS[name]
    system = BlockSystem(block)
    dual = system.ToAutoDiffXd()
    contexts = system.CreateDefaultContext(), dual.CreateDefaultContext()
    random = np.random.default_rng(5)
    for i in range(system.num_input_ports()):
        value = random.normal(size=system.get_input_port(i).size())
        system.get_input_port(i).FixValue(contexts[0], value)
        dual.get_input_port(i).FixValue(contexts[1], InitializeAutoDiff(value[:, None])[:, 0])
    for i in range(system.num_output_ports()):
        expected = system.get_output_port(i).Eval(contexts[0])
        found = ExtractValue(dual.get_output_port(i).Eval(contexts[1]))[:, 0]
        np.testing.assert_allclose(found, expected, rtol=1e-14)
    if block.states:
        one, two = (
            s.EvalUniquePeriodicDiscreteUpdate(c)
            for s, c in zip((system, dual), contexts, strict=True)
        )
        for i in range(one.num_groups()):
            found = ExtractValue(two.get_vector(i).CopyToVector())[:, 0]
            np.testing.assert_allclose(found, one.get_vector(i).CopyToVector(), rtol=1e-14)


@EVERY_CONVERTIBLE
def test_its_gains_are_parameters_on_autodiff_too(name):
    system = BlockSystem(BLOCKS[name])
    dual = system.ToAutoDiffXd()
    context = dual.CreateDefaultContext()
    assert dual.gain_index.keys() == BLOCKS[name].gains.keys()
    for gain, index in dual.gain_index.items():
        value = context.get_numeric_parameter(index).GetAtIndex(0).value()
        assert value == getattr(BLOCKS[name].params, gain)
