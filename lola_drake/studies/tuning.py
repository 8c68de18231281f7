"""The choice of the gains: on the reference controller alone, over sampled worlds.

What `dyn` gains over `ref` grows as `ref` comes closer to falling, so gains that are chosen for
that difference prove nothing. Here they are chosen for `ref` to fall least often, to keep within
its drives' torques and the ground's friction while it walks on flat ground, and to incline least;
then they are frozen. Without the flat ground the search ends at gains that incline little where
the ground surprises, and swing all the time.
"""

import dataclasses
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.results import software_versions
from lola_drake.scenario import Control, Scenario, load_scenario
from lola_drake.scenario_keys import Setting, settings
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.run_key import software_digest
from lola_drake.studies.sampled_worlds import sample_world
from lola_drake.studies.search import Range, Score, Search, Values, search
from lola_drake.studies.study import Study

SCENARIOS = ("step_down", "board_9cm")
"""What the gains are chosen in: where `ref` can fall."""

CALM, CALM_DURATION = "walk_flat", 6.0
"""Where nothing should reach a limit, and how long that is looked at (s)."""

FIRST_SEED = 1000
"""Of the worlds to choose in: none of them is among those to measure in, which begin at 0."""

REACH, FINEST = 4, 8
"""A gain is looked for so many steps up and down, in so many parts of a step."""


@dataclass(frozen=True)
class Gain:
    """One number that is tuned.

    Attributes:
        key: of the scenario.
        step: a change of it that can be felt.
        unit: of it and the step.
    """

    key: str
    step: float
    unit: str

    @property
    def start(self) -> float:
        """Return its present value."""
        return float(_setting(self.key).default)  # type: ignore[arg-type]

    def range(self) -> Range:
        """Return where it is looked for: around its present value, where it is allowed at all."""
        setting, fine = _setting(self.key), self.step / FINEST
        assert setting.maximum is not None
        least = setting.minimum if setting.above is None else setting.above + fine
        down = min(REACH * FINEST, int((self.start - (least or 0.0)) / fine))
        up = min(REACH * FINEST, int((setting.maximum - self.start) / fine))
        return Range(self.start, fine, down, up)


def _setting(key: str) -> Setting:
    return next(found for found in settings(key) if found.key == key)


GAINS = (
    Gain("pattern.double_support", 0.04, "s"),
    Gain("control.stabilizer.stiffness", 200.0, "Nm/rad"),
    Gain("control.stabilizer.damping", 40.0, "Nms/rad"),
    Gain("pattern.zmp_inward", 0.01, "m"),
    Gain("pattern.zmp_forward", 0.01, "m"),
)

STEPS_OF_A_SLIDER = 8
"""The step of a force law's gain is this part of its slider."""


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
    progress: Callable[[int], None] = lambda done: None,
    gains: Sequence[Gain] = GAINS,
    law: str = "hybrid",
) -> Search:
    """Return a search for the gains of `ref`, beginning with the present ones.

    Args:
        study: what keeps and makes the runs; its file keeps the trials, too, so that a search that
            was stopped can go on.
        samples: number of worlds.
        budget: number of trials; each needs `samples` runs of every scenario.
        progress: called with the number of trials after each of them.
        gains: what to tune.
        law: the force law that `ref` has.
    """

    def evaluate(values: Values) -> Score:
        return score(study.run(tuning_scenarios(values, samples, law)))

    ranges = {gain.key: gain.range() for gain in gains}
    told = repr((software_digest(), samples, law, gains))
    name = f"tune {law}, {samples} worlds, {hashlib.sha256(told.encode()).hexdigest()[:16]}"
    return search(study.store.file, name, evaluate, ranges, budget, progress)


def record(
    found: Search, samples: int, gains: Sequence[Gain] = GAINS, law: str = "hybrid"
) -> dict[str, object]:
    """Return what is kept of a search: where it was done, every trial, and what it chose."""
    return {
        "variant": "ref",
        "law": law,
        "scenarios": [*SCENARIOS, CALM],
        "seeds": list(range(FIRST_SEED, FIRST_SEED + samples)),
        "units": {gain.key: gain.unit for gain in gains},
        "ranges": {gain.key: [gain.range().low, gain.range().high] for gain in gains},
        "start": found.trials[0].report(),
        "chosen": found.best().report(),
        "front": [trial.report() for trial in found.front()],
        "importance": dict(found.importance),
        "trials": [trial.report() for trial in found.trials],
        "versions": software_versions(),
    }
