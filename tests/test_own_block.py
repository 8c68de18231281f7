"""A block that the package does not know, as a user writes it, from its law to a run."""

from dataclasses import dataclass

import numpy as np
import pytest

from lola_drake.block import Block, Part, law
from lola_drake.block_system import BlockSystem
from lola_drake.parameters import parameter, validate
from lola_drake.scenario import load_scenario
from lola_drake.signals import TORSO_ORIENTATION, Field, Signal
from lola_drake.simulation import ENGINES, simulate, start
from lola_drake.world import build_simulation

LEAN = Signal("lean", "Sum of the inclinations.", (Field("sum", ("x", "y"), "rad s"),))


@dataclass(frozen=True)
class UprightParams:
    """Gains of the controller."""

    stiffness: float = parameter(
        900.0, "torque per lean", "Nm/rad", minimum=0, maximum=1e4, slider=(0, 2e3, 10)
    )
    integral: float = parameter(
        50.0, "torque per lasting lean", "Nm/(rad s)", minimum=0, maximum=1e3, slider=(0, 500, 10)
    )
    limit: float = parameter(80.0, "greatest torque", "Nm", above=0, maximum=300)

    def __post_init__(self):
        validate(self)


class Upright(Block):
    """Holds the torso upright with a PI law of the inclination."""

    Params = UprightParams
    signals = state = (LEAN,)
    parts = {"phi": Part(TORSO_ORIENTATION, "phi")}

    @law
    def modified_wrench(ideal_wrench, phi, lean, stiffness, integral, limit):
        """Return the wrench with the torque that brings the torso back."""
        x = stiffness * phi[0] + integral * lean[0]
        y = stiffness * phi[1] + integral * lean[1]
        torque_x = ideal_wrench[3] - min(max(x, -limit), limit)
        torque_y = ideal_wrench[4] - min(max(y, -limit), limit)
        force = ideal_wrench[:3]
        return (force[0], force[1], force[2], torque_x, torque_y, ideal_wrench[5])

    @law
    def next_lean(lean, phi):
        """Integrate the inclination."""
        return (lean[0] + 0.001 * phi[0], lean[1] + 0.001 * phi[1])


WITH_IT = {"imu_stabilizer": Upright}
SHORT = {"duration": 0.2}


def test_its_ports_are_those_that_its_laws_name():
    system = BlockSystem(Upright(UprightParams()))
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert {port.get_name(): port.size() for port in inputs} == {
        "ideal_wrench": 6,
        "torso_orientation": 4,
    }
    assert {port.get_name(): port.size() for port in outputs} == {"modified_wrench": 6, "lean": 2}
    assert system.ToAutoDiffXd().num_output_ports() == 2


def test_its_law_can_be_asked_alone():
    wrench = Upright.laws["modified_wrench"](np.arange(6.0), [0.1, -1.0], [0.2, 0.0], 900, 50, 80)
    assert wrench == pytest.approx((0.0, 1.0, 2.0, 3.0 - 80.0, 4.0 + 80.0, 5.0))


def test_it_runs_the_same_in_both_engines():
    def result(blocks, engine):
        run = start(load_scenario("stand", SHORT), blocks, engine, limited=True)
        run.advance(run.scenario.duration)
        run.finish()
        return run.result(1.0)

    one, other = (result(WITH_IT, engine) for engine in ENGINES)
    assert one.completed and one.signals.keys() == other.signals.keys()
    for name, values in one.signals.items():
        assert np.array_equal(values, other.signals[name]), name
    usual = result({}, "fused")
    assert not np.array_equal(usual.signals["modified_wrench"], one.signals["modified_wrench"])


@pytest.mark.parametrize("engine", ENGINES)
def test_its_state_is_a_signal_of_the_run(engine):
    run = start(load_scenario("stand", SHORT), WITH_IT, engine)
    total, before = np.zeros(2), np.zeros(2)
    for k in range(20):
        total, before = total + 0.001 * before, run.signal("torso_orientation")[:2]
        assert run.signal("lean") == pytest.approx(total, abs=1e-15)
        run.advance(0.001 * (k + 1))
    assert np.abs(total).max() > 0


@pytest.mark.parametrize("engine", ENGINES)
def test_its_gains_can_be_turned(engine):
    run = start(load_scenario("stand", SHORT), WITH_IT, engine)
    gains = {gain.name: gain for gain in run.gains() if gain.block == "imu_stabilizer"}
    assert list(gains) == ["stiffness", "integral"]
    run.advance(0.1)
    for gain in gains.values():
        run.set_gain(gain, 0.0)
    run.advance(0.15)
    assert [run.gain(gain) for gain in gains.values()] == [0.0, 0.0]
    assert np.array_equal(run.signal("modified_wrench"), run.signal("ideal_wrench"))
    record = run.result(0.0).signals
    differs = np.any(record["modified_wrench"] != record["ideal_wrench"], axis=1)
    assert differs[10:100].all() and not differs[101:].any()


def test_it_is_in_the_diagram_with_its_name():
    diagram = build_simulation(load_scenario("stand"), WITH_IT)
    controller = diagram.GetSubsystemByName("controller")
    assert type(controller.GetSubsystemByName("imu_stabilizer").block) is Upright
    assert controller.HasOutputPort("lean")


def test_attending_it_may_turn_gains_and_end_the_run():
    asked = []

    def attend(run):
        asked.append(run.time)
        run.set_gain(next(run.gains()), 100.0 * len(asked))
        return 0.01 if len(asked) < 5 else None

    result = simulate(load_scenario("stand", SHORT), attend=attend, blocks=WITH_IT)
    assert asked == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04])
    assert not result.completed and result.times[-1] == pytest.approx(0.04)
