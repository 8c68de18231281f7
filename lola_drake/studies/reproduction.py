"""The experiments of the paper's section V: its figures and ours.

Without sampling each experiment is one pair of runs in the scenario as it is written. With it, each
is repeated over sampled worlds, both variants in the same ones, and what is stated is the
distribution of the paired changes.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lola_drake.results import software_versions
from lola_drake.scenario import Scenario, load_scenario, override
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.sampled_worlds import sample_world
from lola_drake.studies.statistics import causes, interval, median, paired_p, quartiles
from lola_drake.studies.stopping import until
from lola_drake.studies.study import Progress, Study
from lola_drake.studies.variants import COMPARED, change_percent


@dataclass(frozen=True)
class Experiment:
    """Two variants in one scenario.

    Attributes:
        name: what it is called in tables and files.
        title: what happens, in a few words.
        scenario: the name of a scenario that comes with the package.
        variants: what is compared: the second with the first.
        changes: overrides of the scenario.
        paper: what the paper reports, in percent, by metric and axis.
    """

    name: str
    title: str
    scenario: str
    variants: tuple[str, str] = ("ref", "dyn")
    changes: Mapping[str, object] = field(default_factory=dict)
    paper: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def changed(self, changes: Mapping[str, object]) -> "Experiment":
        """Return the experiment with further overrides of its scenario."""
        return dataclasses.replace(self, changes={**self.changes, **changes})

    def scenarios(self, seed: int | None = None, plant: str = "drake") -> list[Scenario]:
        """Return the scenario in both variants, in the world of a seed or as it is written."""
        base = load_scenario(self.scenario, {**self.changes, "plant": plant})
        world = base if seed is None else sample_world(base, seed)
        return [override(world, {"variant": variant}) for variant in self.variants]


EXPERIMENTS = (
    Experiment(
        name="board_4cm",
        title="4 cm board, contact model against [23]",
        scenario="board_4cm",
        variants=("original", "ref"),
        paper={"rms_torque_error_Nm": {"x": -3.0, "y": -9.0}},
    ),
    Experiment(
        name="board_9cm",
        title="9 cm board, CoM dynamics",
        scenario="board_9cm",
        paper={"rms_torque_error_Nm": {"x": -21.0, "y": -31.0}},
    ),
    Experiment(
        name="step_down",
        title="5.5 cm step down, CoM dynamics",
        scenario="step_down",
        paper={"max_inclination_deg": {"y": -63.0}},
    ),
    Experiment(
        name="step_down_8cm5",
        title="8.5 cm step down, CoM dynamics",
        scenario="step_down",
        changes={"ground.obstacles.0.height": 0.085},
    ),
)
"""The paper's experiments, and a higher step to see who stays up."""


PAPERS = ("max_inclination_deg", "rms_torque_error_Nm")
"""The metrics of which the paper gives figures."""


@dataclass(frozen=True)
class Outcome:
    """An experiment and its pairs of runs.

    Attributes:
        experiment: what was done.
        pairs: the summaries of both variants, one pair for each world.
    """

    experiment: Experiment
    pairs: list[tuple[Summary, Summary]]

    def falls(self) -> dict[str, int]:
        """Return in how many worlds each variant fell."""
        return self._counted("fell")

    def causes(self) -> dict[str, dict[str, int]]:
        """Return how often what came first before the falls of each variant."""
        columns = zip(*self.pairs, strict=True)
        return {v: causes(c) for v, c in zip(self.experiment.variants, columns, strict=True)}

    def failures(self) -> dict[str, int]:
        """Return in how many worlds the run of each variant ended in an error."""
        return self._counted("error")

    def _counted(self, event: str) -> dict[str, int]:
        columns = zip(*self.pairs, strict=True)
        return {
            variant: sum(bool(summary[event]) for summary in column)
            for variant, column in zip(self.experiment.variants, columns, strict=True)
        }

    def changes(self, metric: str, axis: str | None = None) -> np.ndarray:
        """Return the change (%) of a metric in every world in which it can be stated."""
        stated = [change_percent(first, second)[metric] for first, second in self.pairs]
        values = [change if axis is None else change[axis] for change in stated]
        return np.array([value for value in values if value is not None], dtype=float)

    def widest(self) -> float:
        """Return the width of the widest interval of inclination or torque error (%)."""
        ends = (interval(self.changes(metric, axis)) for metric in PAPERS for axis in ("x", "y"))
        return max(math.inf if pair is None else pair[1] - pair[0] for pair in ends)

    def _summarized(self, summarize: Callable[[np.ndarray], object]) -> dict[str, object]:
        return {
            metric: {axis: summarize(self.changes(metric, axis)) for axis in axes}
            if axes
            else summarize(self.changes(metric))
            for metric, axes in COMPARED.items()
        }

    def report(self) -> dict[str, object]:
        """Return what reproduction.json says of the experiment."""
        return {
            "scenario": self.experiment.scenario,
            "changes": dict(self.experiment.changes),
            "variants": list(self.experiment.variants),
            "worlds": len(self.pairs),
            "falls": self.falls(),
            "causes_of_falls": self.causes(),
            "failures": self.failures(),
            "pairs_that_stay_up": sum(all(map(survived, pair)) for pair in self.pairs),
            "median_change_percent": self._summarized(median),
            "quartiles": self._summarized(quartiles),
            "interval_95": self._summarized(interval),
            "paired_p": self._summarized(paired_p),
            "paper": {metric: dict(axes) for metric, axes in self.experiment.paper.items()},
        }


def run_experiments(
    study: Study,
    samples: int = 0,
    progress: Progress | None = None,
    experiments: Sequence[Experiment] = EXPERIMENTS,
    plant: str = "drake",
    width: float | None = None,
) -> list[Outcome]:
    """Return the outcome of every experiment; the study's file keeps what is done.

    Args:
        study: what keeps and makes the runs.
        samples: number of sampled worlds, of the seeds from 0 on; 0 for the scenarios themselves.
        progress: called with the number of runs that are done.
        experiments: what to do.
        plant: the engine of the robot and its ground.
        width: of all intervals of inclination and torque error, with which fewer worlds are enough
            (percentage points), see `until`.
    """

    def measure(count: int) -> tuple[list[Outcome], float]:
        outcomes = _outcomes(study, [*range(count)] or [None], progress, experiments, plant)
        return outcomes, max(outcome.widest() for outcome in outcomes) if width else 0.0

    return until(width, samples, measure)


def _outcomes(
    study: Study,
    worlds: Sequence[int | None],
    progress: Progress | None,
    experiments: Sequence[Experiment],
    plant: str,
) -> list[Outcome]:
    # World by world, so that a study that is stopped has all experiments in the first ones.
    wanted = [(e, world) for world in worlds for e in experiments]
    scenarios = [scenario for e, world in wanted for scenario in e.scenarios(world, plant)]
    summaries = study.run(scenarios, progress)
    pairs = list(zip(summaries[::2], summaries[1::2], strict=True))
    return [
        Outcome(e, [pair for pair, (of, _) in zip(pairs, wanted, strict=True) if of is e])
        for e in experiments
    ]


def reproduction(outcomes: Sequence[Outcome]) -> dict[str, object]:
    """Return the content of reproduction.json."""
    return {
        "experiments": {outcome.experiment.name: outcome.report() for outcome in outcomes},
        "versions": software_versions(),
    }
