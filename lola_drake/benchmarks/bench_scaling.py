"""Whether long runs and many runs cost what they should, measured in steady walking.

A run that has walked for a minute takes turns with one that has just begun, so that a busy machine
slows both. Two processes walk alone and together by turns. Memory is that of a process of its own,
which forgets its log.
"""

import multiprocessing
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection

import numpy as np

from lola_drake.benchmarks.bench import TURN, peak_memory_mb, spread, steady_walk, time_to_advance
from lola_drake.scenario import Scenario
from lola_drake.signals import on_tick
from lola_drake.simulation import start

SHORT, LONG = 10.0, 60.0
"""How long the runs are that are compared (s)."""


def bench_scaling(
    repeats: int = 5, progress: Callable[[int], None] | None = None
) -> dict[str, object]:
    """Measure and return what bench.json has under "scaling".

    Args:
        repeats: number of strides that are measured.
        progress: called with the number of strides measured so far.
    """
    begin, stride = steady_walk(repeats)[1:]
    strides = round((LONG - begin) / stride)
    scenario = steady_walk(max(strides, 2 * repeats))[0]
    late = on_tick(begin + max(strides - repeats, 0) * stride)
    late_over_early = _late_over_early(scenario, begin, late, stride, repeats, progress)
    return {
        "cost_60_s_over_10_s": spread(late_over_early),
        "memory_mb": _in_own_process(_memory_mb, scenario, (SHORT, LONG)),
        "two_processes_over_one": spread(_two_over_one(scenario, begin, stride, repeats)),
    }


def _late_over_early(
    scenario: Scenario,
    early: float,
    late: float,
    stride: float,
    repeats: int,
    progress: Callable[[int], None] | None,
) -> list[float]:
    """Return how much longer a stride takes in a run that has lasted long already."""
    runs = {begin: start(scenario).simulator for begin in (late, early)}
    for begin, simulator in runs.items():
        simulator.AdvanceTo(begin)
    ratios, turns = [], round(stride / TURN)
    for repeat in range(repeats):
        taken = np.zeros(2)
        for turn in range(turns):
            since = (repeat + (turn + 1) / turns) * stride
            taken += [
                time_to_advance(simulator, begin + since) for begin, simulator in runs.items()
            ]
        ratios.append(taken[0] / taken[1])
        if progress is not None:
            progress(repeat + 1)
    return ratios


def _memory_mb(pipe: Connection, scenario: Scenario, ends: tuple[float, ...]) -> None:
    """Send the greatest memory (MB) of a run until each of some times (s), without its log."""
    run, peaks = start(scenario), {}
    for second in range(1, round(max(ends)) + 1):
        run.advance(float(second))
        run.forget(0)
        if second in ends:
            peaks[f"after_{second}_s"] = peak_memory_mb()
    pipe.send(peaks)


def _two_over_one(scenario: Scenario, begin: float, stride: float, repeats: int) -> list[float]:
    """Return how much longer a stride takes when another process walks, too."""
    ratios = []
    with _process(_walk, scenario, begin) as one, _process(_walk, scenario, begin) as other:
        until = begin
        for _ in range(repeats):
            until += stride
            alone = [_time_of([pipe], until) for pipe in (one, other)]
            until += stride
            ratios.append(_time_of([one, other], until) / float(np.mean(alone)))
    return ratios


def _walk(pipe: Connection, scenario: Scenario, begin: float) -> None:
    """Simulate until the times (s) that are received, and send how long each took (s)."""
    simulator = start(scenario).simulator
    simulator.AdvanceTo(begin)
    while True:
        pipe.send(time_to_advance(simulator, pipe.recv()))


def _time_of(pipes: list[Connection], until: float) -> float:
    """Return how long the slowest of some processes takes to walk until then (s)."""
    for pipe in pipes:
        pipe.send(until)
    return max(pipe.recv() for pipe in pipes)


def _in_own_process(function: Callable[..., None], *arguments: object) -> object:
    with _process(function, *arguments) as pipe:
        return pipe.recv()


@contextmanager
def _process(function: Callable[..., None], *arguments: object) -> Iterator[Connection]:
    """Run a function in a fresh interpreter; gives the pipe to its first argument."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=function, args=(there, *arguments), daemon=True)
    process.start()
    there.close()  # so that a process that dies is an error here, not silence
    try:
        yield here
    finally:
        process.terminate()
        process.join()
