"""How long a tick takes: the closed loop, the bare plant, and every block by itself.

The contenders take turns in one process, so that a busy machine slows all of them: the closed loop
as `simulate` runs it; the bare plant, whose servos get the very same commands again, so that it
walks the same way to the last bit; the plant with implicit servos; and every block on its own, with
the inputs that it has in that tick. One repeat is one stride. Judge by the ratio of the first two:
all else depends on the machine.
"""

import os
import re
import resource
import subprocess
import sys
import time
import timeit
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, LeafSystem

from lola_drake.benchmarks.bare_plant import bare_plant, record_commands
from lola_drake.blocks.walking_pattern import REQUEST, WalkingPattern
from lola_drake.compiled import compiling
from lola_drake.fused import FusedSystem
from lola_drake.results import software_versions
from lola_drake.run import Run
from lola_drake.scenario import Scenario, load_scenario
from lola_drake.servos import DampingServos, ImplicitServos
from lola_drake.signals import PERIOD, WALK_COMMAND, on_tick
from lola_drake.simulation import start
from lola_drake.theory.step_plan import plan_step
from lola_drake.theory.step_request import unpack_request

TURN = 0.05
"""Simulated time after which closed loop and plant take turns (s)."""

LOOKS = 4
"""How often in a stride the blocks are measured."""

CALLS, BATCHES = 10, 5
"""How often each block is evaluated then: the quickest batch counts."""


