"""Running scenarios: `simulate()`, and `start()` for who wants to go step by step."""

import logging
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from pydrake.systems.framework import Diagram

from lola_drake.atomic_file import growing_folder, reason
from lola_drake.block import Block
from lola_drake.errors import LolaError
from lola_drake.interruption import interruption
from lola_drake.record import RecordedSignals, Recorder
from lola_drake.results import Result, recording, write_summary
from lola_drake.run import Run
from lola_drake.scenario import Scenario, as_scenario
from lola_drake.servos import DampingServos, ImplicitServos
from lola_drake.signals import JOINT_DESIRED_STATE, JOINT_FEEDFORWARD, PERIOD
from lola_drake.swap import Replacement
from lola_drake.world import build_fused, build_simulation, make_world

ENGINES = ("fused", "diagram")

Attend = Callable[[Run], float | None]


def simulate(
    scenario: Scenario | str | Path,
    progress: Callable[[float], None] | None = None,
    chunk: float = 0.02,
    attend: Attend | None = None,
    *,
    blocks: Mapping[str, Replacement] | None = None,
    engine: str = "fused",
    folder: str | Path | None = None,
    force: bool = False,
) -> Result:
    """Run a scenario to its end, a fall, or Ctrl-C, and return everything that was recorded.

    An error of the solver, of a block or of `attend` ends the run, too; `Result.error` says which.

    Args:
        scenario: what to run: a scenario, its name, or the path of its file.
        progress: called with the simulated time (s) every `chunk` seconds.
        chunk: how often a fall, an interruption and the progress are looked at (s).
        attend: called with the run, in which it may change gains and commands; returns by how much
            to go on until the next call (s), 0 to wait, or None to end the run.
        blocks: laws of your own by the names of the blocks that they replace, see `swapped`.
        engine: "fused" for all laws in one system, "diagram" for that of `build_simulation`.
        folder: where to save the run while it goes on, second by second, so that it needs no more
            memory the longer it is. Until its end the folder is called FOLDER.part.
        force: replace the run that the folder holds.

    Raises:
        ResultError: If the folder cannot be used or written.
    """
    run = start(scenario, blocks, engine)
    began, duration = time.perf_counter(), run.scenario.duration
    with interruption() as interrupted, _recorder(folder, run.scenario, force) as recorder:
        with _kept() as errors:
            while not (run.fallen or interrupted.is_set()):
                if recorder is not None:
                    run.write(recorder)
                step = chunk if attend is None else attend(run)
                if step is None or run.time >= duration - 0.5 * PERIOD:
                    break
                run.advance(min(run.time + step, duration))
                if progress is not None:
                    progress(run.time)
            run.finish()
        error = errors[0] if errors else None
        result = run.result(time.perf_counter() - began, error, recorder)
        if recorder is not None:
            write_summary(result, recorder.path.parent)
    if folder is not None and isinstance(result.signals, RecordedSignals):
        result.signals.move(Path(folder).resolve())
    return result


@contextmanager
def _recorder(
    folder: str | Path | None, scenario: Scenario, force: bool
) -> Iterator[Recorder | None]:
    """Give what writes the record of a run, if there is to be one on the disk."""
    if folder is None:
        yield None
        return
    with growing_folder(folder, force=force) as part, recording(part, scenario) as recorder:
        yield recorder


def start(
    scenario: Scenario | str | Path,
    blocks: Mapping[str, Replacement] | None = None,
    engine: str = "fused",
    *,
    limited: bool = False,
    compile_laws: bool | None = None,
) -> Run:
    """Return a run that has not advanced yet; the arguments are those of `simulate`.

    The engine is the diagram if one of the blocks is a system of Drake's own, or if what the servos
    get is no state. The fused one begins with the cheaper servos, which know no limits; see
    `lola_drake.servos`.

    Args:
        scenario: as in `simulate`.
        blocks: as in `simulate`.
        engine: as in `simulate`.
        limited: whether the fused engine begins with the servos of the diagram, too.
        compile_laws: whether the fused engine compiles its laws; None for where it can.
    """
    if engine not in ENGINES:
        raise ValueError(f"engine: {engine!r} is not allowed, it must be one of {ENGINES}")
    scenario = as_scenario(scenario)
    if engine == "diagram" or not _can_be_fused(scenario, blocks):
        return Run(scenario, build_simulation(scenario, blocks))

    def fused(servos: type[ImplicitServos | DampingServos]) -> Diagram:
        world = make_world(scenario, blocks, servos)
        return build_fused(world, scenario, compile_laws=compile_laws)

    # MuJoCo's servos keep their limits by themselves.
    if limited or scenario.plant == "mujoco":
        return Run(scenario, fused(ImplicitServos))
    return Run(scenario, fused(DampingServos), lambda: fused(ImplicitServos))


def _can_be_fused(scenario: Scenario, blocks: Mapping[str, Replacement] | None) -> bool:
    """Return whether all blocks declare their laws, and what the servos get is state.

    Otherwise it would depend at once on what the plant says of its contacts.
    """
    if not blocks and not scenario.blocks:
        return True
    world = make_world(scenario, blocks)
    parts = [*world.sensors.values(), *world.controller.values()]
    declared = [part for part in parts if isinstance(part, Block)]
    states = {name for block in declared for name in block.states}
    all_are = len(declared) == len(parts)
    return all_are and {JOINT_DESIRED_STATE.name, JOINT_FEEDFORWARD.name} <= states


@contextmanager
def _kept() -> Iterator[list[str]]:
    """Let an error of the solver, a block or who attends end a run, but not lose its record.

    A failed assertion of Drake's is a SystemExit. The whole of the error is for the log.
    """
    errors: list[str] = []
    try:
        yield errors
    except (Exception, SystemExit) as error:
        logging.getLogger("lola_drake").debug("a run failed", exc_info=True)
        kind = "" if isinstance(error, LolaError) else f"{type(error).__name__}: "
        errors.append(kind + reason(error))
