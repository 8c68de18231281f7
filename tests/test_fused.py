"""All laws in one system: it does the same as the diagram of blocks, bit for bit."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from lola_drake import fused as fused_module
from lola_drake.block import Block, BlockError, Part, State, law
from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.controller import WalkingController
from lola_drake.fused import FusedSystem
from lola_drake.fused_layout import Layout
from lola_drake.scenario import (
    PREDECESSOR,
    VARIANTS,
    Scenario,
    load_scenario,
    override,
    scenario_paths,
)
from lola_drake.signals import GAIT_PHASE, PERIOD, Field, Signal, signal_of, split_foot
from lola_drake.simulation import ENGINES, make_world, start
from lola_drake.theory.kinematics import KinematicTree
from lola_drake.theory.noise import Noise

AT_ONCE = {"walk.start_time": 0.0, "pattern.first_double_support": 0.2, "duration": 0.35}
"""The first foot lifts off at 0.2 s."""


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


def run_of(scenario, engine="fused", until=None, **kwargs):
    run = start(scenario, engine=engine, limited=True, **kwargs)
    run.advance(scenario.duration if until is None else until)
    return run


def assert_equal(one, other):
    """Check that two runs have recorded the same bits."""
    one, other = one.result(0.0), other.result(0.0)
    assert np.array_equal(one.times, other.times)
    assert one.signals.keys() == other.signals.keys()
    for name, values in one.signals.items():
        np.testing.assert_array_equal(values, other.signals[name], err_msg=name)


def assert_engines_equal(scenario):
    runs = [run_of(scenario, engine) for engine in ENGINES]
    assert [run.fused is not None for run in runs] == [engine == "fused" for engine in ENGINES]
    assert_equal(*runs)
    return runs


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("name", scenario_paths())
def test_every_scenario_runs_the_same_in_both_engines(name, variant):
    scenario = load_scenario(name, AT_ONCE | {"variant": variant})
    run, _ = assert_engines_equal(scenario)
    signals = run.result(0.0).signals
    if scenario.walk.steps:
        assert not signals["gait_phase"][-1, GAIT_PHASE.slice("support")].all(), "a foot swings"
    assert np.ptp(signals["joint_torque"], axis=0).max() > 1.0


SENSED = {"control.force.sensed_area": True, "control.force.exact_angles": True}


HELD = {"control.inverse_kinematics.horizontal_feedforward": 1.0}


@pytest.mark.parametrize(
    "kind", [*({"control.law": law} for law in FORCE_LAWS), SENSED, HELD], ids=str
)
def test_every_force_law_runs_the_same_in_both_engines(kind):
    assert_engines_equal(load_scenario("walk_flat", AT_ONCE | kind))


def test_variants_and_laws_are_not_the_same():
    kinds = [("variant", v) for v in VARIANTS] + [("control.law", law) for law in FORCE_LAWS]
    last = {
        run_of(load_scenario("walk_flat", AT_ONCE | {key: v})).signal("joint_command").tobytes()
        for key, v in kinds
    }
    assert len(last) == len(kinds) - 1, "dyn has the law hybrid"


def test_the_variant_original_is_the_law_of_the_configuration_space_without_com_dynamics():
    kinds = {"control.law": PREDECESSOR, "variant": "ref"}, {"variant": "original"}
    assert_equal(*(run_of(load_scenario("walk_flat", AT_ONCE | kind)) for kind in kinds))


def test_machine_code_and_python_run_the_same():
    scenario = load_scenario("walk_flat", AT_ONCE | {"duration": 0.1})
    machine, python = (run_of(scenario, compile_laws=switch) for switch in (True, False))
    assert len(machine.fused._programs) < len(python.fused._programs)
    assert_equal(machine, python)


@pytest.mark.parametrize("switch", ["0", "1"])
def test_the_diagram_runs_the_same_without_machine_code(monkeypatch, switch):
    scenario = load_scenario("stand", {"duration": 0.05})
    monkeypatch.setenv("LOLA_COMPILE", switch)
    runs = [run_of(scenario, engine) for engine in ENGINES]
    assert (len(runs[0].fused._programs) > 10) == (switch == "0")
    monkeypatch.delenv("LOLA_COMPILE")
    runs.append(run_of(scenario))
    for run in runs[:2]:
        assert_equal(run, runs[2])


@pytest.mark.parametrize(
    "delays",
    [
        {"sensors.imu.delay_ticks": 1, "control.servos.delay_ticks": 4},
        {"sensors.imu.delay_ticks": 9},
        {"sensors.ideal": True, "control.servos.delay_ticks": 2},
    ],
)
def test_other_delays_run_the_same_in_both_engines(delays):
    usual = run_of(load_scenario("walk_flat", AT_ONCE))
    other, _ = assert_engines_equal(load_scenario("walk_flat", AT_ONCE | delays))
    assert not np.array_equal(usual.signal("joint_command"), other.signal("joint_command"))


def test_pushes_and_faults_run_the_same_in_both_engines():
    disturbed = {
        "pushes": [{"time": 0.1, "impulse": 3.0, "direction_deg": 45.0, "shape": "half_sine"}],
        "sensors.imu.drift": [0.01, -0.01],
        "sensors.foot_force.bias_l": [0, 0, 20, 1, 0, 0],
        "sensors.contact.dead": [{"foot": "l", "pad": "rear_left"}],
        "control.servos.missed": [{"time": 0.2, "count": 3}],
        "sensors.missed": [{"time": 0.15, "count": 2}, {"time": 0.25}],
    }
    usual = run_of(load_scenario("walk_flat", AT_ONCE))
    other, _ = assert_engines_equal(load_scenario("walk_flat", AT_ONCE | disturbed))
    assert not np.array_equal(usual.signal("joint_command"), other.signal("joint_command"))


def test_a_pattern_that_changes_its_steps_runs_the_same_in_both_engines():
    """A push in the first step, which ends over an edge: the foothold moves, and the load waits."""
    edge = {"position": [-0.3, 0.0], "size": [0.96, 1.2], "height": 0.05}
    fast = {"pattern.step_time": 0.5, "pattern.double_support": 0.25, "duration": 0.55}
    pushed = {"pushes": [{"time": 0.1, "impulse": 9.0}], "ground.obstacles": [edge]}
    usual = load_scenario("walk_flat", AT_ONCE | fast | pushed)
    plain = run_of(usual)
    for switch in ("step_adaptation", "late_foot_probing", "height_adaptation"):
        changed, _ = assert_engines_equal(override(usual, {f"pattern.{switch}": True}))
        name = "gait_phase" if switch == "late_foot_probing" else "task_reference"
        assert not np.array_equal(plain.signal(name), changed.signal(name))


def test_a_command_is_followed_the_same_in_both_engines():
    command = [
        {"time": 0.0, "v_x": 0.3, "v_y": 0.0, "turn_rate": 0.1},
        {"time": 0.1, "v_x": 0.2, "v_y": 0.02, "turn_rate": 0.0},
    ]
    scenario = load_scenario("stand", AT_ONCE | {"walk.command": command})
    run, _ = assert_engines_equal(scenario)
    record = run.result(0.0).signals
    assert np.array_equal(record["walk_command"][[50, 150]], [[0.3, 0.0, 0.1], [0.2, 0.02, 0.0]])
    assert not record["gait_phase"][-1, GAIT_PHASE.slice("support")].all()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("variant", "block", "name"),
    [
        ("dyn", "imu_stabilizer", "damping"),
        ("original", "configuration_force_control", "time_constant"),
    ],
)
def test_a_gain_that_is_turned_acts_in_the_next_tick(engine, variant, block, name):
    scenario = load_scenario("stand", {"variant": variant})
    plain, turned = (run_of(scenario, engine, until=0.02) for _ in range(2))
    gain = next(gain for gain in turned.gains() if gain[:2] == (block, name))
    assert turned.gain(gain) == plain.gain(gain)
    turned.set_gain(gain, 1.7 * plain.gain(gain))
    assert turned.gain(gain) == 1.7 * plain.gain(gain)
    bus = scenario.control.servos.delay_ticks
    for tick in range(21, 24):
        for run in (plain, turned):
            run.advance(tick * PERIOD)
        after = [run.signal("joint_desired_state") for run in (plain, turned)]
        assert np.array_equal(*after) == (tick - 20 < bus), tick


def test_turned_gains_are_the_same_in_both_engines():
    """Every gain once, one after the other, in the middle of a run."""
    scenario = load_scenario("walk_flat", AT_ONCE | {"duration": 0.1})
    runs = [start(scenario, engine=engine, limited=True) for engine in ENGINES]
    assert [list(run.gains()) for run in runs][0] == list(runs[1].gains())
    for tick, gain in enumerate(runs[0].gains()):
        for run in runs:
            run.advance(0.01 * (1 + tick))
            run.set_gain(gain, 0.6 * run.gain(gain))
        assert runs[0].gain(gain) == runs[1].gain(gain)
    for run in runs:
        run.advance(scenario.duration)
    assert_equal(*runs)


def test_gains_of_both_feet_are_turned_together():
    run = start(load_scenario("stand"))
    gains = [gain[:2] for gain in run.gains()]
    assert gains == [
        ("imu_stabilizer", "stiffness"),
        ("imu_stabilizer", "damping"),
        ("imu_stabilizer", "torque_limit"),
        ("imu_stabilizer", "height_stiffness"),
        ("force_control", "position_gain"),
        ("force_control", "time_constant"),
        ("com_dynamics", "gain"),
        ("com_dynamics", "decay_gain"),
    ]
    gain = next(gain for gain in run.gains() if gain.name == "position_gain")
    run.set_gain(gain, 7.5)
    values = run.fused.GetMyContextFromRoot(run.context).get_numeric_parameter(0).value()
    layout = run.fused.layout
    for foot in "lr":
        assert values[layout.gain_index(f"force_control_{foot}", "position_gain")] == 7.5


def test_two_runs_have_gains_of_their_own():
    runs = [start(load_scenario("stand")) for _ in range(2)]
    gain = next(runs[0].gains())
    runs[0].set_gain(gain, 1.0)
    assert runs[1].gain(gain) == 2000.0


def whole_state(run, context):
    """Return the state of everything in a diagram's context."""
    state = context.get_discrete_state()
    return np.concatenate([state.get_vector(i).CopyToVector() for i in range(state.num_groups())])