def bench(
    repeats: int = 5, progress: Callable[[int], None] | None = None, engine: str = "fused"
) -> dict[str, Any]:
    """Measure and return the content of bench.json.

    Args:
        repeats: number of strides that are measured.
        progress: called with the number of strides measured so far.
        engine: what runs the closed loop, see `simulate`.
    """
    scenario, begin, stride = steady_walk(repeats)
    end = begin + repeats * stride
    imports, builds = _import_times(), _build_times(scenario, engine)
    commands = record_commands(scenario, end, engine)
    run = start(scenario, engine=engine)
    own_servos = DampingServos if run.fused else ImplicitServos
    contenders = {
        "closed_loop": run.simulator,
        "plant": Simulator(bare_plant(scenario, commands, own_servos)),
        "plant_implicit": Simulator(bare_plant(scenario, commands, ImplicitServos)),
    }
    for simulator in contenders.values():
        simulator.AdvanceTo(begin)
    tick_us: dict[str, list[float]] = {name: [] for name in contenders}
    blocks_us: list[dict[str, float]] = []
    for repeat in range(repeats):
        taken, looks = dict.fromkeys(contenders, 0.0), []
        turns = round(stride / TURN)
        for turn in range(turns):
            until = begin + repeat * stride + (turn + 1) * TURN
            for name, simulator in contenders.items():
                taken[name] += time_to_advance(simulator, until)
            if (turn + 1) % (turns // LOOKS) == 0:
                looks.append(block_times(run))
        for name, time_taken in taken.items():
            tick_us[name].append(time_taken / stride * PERIOD * 1e6)
        blocks_us.append({n: float(np.mean([look[n] for look in looks])) for n in looks[0]})
        if progress is not None:
            progress(repeat + 1)
    _check_same_motion(contenders["closed_loop"], contenders["plant"])
    tick = {name: np.array(times) for name, times in tick_us.items()}
    return {
        "scenario": scenario.name,
        "repeats": repeats,
        "engine": engine,
        "compiled": compiling(),
        "closed_loop_over_plant": spread(tick["closed_loop"] / tick["plant"]),
        "plant_over_implicit": spread(tick["plant"] / tick["plant_implicit"]),
        "real_time_factor": spread(PERIOD * 1e6 / tick["closed_loop"]),
        "tick_us": {
            **{name: spread(times) for name, times in tick.items()},
            "own_part": spread(tick["closed_loop"] - tick["plant"]),
            "all_blocks": spread([sum(times.values()) for times in blocks_us]),
            "blocks": {name: spread([times[name] for times in blocks_us]) for name in blocks_us[0]},
        },
        "plan_ms": planning_times(run),
        "import_s": spread(imports),
        "build_s": spread(builds),
        "peak_memory_mb": peak_memory_mb(),
        "cpu_count": os.cpu_count(),
        "versions": software_versions(),
    }


def steady_walk(repeats: int) -> tuple[Scenario, float, float]:
    """Return a walk that is long enough, when it is steady, and how long a stride takes (s)."""
    scenario = load_scenario("walk_flat")
    pattern = scenario.pattern
    begin = scenario.walk.start_time + pattern.first_double_support + 2 * pattern.step_time
    stride = 2 * pattern.step_time
    steps = 2 * repeats + 6
    return load_scenario("walk_flat", {"walk.steps.0.count": steps}), on_tick(begin), stride


class Engine(Protocol):
    """What takes turns: a Simulator of Drake's, or what can be asked for the same."""

    def AdvanceTo(self, time: float, /) -> object:
        """Simulate until then (s)."""


def time_to_advance(simulator: Engine, until: float) -> float:
    """Return how long it takes to simulate until the tick that is then (s)."""
    begin = time.perf_counter()
    simulator.AdvanceTo(on_tick(until))
    return time.perf_counter() - begin


def block_times(run: Run) -> dict[str, float]:
    """Return how long each block takes for its outputs and its update (us), called from Python.

    Without what the plant computes for a sensor: that is part of the closed loop alone.
    """
    if run.fused:
        return _law_times(run, run.fused)
    return {
        name: _time_alone(system, system.GetMyContextFromRoot(run.context))
        for name, system in run.systems.items()
        if hasattr(system, "block")
    }


def _law_times(run: Run, fused: FusedSystem) -> dict[str, float]:
    """Return how long the laws of each block take, one by one, with what they read in this tick."""
    times = dict.fromkeys(run.blocks, 0.0)
    for block, work in fused.laws_alone(run.context):
        times[block] += _quickest_us(work)
    return times


def planning_times(run: Run, repeats: int = 5) -> dict[str, dict[str, float]]:
    """Return how long the walking pattern takes for a new plan and for a phase reset (ms)."""
    pattern = run.blocks["walking_pattern"]
    if not isinstance(pattern, WalkingPattern):
        raise TypeError(f"{type(pattern).__name__}: only the package's own plans are measured")
    request = unpack_request(run.state("walking_pattern", REQUEST.name))
    plan = plan_step(pattern.model, request)
    row = round((plan.lift_off + 0.7 * (plan.duration - plan.lift_off)) / PERIOD)
    now, command = request.start_time + row * PERIOD, np.zeros(WALK_COMMAND.size)

    def new_plan() -> None:
        plan_step(pattern.model, request)

    def phase_reset() -> None:
        landed = pattern.after_early_contact(now, command, request, plan, row)
        plan_step(pattern.model, landed)

    return {
        work.__name__: spread([1e3 * timeit.timeit(work, number=1) for _ in range(repeats)])
        for work in (new_plan, phase_reset)
    }


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


def _quickest_us(call: Callable[[], object]) -> float:
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


def _build_times(scenario: Scenario, engine: str, repeats: int = 3) -> list[float]:
    """Return how long the closed loop takes to build (s), its laws being compiled already."""
    start(scenario, engine=engine)
    taken = []
    for _ in range(repeats):
        begin = time.perf_counter()
        start(scenario, engine=engine)
        taken.append(time.perf_counter() - begin)
    return taken


def peak_memory_mb() -> float:
    """Return the greatest memory this process has had (MB)."""
    status = Path("/proc/self/status")
    if status.exists():
        # What Linux reports as ru_maxrss begins with the memory of the parent process.
        (peak,) = re.findall(r"VmHWM:\s*(\d+) kB", status.read_text(encoding="ascii"))
        return int(peak) * 1024 / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def spread(values: Iterable[float]) -> dict[str, float]:
    """Return the least and the median of repeated measurements."""
    values = np.asarray(values)
    return {"min": float(values.min()), "median": float(np.median(values))}
