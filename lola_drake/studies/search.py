"""A search for values with the least score, by Optuna, kept in the file of the study.

First it goes along the axes: one value after the other is changed by a step, up and then down, and
what is better is kept; when nothing is, the steps are halved. Then Optuna's tree-structured Parzen
estimator proposes, which looks everywhere. Alone it needs more trials: after 40 on twelve smooth
functions of five values, of which the least is about 1 and the first 28, the medians of the best
were 3.1 with it and 1.2 along the axes (and 15 with CMA-ES).

Each proposal follows from the trials before it, so that a search that is killed and started again
goes on as if nothing had happened.
"""

import logging
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from lola_drake.errors import LolaError
from lola_drake.scenario import ScenarioError

if TYPE_CHECKING:
    import optuna

FIRST_STEPS = 8
"""By how many steps of a range a value is changed at first."""

MOST_REFUSED = 10
"""A search ends when so many times its budget was not allowed."""

Values = Mapping[str, float]
Steps = tuple[int, ...]


class SearchError(LolaError):
    """A search that cannot be made."""


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

    def rank(self) -> float:
        """Return one number of the same order: nobody inclines by 1000 degrees."""
        return 1e6 * self.falls + 1e3 * self.overloaded + min(self.inclination_deg, 999.0)


@dataclass(frozen=True)
class Trial:
    """Gains that were tried, and what came of it."""

    values: Values
    score: Score

    def report(self) -> dict[str, object]:
        """Return it as plain data."""
        return {"values": dict(self.values), **asdict(self.score)}


@dataclass(frozen=True)
class Range:
    """Where a value is looked for.

    Attributes:
        start: where the search begins.
        step: between the values that are tried.
        down, up: how many steps.
    """

    start: float
    step: float
    down: int
    up: int

    def at(self, steps: int) -> float:
        """Return the value so many steps from the start."""
        # Without the last digits that sums of steps leave behind.
        return float(f"{self.start + steps * self.step:.9g}")

    @property
    def low(self) -> float:
        """Return the least value."""
        return self.at(-self.down)

    @property
    def high(self) -> float:
        """Return the greatest value."""
        return self.at(self.up)


@dataclass(frozen=True)
class Search:
    """A search.

    Attributes:
        trials: in their order; the first one is where it started.
        importance: of each value for the score, together 1; empty where that cannot be said.
    """

    trials: Sequence[Trial]
    importance: Mapping[str, float]

    def best(self) -> Trial:
        """Return the trial of the least score."""
        return min(self.trials, key=lambda trial: trial.score)

    def front(self) -> list[Trial]:
        """Return the trials to choose from: of no other one are both aims better.

        The aims are as few falls and overloads as can be, together, and as little inclination.
        """
        found: list[Trial] = []
        for trial in sorted(self.trials, key=lambda trial: _aims(trial.score)):
            if not found or trial.score.inclination_deg < found[-1].score.inclination_deg:
                found.append(trial)
        return found


def _aims(score: Score) -> tuple[int, float]:
    return score.falls + score.overloaded, score.inclination_deg


def search(
    file: Path | None,
    name: str,
    evaluate: Callable[[Values], Score],
    ranges: Mapping[str, Range],
    budget: int,
    progress: Callable[[int], None] = lambda done: None,
) -> Search:
    """Return a search for the least score.

    Values at which `evaluate` raises a ScenarioError are not allowed and cost nothing.

    Args:
        file: of a study, which keeps the trials; None to keep them nowhere.
        name: of the search in it.
        evaluate: returns the score of values.
        ranges: where to look for each value, and where to begin.
        budget: number of trials.
        progress: called with the number of trials after each of them.

    Raises:
        SearchError: If Optuna is not there.
    """
    with _optuna() as optuna:
        study = optuna.create_study(
            storage=f"sqlite:///{file}" if file else None, study_name=name, load_if_exists=True
        )
        kept = _Kept(study, ranges)
        progress(len(kept.trials()))
        while len(trials := kept.trials()) < budget and kept.refused() < MOST_REFUSED * budget:
            kept.attempt(evaluate)
            progress(len(kept.trials()))
        return Search(trials, kept.importance())


