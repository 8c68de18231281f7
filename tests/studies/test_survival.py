"""Who stays up: which runs are made, and what is counted."""

import pytest

from lola_drake.studies import survival as module
from lola_drake.studies.reproduction import EXPERIMENTS
from lola_drake.studies.survival import OBSTACLES, VARIANTS, survival
from lola_drake.studies.survival_figure import survival_figure
from lola_drake.studies.tables import survival_table
from lola_drake.studies.tuning import tuning_scenarios


class Falling:
    """Stands for a study: ref falls from 5 cm on, dyn from 7 cm on the board alone."""

    def __init__(self):
        self.scenarios = []

    def run(self, scenarios, progress):
        self.scenarios = scenarios
        return [{"fell": self._falls(scenario)} for scenario in scenarios]

    @staticmethod
    def _falls(scenario):
        height = scenario.ground.obstacles[0].height
        if scenario.variant == "ref":
            return height >= 0.05
        return height >= 0.07 and scenario.name == "board_9cm"


@pytest.fixture
def content():
    return survival(Falling(), samples=3, heights=(0.04, 0.06, 0.08))


def test_every_height_variant_and_obstacle_is_counted_by_itself(content):
    shares = {
        (name, variant): [point["share"] for point in points]
        for name, variants in content["survived"].items()
        for variant, points in variants.items()
    }
    assert shares == {
        ("edge", "ref"): [1.0, 0.0, 0.0],
        ("edge", "dyn"): [1.0, 1.0, 1.0],
        ("board", "ref"): [1.0, 0.0, 0.0],
        ("board", "dyn"): [1.0, 1.0, 0.0],
    }


def test_both_variants_meet_the_same_worlds_and_no_others_know_them():
    study = Falling()
    survival(study, samples=2, heights=(0.05,))
    worlds = {v: [s.ground for s in study.scenarios if s.variant == v] for v in VARIANTS}
    assert worlds["ref"] == worlds["dyn"] and len(worlds["ref"]) == 2 * len(OBSTACLES)
    seeds = {scenario.seed for scenario in study.scenarios}
    assert not seeds & {run.seed for run in tuning_scenarios({}, samples=50)}
    assert not seeds & {run.seed for e in EXPERIMENTS for k in range(500) for run in e.scenarios(k)}


def test_table_and_figure_show_all(content):
    table = survival_table(content)
    assert table.row_count == 3 and len(table.columns) == 5
    axes = survival_figure(content).axes
    assert [len(ax.lines) for ax in axes] == [2, 2]
    assert list(axes[0].lines[0].get_ydata()) == [100.0, 0.0, 0.0]
    assert module.HEIGHTS[0] == 0.03 and module.HEIGHTS[-1] == 0.12
