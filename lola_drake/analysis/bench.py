"""How long a tick takes and where the time goes, measured in steady walking.

Three things take turns in one process, so that a busy machine slows all of them: the closed loop;
the bare plant, whose servos get the very same commands again, so that it walks the same way to the
last bit; and every block on its own, with the inputs that it has in that tick. One repeat is one
stride. Judge by the ratio of the first two: all else depends on the machine.
"""

import os
import platform
import resource
import subprocess
import sys
import time
import timeit
from collections.abc import Callable, Iterable

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer

from lola_drake.blocks.joint_servos import set_servo_gains
from lola_drake.plant import add_plant, set_start
from lola_drake.results import software_versions
from lola_drake.scenario import Scenario, load_scenario
from lola_drake.signals import JOINTS, PERIOD
from lola_drake.simulation import build_simulation

TURN = 0.05
"""Simulated time after which closed loop and plant take turns (s)."""

LOOKS = 4
"""How often in a stride the blocks are measured."""

CALLS, BATCHES = 10, 5
"""How often each block is evaluated then: the quickest batch counts."""

_COMMANDS = ("joint_desired_state", "joint_feedforward")


def bench(repeats: int = 5, progress: Callable[[int], None] | None = None) -> dict[str, object]:
    """Measure and return the content of bench.json.

    Args:
        repeats: number of strides that are measured.
        progress: called with the number of strides measured so far.
    """
    scenario, begin, stride = _walk(repeats)
    end = begin + repeats * stride
    imports, builds = _import_times(), _build_times(scenario)
    commands = _record_commands(scenario, end)
    loop, plant = Simulator(build_simulation(scenario)), Simulator(_bare_plant(scenario, commands))
    for simulator in (loop, plant):
        simulator.AdvanceTo(begin)
    loop_us, plant_us, blocks_us = [], [], []
    for repeat in range(repeats):
        taken, looks = np.zeros(2), []
        turns = round(stride / TURN)
        for turn in range(turns):
            until = begin + repeat * stride + (turn + 1) * TURN
            taken += [_advance(simulator, until) for simulator in (loop, plant)]
            if (turn + 1) % (turns // LOOKS) == 0:
                looks.append(_block_times(loop.get_system(), loop.get_context()))
        loop_us.append(taken[0] / stride * PERIOD * 1e6)
        plant_us.append(taken[1] / stride * PERIOD * 1e6)
        blocks_us.append({name: np.mean([look[name] for look in looks]) for name in looks[0]})
        if progress is not None:
            progress(repeat + 1)
    _check_same_motion(loop, plant)
    tick = np.array(loop_us)
    return {
        "scenario": scenario.name,
        "repeats": repeats,
        "closed_loop_over_plant": _spread(tick / plant_us),
        "real_time_factor": _spread(PERIOD * 1e6 / tick),
        "tick_us": {
            "closed_loop": _spread(tick),
            "plant": _spread(plant_us),
            "all_blocks": _spread([sum(times.values()) for times in blocks_us]),
            "blocks": {
                name: _spread([times[name] for times in blocks_us]) for name in blocks_us[0]
            },
        },
        "import_s": _spread(imports),
        "build_s": _spread(builds),
        "peak_memory_mb": _peak_memory_mb(),
        "cpu_count": os.cpu_count(),
        "versions": software_versions(),
    }


def _walk(repeats: int) -> tuple[Scenario, float, float]:
    """Return a walk that is long enough, when it is steady, and how long a stride takes (s)."""
    scenario = load_scenario("walk_flat")
    pattern = scenario.pattern
    begin = scenario.walk.start_time + pattern.first_double_support + 2 * pattern.step_time
    stride = 2 * pattern.step_time
    steps = 2 * repeats + 6
    return load_scenario("walk_flat", {"walk.steps.0.count": steps}), begin, stride


def _record_commands(scenario: Scenario, end: float) -> np.ndarray:
    """Return what the servos get in every tick of the closed loop, shape (ticks, 72)."""
    diagram = build_simulation(scenario)
    simulator = Simulator(diagram)
    controller = diagram.GetSubsystemByName("controller")
    context = controller.GetMyContextFromRoot(simulator.get_context())
    ports = [controller.GetOutputPort(name) for name in _COMMANDS]
    # One row more: rounding may let the simulation go one tick beyond the end.
    commands = np.empty((round(end / PERIOD) + 1, 3 * len(JOINTS)))
    for tick, command in enumerate(commands):
        command[:] = np.concatenate([port.Eval(context) for port in ports])
        simulator.AdvanceTo((tick + 1) * PERIOD)
    return commands


class _Replay(LeafSystem):
    """Gives one row of a table per tick."""

    def __init__(self, rows: np.ndarray):
        super().__init__()
        self._rows = rows
        self.DeclareVectorOutputPort("row", rows.shape[1], self._calc, {self.time_ticket()})

    def _calc(self, context, output):
        output.set_value(self._rows[round(context.get_time() / PERIOD)])


def _bare_plant(scenario: Scenario, commands: np.ndarray) -> Diagram:
    """Return the plant of a scenario with servos that get the commands of a table."""
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, scenario.ground)
    plant.Finalize()
    set_servo_gains(plant, scenario.control.servos)
    stance = build_simulation(scenario).GetSubsystemByName("controller").stance
    set_start(plant, scenario.start, scenario.ground, stance.q, stance.p_PT)
    replay = builder.AddSystem(_Replay(commands))
    parts = builder.AddSystem(Demultiplexer([2 * len(JOINTS), len(JOINTS)]))
    builder.Connect(replay.get_output_port(), parts.get_input_port())
    robot = plant.GetModelInstanceByName("lola")
    builder.Connect(parts.get_output_port(0), plant.get_desired_state_input_port(robot))
    builder.Connect(parts.get_output_port(1), plant.get_actuation_input_port())
    return builder.Build()


