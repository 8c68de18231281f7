"""Who stays up: the share of sampled worlds survived, over the height of an edge or a board.

A percentage of inclination says little about two controllers of which one is about to fall. This
says from where on each of them does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lola_drake.results import software_versions
from lola_drake.scenario import Scenario, load_scenario, override
from lola_drake.studies.row import Summary
from lola_drake.studies.sampled_worlds import sample_world
from lola_drake.studies.statistics import causes, share
from lola_drake.studies.stopping import until
from lola_drake.studies.study import Progress, Study

HEIGHTS = tuple(round(0.03 + 0.01 * k, 2) for k in range(10))
"""Of the edge or the board (m)."""

VARIANTS = ("ref", "dyn")

FIRST_SEED = 2000
"""Of the worlds: those of tuning begin at 1000, those of the reproduction at 0."""


@dataclass(frozen=True)
class Obstacle:
    """What grows.

    Attributes:
        title: what it is.
        scenario: the scenario that has it as its first obstacle.
    """

    title: str
    scenario: str

    def runs(self, height: float, seeds: Sequence[int]) -> list[Scenario]:
        """Return the runs at a height (m): every variant in the world of every seed."""
        base = load_scenario(self.scenario, {"ground.obstacles.0.height": height})
        worlds = [sample_world(base, seed) for seed in seeds]
        return [override(world, {"variant": name}) for name in VARIANTS for world in worlds]


OBSTACLES = {
    "edge": Obstacle("unseen edge, down", "step_down"),
    "board": Obstacle("unseen board, up and down again", "board_9cm"),
}


def survival(
    study: Study,
    samples: int,
    progress: Progress | None = None,
    heights: Sequence[float] = HEIGHTS,
    width: float | None = None,
) -> dict[str, object]:
    """Return the content of survival.json.

    Args:
        study: what keeps and makes the runs.
        samples: number of worlds at each height.
        progress: called with the number of runs that are done.
        heights: of the obstacles (m).
        width: of all intervals of the shares, with which fewer worlds are enough (percentage
            points), see `until`.
    """

    def measure(count: int) -> tuple[dict[str, object], float]:
        content = _content(study, count, progress, heights)
        shares = [
            point
            for variants in content["survived"].values()
            for points in variants.values()
            for point in points
        ]
        return content, 100 * max(point["high"] - point["low"] for point in shares)

    return until(width, samples, measure)


def _content(
    study: Study, samples: int, progress: Progress | None, heights: Sequence[float]
) -> dict[str, Any]:
    seeds = range(FIRST_SEED, FIRST_SEED + samples)
    # Height by height, so that a study that is stopped has whole points.
    wanted = [(name, height) for height in heights for name in OBSTACLES]
    scenarios = [run for name, height in wanted for run in OBSTACLES[name].runs(height, seeds)]
    summaries = study.run(scenarios, progress)
    size = len(VARIANTS) * samples
    points = {point: summaries[i * size : (i + 1) * size] for i, point in enumerate(wanted)}

    def of(name: str, k: int, height: float) -> list[Summary]:
        return points[name, height][k * samples : (k + 1) * samples]

    return {
        "worlds": samples,
        "heights_m": list(heights),
        "survived": {
            name: {
                variant: [share(of(name, k, height)) for height in heights]
                for k, variant in enumerate(VARIANTS)
            }
            for name in OBSTACLES
        },
        "causes_of_falls": {
            name: {
                variant: causes([run for height in heights for run in of(name, k, height)])
                for k, variant in enumerate(VARIANTS)
            }
            for name in OBSTACLES
        },
        "versions": software_versions(),
    }
