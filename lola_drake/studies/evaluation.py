"""A law of the feet's forces in the arena: up to which size of each trial it stays up, and how.

A contender is a law in a variant: `dyn` with the CoM dynamics of eq. 19 and 20, `ref` without.
"""

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.results import software_versions
from lola_drake.scenario import ScenarioError, load_scenario
from lola_drake.studies.arena import FIRST_SEED, TRIALS, Trial
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.statistics import median, share
from lola_drake.studies.study import Progress, Study
from lola_drake.typed_yaml import suggestion

VARIANTS = ("ref", "dyn")


class Measure(NamedTuple):
    """What is said of the runs without a fall: its label, and how it follows from a summary."""

    label: str
    of: Callable[[Summary], float]


MEASURED = {
    "inclination_deg": Measure(
        "largest inclination (deg)",
        lambda run: _size(run["max_inclination_deg"]),
    ),
    "torque_error_Nm": Measure(
        "RMS torque error (Nm)", lambda run: _size(run["rms_torque_error_Nm"])
    ),
    "foot_force_N": Measure("largest force on a foot (N)", lambda run: run["max_foot_force_N"]),
    "drive_work_J": Measure("work of the drives (J)", lambda run: run["drive_work_J"]),
}
"""By their names in evaluation.json."""

MARGINS = {"force_loop": "left", "stabilizer": "stand"}
"""The named analyses whose margins stand beside the arena, and at which operating point."""


def _size(of_axes: Mapping[str, float]) -> float:
    """Return the size of what a summary has about x and y."""
    return float(np.hypot(of_axes["x"], of_axes["y"]))


def law_settings(law: str) -> dict[str, object]:
    """Return the settings of a scenario that mean a law.

    Args:
        law: one of `FORCE_LAWS`, or FILE.py:CLASS of a block in place of `force_control`.

    Raises:
        ScenarioError: If it is neither.
    """
    if law in FORCE_LAWS:
        return {"control.law": law}
    file, _, name = law.rpartition(":")
    if not file.endswith(".py"):
        raise ScenarioError(
            f"law {law!r}: neither FILE.py:CLASS nor known{suggestion(law, FORCE_LAWS)}"
        )
    own = {"name": "force_control", "law": f"{os.path.abspath(file)}:{name}"}
    return {"blocks": [own]}


def law_name(law: str) -> str:
    """Return what a law is called: its own name, or that of its class."""
    return law.rpartition(":")[2]


def evaluate(
    law: str,
    study: Study,
    worlds: int,
    progress: Progress | None = None,
    trials: Sequence[Trial] = TRIALS,
) -> dict[str, object]:
    """Return what the arena says of a law, the content of evaluation.json.

    Args:
        law: see `law_settings`.
        study: what keeps and makes the runs.
        worlds: how many, at every size of every trial.
        progress: called with the number of runs that are done.
        trials: the arena, or a part of it.
    """
    settings = law_settings(law)
    seeds = range(FIRST_SEED, FIRST_SEED + worlds)
    asked = [
        (trial, size, variant) for trial in trials for size in trial.sizes for variant in VARIANTS
    ]
    scenarios = [
        trial.world(size, seed, {**settings, "variant": variant})
        for trial, size, variant in asked
        for seed in seeds
    ]
    runs = iter(study.run(scenarios, progress))
    points = {
        (trial.title, variant, size): _point(size, list(itertools.islice(runs, worlds)))
        for trial, size, variant in asked
    }
    return {
        "law": law_name(law),
        "worlds": worlds,
        "first_seed": FIRST_SEED,
        "trials": {trial.title: _trial(trial, points) for trial in trials},
        "margins": {variant: loop_margins(settings, variant) for variant in VARIANTS},
        "versions": software_versions(),
    }


def _trial(trial: Trial, points: Mapping[tuple, dict]) -> dict[str, object]:
    curves = {
        variant: [points[trial.title, variant, size] for size in trial.sizes]
        for variant in VARIANTS
    }
    return {
        "unit": trial.unit,
        "direction_deg": trial.direction_deg,
        "curves": curves,
        "half": {variant: half(curve) for variant, curve in curves.items()},
    }


def _point(size: float, runs: list[Summary]) -> dict[str, object]:
    """Return the share of runs that stay up, with its interval, and medians over these."""
    standing = [run for run in runs if survived(run)]
    return {"size": size, **share(runs)} | {
        name: median(np.array([measure.of(run) for run in standing]))
        for name, measure in MEASURED.items()
    }


def half(curve: Sequence[Mapping]) -> float | None:
    """Return the size at which half of the worlds fall, between those that were tried.

    The first crossing counts. None where more than half stay up at all sizes; the first size where
    half have fallen at that one already.
    """
    if curve[0]["share"] <= 0.5:
        return float(curve[0]["size"])
    for before, after in itertools.pairwise(curve):
        if after["share"] <= 0.5:
            part = (before["share"] - 0.5) / (before["share"] - after["share"])
            return float(before["size"] + part * (after["size"] - before["size"]))
    return None


def loop_margins(
    settings: Mapping[str, object], variant: str
) -> dict[str, dict[str, float | None]]:
    """Return the margins of `MARGINS` with a law, each that of its worst loop.

    `disk` is that of all signals of a loop at once, `delay_s` and `phase_deg` those of one, None
    where it may be any.
    """
    from lola_drake.linear.studies.analyses import analyse

    scenario = load_scenario("stand", {**settings, "variant": variant})
    found = {}
    for name, at in MARGINS.items():
        loops = analyse(name, scenario, at, locus=False).loops
        each = [margins for loop in loops for margins in loop.margins]
        together = [loop.together or loop.margins[0] for loop in loops]
        found[name] = {
            "stable": all(margins.stable for margins in each),
            "disk": min(margins.disk for margins in together),
            "phase_deg": _finite(min(margins.phase for margins in each)),
            "delay_s": _finite(min(margins.delay for margins in each)),
        }
    return found


def _finite(margin: float) -> float | None:
    """Return a margin; None for any."""
    return margin if isfinite(margin) else None
