"""All laws in one system: in which order, with which gains, as machine code or as Python."""

import numpy as np
import pytest

from lola_drake import fused as fused_module
from lola_drake.block import Block, BlockError, Part, State, law
from lola_drake.controller import WalkingController
from lola_drake.fused import FusedSystem
from lola_drake.fused_layout import Layout
from lola_drake.scenario import (
    VARIANTS,
    Scenario,
)
from lola_drake.signals import GAIT_PHASE, PERIOD, Field, Signal, signal_of, split_foot
from lola_drake.simulation import make_world
from lola_drake.theory.kinematics import KinematicTree
from lola_drake.theory.noise import Noise


def number(name, size=1):
    return Signal(name, "Made up.", (Field("n", tuple(map(str, range(size))), "-"),))


WATER, HEAT, STEAM, SHARE = number("water", 2), number("heat"), number("steam", 2), number("share")
KNOWN = {"signals": (WATER, HEAT, STEAM, SHARE), "differentiable": False}


def made(name, **declared):
    """Return a class of blocks that know all signals here."""
    return type(name, (Block,), KNOWN | declared)


class Steam:
    """Laws that are read by others, in an order in which none stands where it can run."""

    def steam(water, heat, table, time):
        return (water[0] * heat[0] + table[0][1], water[1] + time)

    def heat(water, load, noise, walk_command):
        return (water[0] + load[1] + noise[0] + walk_command[2],)

    def share(steam):
        return (0.5 * steam[0],)

    def next_water(water, share, steam):
        return (water[0] + 0.1 * share[0], steam[0] - water[1])


LOAD = {"load": Part(GAIT_PHASE, "load")}
CONSTANTS = {"table": np.array([[1.0, 2.0], [3.0, 4.0]]), "noise": Noise(np.ones(1), 3, 1)}


def boiler():
    """Return blocks by name: a state, outputs that read one another, and both kinds of feet."""
    tank = made("Tank", state=(State(WATER),), next_water=law(Steam.next_water))
    boiling = made("Boiling", steam=law(Steam.steam))
    heating = made("Heating", heat=law(Steam.heat), parts=LOAD)
    sharing = made("Sharing", share=law(Steam.share))
    return {
        "boiling": boiling(table=CONSTANTS["table"]),
        "tank": tank(initial={"water": [0.5, 0.25]}),
        "sharing": sharing(),
        "heating": heating(noise=CONSTANTS["noise"]),
    }


INPUTS = {"gait_phase": np.arange(8.0) / 10, "walk_command": np.array([1.0, 2.0, 3.0])}


class Ticks:
    """A system that is stepped tick by tick; inputs change with the ticks."""

    def __init__(self, system):
        self.system, self.context, self.ticks = system, system.CreateDefaultContext(), 0
        self.feed()

    def feed(self):
        for name, value in INPUTS.items():
            self.system.GetInputPort(name).FixValue(self.context, value * (1 + self.ticks))

    def step(self):
        update = self.system.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(update)
        self.ticks += 1
        self.context.SetTime(PERIOD * self.ticks)
        self.feed()

    def signal(self, name):
        if isinstance(self.system, FusedSystem):
            row = self.system.GetOutputPort("tick").Eval(self.context)
            return row[self.system.layout.signals[name]].copy()
        return self.system.GetOutputPort(name).Eval(self.context).copy()


def assert_same(blocks, names, ticks=5):
    """Check that fused blocks, in machine code and without, do what a diagram of them does."""
    systems = [
        Ticks(WalkingController(blocks)),
        Ticks(FusedSystem(blocks)),
        Ticks(FusedSystem(blocks, compile_laws=False)),
    ]
    for _ in range(ticks):
        for name in names:
            expected, *found = (system.signal(name) for system in systems)
            assert np.isfinite(expected).all()
            for values in found:
                np.testing.assert_array_equal(values, expected, err_msg=name)
        for system in systems:
            system.step()
    return systems[1].system


def test_made_up_blocks_do_the_same_in_every_way():
    fused = assert_same(boiler(), ("water", "steam", "heat", "share"))
    assert len(fused._programs) == 1, "all is machine code"


def test_each_law_runs_after_those_whose_output_it_reads():
    calls = [call.name for call in Layout(boiler()).calls]
    assert calls == ["heat", "steam", "share", "next_water"]


@pytest.mark.parametrize("variant", VARIANTS)
def test_each_law_of_a_controller_finds_what_it_reads(variant):
    world = make_world(Scenario(variant=variant))
    layout = Layout(world.sensors | world.controller)
    written = np.zeros(layout.start.size, dtype=bool)
    written[layout.states] = True
    for where in layout.inputs.values():
        written[where] = True
    for call in layout.calls:
        for place in call.arguments:
            if place.value is None:
                inside = np.arange(layout.start.size)[place.where]
                assert np.all(written[inside] | (inside >= layout.row.stop)), call.name
        for where in call.results:
            assert not written[where].any(), "nothing is written twice, and no state in a tick"
            written[where] = True
    assert written[layout.row].all() and written[layout.following].all()
    assert [call.name for call in layout.calls][-1] == "next_state", "plain Python runs last"