def along_axes(scores: Mapping[Steps, float], ranges: Sequence[Range]) -> Steps | None:
    """Return the next proposal of a search along the axes; None when it has come to its end.

    Args:
        scores: of all that has been tried.
        ranges: of each value.
    """
    found, change = (0,) * len(ranges), FIRST_STEPS
    if found not in scores:
        return found
    while change:
        before = found
        for k, at in enumerate(ranges):
            for sign in (1, -1):
                there = found[:k] + (found[k] + sign * change,) + found[k + 1 :]
                if not -at.down <= there[k] <= at.up:
                    continue
                if there not in scores:
                    return there
                if scores[there] < scores[found]:
                    found = there
                    break
        if found is before:
            change //= 2
    return None


@contextmanager
def _optuna() -> Iterator[ModuleType]:
    """Give Optuna without what it tells on its way; SearchError if it is not there."""
    try:
        import optuna
        import sklearn  # noqa: F401  # which Optuna takes for the importance
    except ImportError:
        need = "the search for gains needs a package: pip install 'lola_drake[tune]'"
        raise SearchError(need) from None
    optuna.logging.set_verbosity(logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        yield optuna


class _Kept:
    """The trials of a search, in a study of Optuna's."""

    def __init__(self, study: "optuna.Study", ranges: Mapping[str, Range]):
        """Go on with a study; a trial in whose midst it was ended is proposed again."""
        from optuna.trial import TrialState

        self._study, self._ranges, self._states = study, ranges, TrialState
        for trial in study.get_trials(states=(TrialState.RUNNING,)):
            study.tell(trial.number, state=TrialState.FAIL)

    def trials(self) -> list[Trial]:
        """Return what was tried."""
        return [
            Trial(self._values(trial.params), Score(**trial.user_attrs["score"]))
            for trial in self._study.get_trials(states=(self._states.COMPLETE,))
        ]

    def refused(self) -> int:
        """Return how often values were not allowed."""
        return len(self._study.get_trials(states=(self._states.PRUNED,)))

    def _values(self, steps: Mapping[str, int]) -> dict[str, float]:
        return {key: at.at(steps[key]) for key, at in self._ranges.items()}

    def attempt(self, evaluate: Callable[[Values], Score]) -> None:
        """Make the next trial."""
        asked = self._asked()
        try:
            score = evaluate(self._values(asked.params))
        except ScenarioError:
            self._study.tell(asked, state=self._states.PRUNED)
        else:
            asked.set_user_attr("score", asdict(score))
            self._study.tell(asked, score.rank())

    def _asked(self) -> "optuna.Trial":
        from optuna.distributions import IntDistribution
        from optuna.samplers import TPESampler

        settled = self._study.get_trials(states=(self._states.COMPLETE, self._states.PRUNED))
        scores = {
            tuple(trial.params[key] for key in self._ranges): (
                trial.values[0] if trial.state == self._states.COMPLETE else math.inf
            )
            for trial in settled
        }
        there = along_axes(scores, list(self._ranges.values()))
        waiting = self._study.get_trials(states=(self._states.WAITING,))
        if there is not None and not waiting:
            self._study.enqueue_trial(dict(zip(self._ranges, there, strict=True)))
        self._study.sampler = TPESampler(multivariate=True, seed=len(settled))
        return self._study.ask(
            {key: IntDistribution(-at.down, at.up) for key, at in self._ranges.items()}
        )

    def importance(self) -> dict[str, float]:
        """Return the part that each value has in the order of the scores."""
        from optuna.importance import FanovaImportanceEvaluator, get_param_importances

        done = self._study.get_trials(states=(self._states.COMPLETE,))
        order = sorted(trial.values[0] for trial in done)
        try:
            found = get_param_importances(
                self._study,
                evaluator=FanovaImportanceEvaluator(seed=0),
                target=lambda trial: float(order.index(trial.values[0])),
            )
        except (ValueError, RuntimeError):
            return {}  # too few trials, or all of them alike
        return {key: float(value) for key, value in found.items()}
