"""A law of the feet's forces in the arena: up to which size of each trial it stays up, and how.

A contender is a law in a variant: `dyn` with the CoM dynamics of eq. 19 and 20, `ref` without. It
goes through each trial from its least size on, and is spared what is beyond the second size in a
row at which it falls in every world; or the sizes are bisected.
"""

import itertools
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import NamedTuple

import numpy as np

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.results import software_versions
from lola_drake.scenario import Overrides, ScenarioError, differences, load_scenario
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

Curves = dict[tuple[Trial, str], list[Mapping]]
"""Of each trial and variant a point for every size."""

Following = Callable[[Sequence[float], Sequence[Mapping]], float | None]
"""Which of a trial's sizes follows those of a curve, if any."""

MARGINS = {"force_loop": "left", "stabilizer": "stand"}
"""The named analyses whose margins stand beside the arena, and at which operating point."""


def _size(of_axes: Mapping[str, float]) -> float:
    """Return the size of what a summary has about x and y."""
    return float(np.hypot(of_axes["x"], of_axes["y"]))


def law_settings(law: str, changes: Overrides = ()) -> dict[str, object]:
    """Return the settings of a scenario that mean a law.

    Args:
        law: one of `FORCE_LAWS`, or FILE.py:CLASS of a block in place of `force_control`.
        changes: what else its scenarios are to have, see `override`.

    Raises:
        ScenarioError: If it is neither, or the changes cannot be used.
    """
    others = differences(load_scenario("walk_flat", changes), load_scenario("walk_flat"))
    return _law(law) | others


def _law(law: str) -> dict[str, object]:
    if law in FORCE_LAWS:
        return {"control.law": law}
    file, _, name = law.rpartition(":")
    if not file.endswith(".py"):
        raise ScenarioError(
            f"law {law!r}: neither FILE.py:CLASS nor known{suggestion(law, FORCE_LAWS)}"
        )
    own = {"name": "force_control", "law": f"{os.path.abspath(file)}:{name}"}
    return {"blocks": [own]}


def law_name(law: str, changes: Sequence[str] = ()) -> str:
    """Return what a law is called: its own name, or that of its class, and what is changed."""
    return " ".join([law.rpartition(":")[2], *changes])


def chosen(trials: Sequence[Trial], beginnings: Sequence[str]) -> list[Trial]:
    """Return the trials whose titles begin so, all of them if nothing is given.

    Raises:
        ScenarioError: If no title does.
    """
    for text in beginnings:
        if not any(trial.title.startswith(text) for trial in trials):
            titles = ", ".join(repr(trial.title) for trial in trials)
            raise ScenarioError(f"trial {text!r}: none begins so; there are {titles}")
    return [trial for trial in trials if trial.title.startswith(tuple(beginnings) or "")]


def evaluate(
    law: str,
    study: Study,
    worlds: int,
    progress: Progress | None = None,
    trials: Sequence[Trial] = TRIALS,
    changes: Sequence[str] = (),
    variants: Sequence[str] = VARIANTS,
    following: Following | None = None,
) -> dict[str, object]:
    """Return what the arena says of a law, the content of evaluation.json.

    Args:
        law: see `law_settings`.
        study: what keeps and makes the runs.
        worlds: how many, at every size of every trial.
        progress: called with the number of runs that are done; at the end of all, spared or not.
        trials: the arena, or a part of it.
        changes: of its scenarios, such as `"pattern.step_adaptation=true"`.
        variants: with which of them.
        following: says which size is next, `upward` or `bisecting`.

    Raises:
        ScenarioError: If the law, a change or a variant cannot be used.
    """
    for variant in variants:
        if variant not in VARIANTS:
            raise ScenarioError(f"variant {variant!r}: must be one of {', '.join(VARIANTS)}")
    settings = law_settings(law, changes)
    curves: Curves = {(trial, variant): [] for trial in trials for variant in variants}
    _go_through(curves, settings, study, worlds, progress or (lambda _: None), following or upward)
    return {
        "law": law_name(law, changes),
        "worlds": worlds,
        "first_seed": FIRST_SEED,
        "trials": {
            trial.title: _trial(trial, {variant: curves[trial, variant] for variant in variants})
            for trial in trials
        },
        "margins": {variant: loop_margins(settings, variant) for variant in variants},
        "versions": software_versions(),
    }


def upward(sizes: Sequence[float], curve: Sequence[Mapping]) -> float | None:
    """Return the size that follows the largest one of a curve, if any does.

    Nothing follows two sizes in a row at which no world was survived.
    """
    hopeless = len(curve) > 1 and curve[-1]["share"] == curve[-2]["share"] == 0
    return None if hopeless or len(curve) == len(sizes) else sizes[len(curve)]


def bisecting(sizes: Sequence[float], curve: Sequence[Mapping]) -> float | None:
    """Return the size in the middle of those between which half of the worlds fall.

    None where these are neighbours: only where half fall is found, and little of the curve.
    """
    shares = {point["size"]: point["share"] for point in curve}
    tried = [k for k, size in enumerate(sizes) if size in shares]
    high = next((k for k in tried if shares[sizes[k]] <= 0.5), len(sizes))
    low = max((k for k in tried if k < high), default=-1)
    return sizes[(low + high) // 2] if high - low > 1 else None


def _go_through(
    curves: Curves,
    settings: Mapping[str, object],
    study: Study,
    worlds: int,
    progress: Progress,
    following: Following,
) -> None:
    """Add points to curves until no size follows, to those of all trials at once."""
    seeds = range(FIRST_SEED, FIRST_SEED + worlds)
    done = 0
    while asked := _asked(curves, following):
        scenarios = [
            trial.world(size, seed, {**settings, "variant": variant})
            for (trial, variant), size in asked.items()
            for seed in seeds
        ]
        runs = iter(study.run(scenarios, partial(_later, progress, done)))
        for each, size in asked.items():
            curves[each].append(_point(size, list(itertools.islice(runs, worlds))))
            curves[each].sort(key=lambda point: point["size"])
        done += len(scenarios)
    progress(worlds * sum(len(trial.sizes) for trial, _ in curves))


def _asked(curves: Curves, following: Following) -> dict[tuple[Trial, str], float]:
    """Return the next size of every curve that has one."""
    sizes = {each: following(each[0].sizes, curve) for each, curve in curves.items()}
    return {each: size for each, size in sizes.items() if size is not None}


def _later(progress: Progress, before: int, count: int) -> None:
    """Tell the progress of runs that follow others."""
    progress(before + count)


def _trial(trial: Trial, curves: Mapping[str, Sequence[Mapping]]) -> dict[str, object]:
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