def _advance(simulator: Simulator, until: float) -> float:
    """Return how long it takes to simulate until then (s)."""
    begin = time.perf_counter()
    simulator.AdvanceTo(until)
    return time.perf_counter() - begin


def _block_times(diagram: Diagram, root: Context) -> dict[str, float]:
    """Return how long each block takes for its outputs and its update (us).

    Without what the plant computes for a sensor: that is part of the closed loop alone.
    """
    controller = diagram.GetSubsystemByName("controller")
    sensors = [system for system in diagram.GetSystems() if _is_block(system)]
    return {
        block.get_name(): _time_alone(block, block.GetMyContextFromRoot(root))
        for block in (*controller.GetSystems(), *sensors)
    }


def _is_block(system) -> bool:
    return type(system).__module__.startswith("lola_drake.blocks.")


def _time_alone(block: LeafSystem, original: Context) -> float:
    """Return how long a block takes with its inputs held as they are (us)."""
    context = block.CreateDefaultContext()
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        port.FixValue(context, port.Eval(original))
    outputs = [block.get_output_port(i) for i in range(block.num_output_ports())]
    updates = original.num_discrete_state_groups() > 0

    def restore() -> None:
        context.SetTimeStateAndParametersFrom(original)

    def read() -> None:
        for output in outputs:
            output.Eval(context)

    def work() -> None:
        restore()
        read()
        if updates:
            block.EvalUniquePeriodicDiscreteUpdate(context)

    working, restoring = _quickest_us(work), _quickest_us(restore)
    read()  # now everything is in the cache
    return working - restoring - _quickest_us(read)


def _quickest_us(call: Callable[[], None]) -> float:
    return min(timeit.repeat(call, number=CALLS, repeat=BATCHES)) / CALLS * 1e6


def _check_same_motion(loop: Simulator, plant: Simulator) -> None:
    """Raise an error unless both plants are in the same state, to the last bit."""
    states = []
    for simulator in (loop, plant):
        body = simulator.get_system().GetSubsystemByName("plant")
        context = body.GetMyContextFromRoot(simulator.get_context())
        states.append(body.GetPositionsAndVelocities(context))
    if not np.array_equal(*states):
        raise ArithmeticError("the bare plant has not walked as the closed loop has")


def _import_times(repeats: int = 3) -> list[float]:
    """Return how long a fresh interpreter takes to import everything a simulation needs (s)."""
    code = (
        "import time; begin = time.perf_counter(); import lola_drake; lola_drake.simulate; "
        "print(time.perf_counter() - begin)"
    )
    command = [sys.executable, "-c", code]
    return [
        float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        for _ in range(repeats)
    ]


def _build_times(scenario: Scenario, repeats: int = 3) -> list[float]:
    """Return how long the diagram of the closed loop takes to build (s)."""
    taken = []
    for _ in range(repeats):
        begin = time.perf_counter()
        build_simulation(scenario)
        taken.append(time.perf_counter() - begin)
    return taken


def _peak_memory_mb() -> float:
    """Return the greatest memory this process has had."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if platform.system() == "Darwin" else 1e3)


def _spread(values: Iterable[float]) -> dict[str, float]:
    values = np.asarray(values)
    return {"min": float(values.min()), "median": float(np.median(values))}