def test_the_vector_begins_with_the_state_hidden_parts_first():
    world = make_world(Scenario())
    layout = Layout(world.sensors | world.controller)
    hidden = {
        (name, part)
        for name, block in layout.blocks.items()
        for part, state in block.states.items()
        if state.hidden
    }
    assert layout.states.start == layout.row.start == 0
    for key, at in layout.state.items():
        assert (at.stop <= layout.visible.start) == (key in hidden)
        block, part = key
        assert np.array_equal(layout.start[at], layout.blocks[block].initial[part])
    own = {signal.name: signal for block in layout.blocks.values() for signal in block.signals}
    for name, at in layout.signals.items():
        signal = signal_of(name) or own[split_foot(name)[0]]
        assert at.stop - at.start == signal.size


def test_gains_begin_with_the_parameters():
    world = make_world(Scenario())
    layout = Layout(world.sensors | world.controller)
    for (name, gain), at in layout.gains.items():
        assert layout.start[at] == getattr(layout.blocks[name].params, gain)
        assert layout.turned.start + layout.gain_index(name, gain) == at
    assert len(layout.gains) == 4 + 2 * 2 + 2 * 2


def test_equal_constants_stand_in_the_vectors_once():
    """Arrays of numbers in one, integers in the other; named tuples field by field."""
    world = make_world(Scenario())
    layout = Layout(world.sensors | world.controller)
    trees = {
        id(place)
        for call in layout.calls
        for place in call.arguments
        if isinstance(place.value, KinematicTree)
    }
    assert len(trees) == 1, "one tree for sensors and controller"
    places = [place for call in layout.calls for place in call.arguments if place.parts]
    for place in places:
        for part, value in zip(place.parts, place.value, strict=True):
            vector = {"v": layout.start, "n": layout.integers}[part.vector]
            assert np.array_equal(vector[part.where].reshape(part.shape), value)


def test_signals_that_wait_for_one_another_are_named():
    blocks = boiler()
    blocks["sharing"] = made("Sharing", share=law(lambda heat: heat))()
    blocks["heating"] = made("Heating", heat=law(lambda share: share))()
    with pytest.raises(BlockError) as caught:
        FusedSystem(blocks)
    assert str(caught.value) == "these signals wait for one another: share, heat"


def in_python_alone(steam):
    import math

    return (math.fsum([steam[0], 1.0]),)


def of_mixed_kinds(water, share):
    return (1, water[1] + share[0])


def a_closure():
    half = 0.5
    return lambda steam: (half * steam[0],)


@pytest.mark.parametrize("share", [in_python_alone, a_closure()])
def test_a_law_that_numba_does_not_know_runs_as_python(share):
    blocks = boiler() | {"sharing": made("Sharing", share=law(share))()}
    fused = assert_same(blocks, ("water", "steam", "heat", "share"))
    assert len(fused._programs) == 3, "machine code, Python, machine code"


def test_that_laws_are_compiled_is_said_once(monkeypatch, capsys):
    monkeypatch.delenv("LOLA_COMPILE", raising=False)
    monkeypatch.setattr(fused_module, "is_kept", lambda function: False)
    fused_module._say_compiling.cache_clear()
    # Tried as a whole, then law by law, then in parts; and once more for another system.
    blocks = boiler() | {"sharing": made("Sharing", share=law(in_python_alone))()}
    for _ in range(2):
        FusedSystem(blocks)
    assert capsys.readouterr().err == f"{fused_module.COMPILING}\n"


def test_a_law_that_gives_numbers_of_mixed_kinds_runs_as_python():
    tank = made("Tank", state=(State(WATER),), next_water=law(of_mixed_kinds))
    fused = assert_same(boiler() | {"tank": tank()}, ("water", "steam", "heat", "share"))
    assert len(fused._programs) == 2


def too_few(share):
    return (share[0],)


def no_row(share):
    return share[0]


@pytest.mark.parametrize("step", [too_few, no_row])
def test_a_law_that_gives_too_few_numbers_is_named(step):
    """Nothing is filled up, in whatever way it runs."""
    tank = made("Tank", state=(State(WATER),), next_water=law(step))
    blocks = boiler() | {"tank": tank()}
    for system in (
        WalkingController(blocks),
        FusedSystem(blocks),
        FusedSystem(blocks, compile_laws=False),
    ):
        with pytest.raises(ValueError, match="next_water gives (too|1|no row of)") as caught:
            Ticks(system).step()
        assert "\n" not in str(caught.value)


def test_a_step_in_python_that_gives_too_few_numbers_is_named():
    class Stepping(Block):
        signals = KNOWN["signals"]
        state = (State(WATER),)

        def next_state(self, water):
            """Forget one of both."""
            return water[:1]

    blocks = boiler() | {"tank": Stepping()}
    for system in (WalkingController(blocks), FusedSystem(blocks)):
        with pytest.raises(ValueError, match="next_state gives 1 numbers, it must give 2"):
            Ticks(system).step()


def test_a_block_that_steps_in_python_runs_last():
    class Stepping(Block):
        signals = KNOWN["signals"]
        state = (State(WATER), State(number("counted"), hidden=True))

        def next_state(self, water, counted, steam, time):
            """Return both parts."""
            return np.concatenate([water + steam[0] + counted, counted + 1.0 + time])

    fused = assert_same(boiler() | {"tank": Stepping()}, ("water", "steam", "heat", "share"))
    assert [call.name for call in fused.layout.calls][-1] == "next_state"
    assert len(fused._programs) == 2