@pytest.mark.parametrize("engine", ENGINES)
def test_two_contexts_in_turn_do_not_touch_each_other(engine):
    scenario = load_scenario("walk_flat", AT_ONCE)
    run = start(scenario, engine=engine)
    simulators = [run.simulator, Simulator(run.diagram)]
    one, other = (simulator.get_mutable_context() for simulator in simulators)
    run.set_gain(next(run.gains()), 100.0)
    for k in range(1, 31):
        simulators[0].AdvanceTo(0.007 * k)
        simulators[1].AdvanceTo(0.005 * k)
    alone = [start(scenario, engine=engine) for _ in range(2)]
    alone[0].set_gain(next(run.gains()), 100.0)
    for single, until in zip(alone, (0.21, 0.15), strict=True):
        single.simulator.AdvanceTo(until)
    for mixed, single in zip((one, other), alone, strict=True):
        assert np.array_equal(whole_state(run, mixed), whole_state(single, single.context))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_clone_and_a_rerun_have_the_same_future(engine):
    scenario = load_scenario("walk_flat", AT_ONCE)
    run = run_of(scenario, engine, until=0.18)
    clone = run.context.Clone()
    run.advance(0.3)
    future = whole_state(run, run.context)
    again = Simulator(run.diagram, clone)
    again.AdvanceTo(0.3)
    assert np.array_equal(whole_state(run, again.get_context()), future)
    rerun = run_of(scenario, engine, until=0.3)
    assert np.array_equal(whole_state(rerun, rerun.context), future)
    run.simulator.reset_context(run.diagram.CreateDefaultContext())
    run.simulator.Initialize()
    run.simulator.AdvanceTo(0.3)
    assert np.array_equal(whole_state(run, run.simulator.get_context()), future)


def test_signals_of_a_run_are_those_of_its_engine():
    scenario = load_scenario("walk_flat", AT_ONCE | {"duration": 0.25})
    runs = [run_of(scenario, engine) for engine in ENGINES]
    names = set(runs[0].fused.layout.signals) - {"plant_state", "walk_command"}
    names -= {"joint_torque", "drive_feedback"}
    assert {"task_command_l", "contact", "joint_desired_state"} <= names
    for name in names:
        assert np.array_equal(*(run.signal(name) for run in runs)), name
    for run in runs:
        with pytest.raises(KeyError, match="colour"):
            run.signal("colour")
