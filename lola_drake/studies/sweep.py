"""A scenario over some of its keys: who stays up, and how well, in each of their combinations.

At each point all variants meet the same worlds, and all points have the worlds of the same seeds.
"""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.errors import short, shown
from lola_drake.results import software_versions
from lola_drake.scenario import Scenario, ScenarioError, override
from lola_drake.scenario_keys import settings
from lola_drake.studies import statistics
from lola_drake.studies.designs import Point
from lola_drake.studies.factors import Factor, SweepError
from lola_drake.studies.row import Summary, survived
from lola_drake.studies.sampled_worlds import sample_world
from lola_drake.studies.stopping import until
from lola_drake.studies.study import Progress, Study
from lola_drake.studies.variants import COMPARED
from lola_drake.studies.worst import worst
from lola_drake.typed_yaml import leaves

FIRST_SEED = 3000
"""Of the worlds: the other studies' begin at 0, 1000 and 2000."""

METRICS = tuple(
    f"{name}.{axis}" if axis else name for name, axes in COMPARED.items() for axis in axes or ("",)
)
"""What may be looked at, by the names of summary.json."""

METRIC = "max_inclination_deg.y"
"""What is looked at unless something else is asked for."""

WORST = 10
"""Worlds that are listed with the command that runs them again."""


@dataclass(frozen=True)
class Sweep:
    """What is swept.

    Attributes:
        base: everything else of the scenario.
        factors: what is varied.
        points: the values of all keys, see `designs`.
        variants: of the controller.
        metric: what is looked at, such as "max_inclination_deg.y".
        design: how the points were chosen.
    """

    base: Scenario
    factors: Sequence[Factor]
    points: Sequence[Point]
    variants: Sequence[str] = ("ref", "dyn")
    metric: str = METRIC
    design: str = "grid"

    def __post_init__(self):
        if self.metric not in METRICS:
            raise SweepError(f"metric: {shown(self.metric)}, there are {', '.join(METRICS)}")
        if len(set(self.variants)) < len(self.variants):
            raise SweepError(f"variants {', '.join(self.variants)}: must all be different")

    @property
    def runs_per_world(self) -> int:
        """Return how many runs one world more means."""
        return len(self.points) * len(self.variants)

    def scenarios(self, worlds: int) -> list[Scenario]:
        """Return the runs in some worlds, or, if there are none, in the scenario as it is written.

        World by world, then point by point, then by variants, so that a sweep that is stopped has
        all points in the first worlds. A ScenarioError names the first point that cannot be.
        """
        at = [self._at(point) for point in self.points]
        seeds = range(FIRST_SEED, FIRST_SEED + worlds) if worlds else [None]
        return [
            dataclasses.replace(world, variant=variant)
            for seed in seeds
            for world in (one if seed is None else sample_world(one, seed) for one in at)
            for variant in self.variants
        ]

    def check(self, worlds: int) -> None:
        """Say what cannot be swept, before anything runs.

        Raises:
            ScenarioError: If a point cannot be.
            SweepError: If a key makes no difference, since its value is drawn at random in sampled
                worlds, or said by the variants.
        """
        self.scenarios(min(worlds, 1))
        for factor in self.factors:
            ends = [{factor.key: value} for value in (factor.values[0], factor.values[-1])]
            one, other = (
                dataclasses.replace(self, points=[end]).scenarios(min(worlds, 1)) for end in ends
            )
            if one == other and len(factor.values) > 1:
                given = "--variants say it" if factor.key == "variant" else "it is drawn at random"
                raise SweepError(f"{factor.key}: makes no difference here, {given}")

    def _at(self, point: Point) -> Scenario:
        try:
            return override(self.base, {**point, "variant": self.variants[0]})
        except ScenarioError as error:
            values = ", ".join(f"{key}={value}" for key, value in point.items())
            raise ScenarioError(f"the point {short(values, 100)}: {error}") from None


def run_sweep(
    study: Study,
    sweep: Sweep,
    worlds: int,
    width: float | None = None,
    progress: Progress | None = None,
) -> dict[str, object]:
    """Return the content of sweep.json.

    Args:
        study: what keeps and makes the runs.
        sweep: what is swept.
        worlds: number of sampled worlds, 0 for the scenario as it is written.
        width: of all intervals of the shares, with which fewer worlds are enough, see `until`.
        progress: called with the number of runs that are done.
    """

    def measure(count: int) -> tuple[dict[str, object], float]:
        scenarios = sweep.scenarios(count)
        summaries = study.run(scenarios, progress)
        content = _content(sweep, summaries)
        content["worst"] = worst(study, scenarios, summaries, WORST)
        return content, _widest(content)

    return until(width, worlds, measure) | {"versions": software_versions()}


def _content(sweep: Sweep, summaries: Sequence[Summary]) -> dict[str, object]:
    count = len(sweep.variants)
    # Of each point and variant: its runs by world.
    runs = [
        [summaries[i * count + k :: sweep.runs_per_world] for k in range(count)]
        for i in range(len(sweep.points))
    ]
    return {
        "scenario": sweep.base.name,
        "variants": list(sweep.variants),
        "worlds": len(summaries) // sweep.runs_per_world,
        "metric": sweep.metric,
        "design": sweep.design,
        "factors": {
            factor.key: {"unit": unit_of(factor.key), "values": list(factor.values)}
            for factor in sweep.factors
        },
        "points": [
            {"values": dict(point), **_at_point(sweep, at)}
            for point, at in zip(sweep.points, runs, strict=True)
        ],
        "causes": {
            variant: statistics.causes([run for at in runs for run in at[k]])
            for k, variant in enumerate(sweep.variants)
        },
    }


def _at_point(sweep: Sweep, runs: Sequence[Sequence[Summary]]) -> dict[str, object]:
    """Return what is found at a point, of the runs of each variant, all in the same worlds."""
    values = [np.array([metric_of(run, sweep.metric) for run in of]) for of in runs]
    found: dict[str, object] = {
        "variants": {
            variant: {
                "survived": statistics.share(of),
                "falls": sum(bool(run["fell"]) for run in of),
                "failures": sum(bool(run["error"]) for run in of),
                "metric": statistics.spread(_known(metric)),
            }
            for variant, of, metric in zip(sweep.variants, runs, values, strict=True)
        }
    }
    if len(runs) > 1:
        first, second, *_ = values
        with np.errstate(divide="ignore", invalid="ignore"):
            changes = _known(100 * (second - first) / first)
        paired_p = statistics.paired_p(changes)
        found["change_percent"] = {**statistics.spread(changes), "paired_p": paired_p}
    return found


def metric_of(summary: Mapping[str, object], name: str) -> float:
    """Return a metric by its dotted name; NaN where it is lacking, or the run before its end."""
    value = leaves(summary).get(name) if survived(summary) else None
    return float(value) if isinstance(value, (int, float)) else np.nan


def _known(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _widest(content: Mapping) -> float:
    """Return the width of the widest interval of a share (percentage points)."""
    shares = (v["survived"] for point in content["points"] for v in point["variants"].values())
    return 100 * max(share["high"] - share["low"] for share in shares)


def unit_of(key: str) -> str:
    """Return the unit of a key, empty if it has none."""
    name = re.sub(r"[.\[](\d+)\]?", "[]", key)
    try:
        return next((s.unit for s in settings(name) if s.key == name), "").strip("-")
    except ScenarioError:
        return ""
