"""Both engines, the fused system and the diagram of blocks, record the same bits."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.scenario import (
    PREDECESSOR,
    VARIANTS,
    load_scenario,
    override,
    scenario_paths,
)
from lola_drake.signals import GAIT_PHASE, PERIOD
from lola_drake.simulation import ENGINES, start

AT_ONCE = {"walk.start_time": 0.0, "pattern.first_double_support": 0.2, "duration": 0.35}
"""The first foot lifts off at 0.2 s."""


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
