"""The choice of the gains: on the reference controller alone, over sampled worlds.

What `dyn` gains over `ref` grows as `ref` comes closer to falling, so gains that are chosen for
that difference prove nothing. Here they are chosen for `ref` to fall least often, to keep within
its drives' torques and the ground's friction while it walks on flat ground, and to incline least;
then they are frozen. Without the flat ground the search ends at gains that incline little where
the ground surprises, and swing all the time.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake import typed_yaml
from lola_drake.results import software_versions
from lola_drake.scenario import Control, Scenario, load_scenario
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.sampled_worlds import sample_world
from lola_drake.studies.study import Study

SCENARIOS = ("step_down", "board_9cm")
"""What the gains are chosen in: where `ref` can fall."""

CALM, CALM_DURATION = "walk_flat", 6.0
"""Where nothing should reach a limit, and how long that is looked at (s)."""

FIRST_SEED = 1000
"""Of the worlds to choose in: none of them is among those to measure in, which begin at 0."""

FINEST = 0.2
"""The search ends when the steps have become this part of the first ones."""


@dataclass(frozen=True)
class Gain:
    """One number that is tuned.

    Attributes:
        key: of the scenario.
        step: by which it is changed at first.
        unit: of it and the step.
    """

    key: str
    step: float
    unit: str


GAINS = (
    Gain("pattern.double_support", 0.04, "s"),
    Gain("control.stabilizer.stiffness", 200.0, "Nm/rad"),
    Gain("control.stabilizer.damping", 40.0, "Nms/rad"),
    Gain("pattern.zmp_inward", 0.01, "m"),
    Gain("pattern.zmp_forward", 0.01, "m"),
)

STEPS_OF_A_SLIDER = 8
"""The first step of a force law's gain is this part of its slider."""


def law_gains(law: str) -> tuple[Gain, ...]:
    """Return what is tuned of a force law: all that has a slider in its section."""
    control = Control(law=law)
    section = control.of_law()
    name = next(name for name, found in vars(control).items() if found is section)
    turned = [f for f in dataclasses.fields(section) if f.metadata["slider"]]
    return tuple(
        Gain(f"control.{name}.{f.name}", (high - low) / STEPS_OF_A_SLIDER, f.metadata["unit"])
        for f, (low, high, _) in ((f, f.metadata["slider"]) for f in turned)
    )


Values = Mapping[str, float]


@dataclass(frozen=True, order=True)
class Score:
    """How good gains are; less is better, and what stands first counts first.

    Attributes:
        falls: number of runs that ended in a fall, or in an error.
        overloaded: number of walks on flat ground in which anything reached its limit.
        inclination_deg: geometric mean over the runs that stay up of the largest inclination, of x
            and y together: a tenth less counts alike wherever it is, on flat ground, too.
    """

    falls: int
    overloaded: int
    inclination_deg: float


def score(summaries: Sequence[Summary]) -> Score:
    """Return the score of some runs."""
    up = [summary for summary in summaries if survived(summary)]
    calm = [summary for summary in up if summary["scenario"] == CALM]
    sizes = [
        np.hypot(summary["max_inclination_deg"]["x"], summary["max_inclination_deg"]["y"])
        for summary in up
    ]
    mean = np.exp(np.mean(np.log(np.maximum(sizes, 1e-3)))) if sizes else np.inf
    return Score(
        falls=len(summaries) - len(up),
        overloaded=sum(any(summary["steps_beyond_limits"].values()) for summary in calm),
        inclination_deg=float(mean),
    )


@dataclass(frozen=True)
class Trial:
    """Gains that were tried, and what came of it."""

    values: Values
    score: Score

    def report(self) -> dict[str, object]:
        """Return it as plain data."""
        return {"values": dict(self.values), **dataclasses.asdict(self.score)}


def coordinate_search(
    evaluate: Callable[[Values], Score],
    start: Values,
    steps: Values,
    budget: int,
    progress: Callable[[Sequence[Trial]], None] = lambda trials: None,
) -> list[Trial]:
    """Return all trials of a search for the least score, in their order.

    One value after the other is changed by its step, up and then down, and the change is kept if
    it is better. When a round over all values improves nothing, the steps are halved. Values at
    which `evaluate` raises a ValueError are not allowed and cost nothing.

    Args:
        evaluate: returns the score of values.
        start: the values to begin with.
        steps: by which they are changed at first.
        budget: number of trials.
        progress: called with the trials after each of them.
    """
    trials = [Trial(dict(start), evaluate(start))]
    progress(trials)

    def attempt(values: Values) -> Trial | None:
        if len(trials) >= budget or any(values == trial.values for trial in trials):
            return None
        try:
            trials.append(Trial(values, evaluate(values)))
        except ValueError:
            return None
        progress(trials)
        return trials[-1]

    found, scale = trials[0], 1.0
    while len(trials) < budget and scale > FINEST:
        before = found
        for key, step in steps.items():
            for change in (scale * step, -scale * step):
                trial = attempt({**found.values, key: round(found.values[key] + change, 9)})
                if trial is not None and trial.score < found.score:
                    found = trial
                    break
        if found is before:
            scale /= 2
    return trials


def tuning_scenarios(values: Values, samples: int, law: str = "hybrid") -> list[Scenario]:
    """Return the runs that decide over gains: in every world each of `SCENARIOS`, and `CALM`."""
    ref = {"variant": "ref", "control.law": law, **values}
    runs: list[tuple[str, dict]] = [(name, {}) for name in SCENARIOS] + [
        (CALM, {"duration": CALM_DURATION})
    ]
    return [
        sample_world(load_scenario(name, {**ref, **changes}), FIRST_SEED + i)
        for i in range(samples)
        for name, changes in runs
    ]


def tune(
    study: Study,
    samples: int,
    budget: int,
    progress: Callable[[Sequence[Trial]], None] = lambda trials: None,
    gains: Sequence[Gain] = GAINS,
    law: str = "hybrid",
) -> list[Trial]:
    """Return all trials of a search for the gains of `ref`, beginning with the present ones.

    Args:
        study: where the runs are kept, so that a search that was stopped can go on.
        samples: number of worlds.
        budget: number of trials; each needs `samples` runs of every scenario.
        progress: called with the trials after each of them.
        gains: what to tune.
        law: the force law that `ref` has.
    """

    def evaluate(values: Values) -> Score:
        return score(study.run(tuning_scenarios(values, samples, law)))

    defaults = typed_yaml.leaves(typed_yaml.plain(Scenario()))
    start = {gain.key: defaults[gain.key] for gain in gains}
    return coordinate_search(
        evaluate, start, {gain.key: gain.step for gain in gains}, budget, progress
    )


def record(
    trials: Sequence[Trial], samples: int, gains: Sequence[Gain] = GAINS, law: str = "hybrid"
) -> dict[str, object]:
    """Return what is kept of a search: where it was done, every trial, and what it chose."""
    return {
        "variant": "ref",
        "law": law,
        "scenarios": [*SCENARIOS, CALM],
        "seeds": list(range(FIRST_SEED, FIRST_SEED + samples)),
        "units": {gain.key: gain.unit for gain in gains},
        "start": trials[0].report(),
        "chosen": best(trials).report(),
        "trials": [trial.report() for trial in trials],
        "versions": software_versions(),
    }


def best(trials: Sequence[Trial]) -> Trial:
    """Return the trial of the least score."""
    return min(trials, key=lambda trial: trial.score)
