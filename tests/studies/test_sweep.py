"""Sweeps of made-up runs whose outcome is known."""

import json

import numpy as np
import pytest

from lola_drake.scenario import ScenarioError, load_scenario
from lola_drake.studies.designs import points
from lola_drake.studies.factors import SweepError, parse_factors
from lola_drake.studies.stopping import parse_width, until
from lola_drake.studies.sweep import FIRST_SEED, Sweep, run_sweep, unit_of
from lola_drake.studies.sweep_figure import sweep_figure
from lola_drake.studies.sweep_table import sweep_table

HEIGHT = "ground.obstacles.0.height"
DELTA = "control.force.time_constant"


class Known:
    """Stands for a study: `ref` falls from 8 cm on, and inclines twice as much as `dyn`."""

    def __init__(self):
        self.scenarios, self.store = [], self
        self.file = "runs.sqlite"

    def numbers(self, keys):
        return {key: number for number, key in enumerate(keys, 1)}

    def run(self, scenarios, progress=None):
        self.scenarios = scenarios
        return [self._summary(scenario) for scenario in scenarios]

    @staticmethod
    def _summary(scenario):
        height = scenario.ground.obstacles[0].height
        ref = scenario.variant == "ref"
        fell = ref and height >= 0.08
        inclined = 100 * height * (2 if ref else 1) + 0.001 * (scenario.seed % 7)
        late = {"time_s": 2.0, "event": "late contact of the left foot"}
        return {
            "variant": scenario.variant,
            "seed": scenario.seed,
            "fell": fell,
            "fall_time_s": 3.0 if fell else None,
            "fall_events": [late] if fell else [],
            "error": None,
            "max_inclination_deg": {"x": 0.0, "y": inclined},
        }


def made(*texts, design="grid", count=None, **options):
    base = load_scenario("step_down")
    factors = parse_factors(texts, base)
    at = points(factors, design, count, runs=2)
    return Sweep(base, factors, at, design=design, **options)


@pytest.fixture(scope="module")
def content():
    return run_sweep(Known(), made(f"{HEIGHT}=0.06,0.08"), worlds=20)


def test_every_variant_meets_the_same_worlds_at_every_point():
    sweep, study = made(f"{HEIGHT}=0.06,0.08"), Known()
    run_sweep(study, sweep, worlds=3)
    assert len(study.scenarios) == 3 * sweep.runs_per_world == 12
    first = [(s.seed, s.ground.obstacles[0].height, s.variant) for s in study.scenarios[:4]]
    assert first == [
        (FIRST_SEED, height, variant) for height in (0.06, 0.08) for variant in ("ref", "dyn")
    ]
    places = {(s.seed, s.ground.friction, s.ground.obstacles[0].position) for s in study.scenarios}
    assert len(places) == 3


def test_without_worlds_there_is_the_scenario_as_it_is_written():
    sweep = made(f"{HEIGHT}=0.06,0.08", variants=("dyn",))
    assert [s.ground.obstacles[0].height for s in sweep.scenarios(0)] == [0.06, 0.08]
    assert {s.seed for s in sweep.scenarios(0)} == {0}


def test_who_survives_is_counted_at_every_point(content):
    low, high = content["points"]
    assert low["values"] == {HEIGHT: 0.06} and high["values"] == {HEIGHT: 0.08}
    assert high["variants"]["ref"]["survived"]["share"] == 0.0
    assert high["variants"]["ref"]["falls"] == 20
    assert high["variants"]["dyn"]["survived"]["share"] == 1.0
    assert low["variants"]["ref"]["survived"]["low"] == pytest.approx(0.8389, abs=1e-4)


def test_the_metric_is_that_of_those_who_stay_up(content):
    low, high = content["points"]
    assert low["variants"]["ref"]["metric"]["median"] == pytest.approx(12.0, abs=0.01)
    assert low["change_percent"]["median"] == pytest.approx(-50.0, abs=0.1)
    assert low["change_percent"]["paired_p"] < 1e-4
    first, last = low["change_percent"]["interval_95"]
    assert first <= low["change_percent"]["median"] <= last
    assert high["variants"]["ref"]["metric"]["median"] is None
    assert high["change_percent"]["median"] is None
    json.dumps(content, allow_nan=False)


def test_falls_are_explained_and_the_worst_runs_can_be_run_again(content):
    assert content["causes"] == {"ref": {"late contact of the left foot": 20}, "dyn": {}}
    assert [run["variant"] for run in content["worst"]] == ["ref"] * 10
    assert content["worst"][0]["command"] == "lola study replay runs.sqlite 1"


def test_fewer_worlds_are_enough_for_a_wide_interval():
    study = Known()
    content = run_sweep(study, made(f"{HEIGHT}=0.06,0.08"), worlds=500, width=20.0)
    assert content["worlds"] == 22
    shares = [v["survived"] for point in content["points"] for v in point["variants"].values()]
    assert max(share["high"] - share["low"] for share in shares) <= 0.2


def test_stopping_looks_at_growing_numbers_and_keeps_the_most():
    seen = []

    def measure(worlds):
        seen.append(worlds)
        return worlds, 100 / worlds

    assert until(None, 7, measure) == 7
    assert until(5.0, 1000, measure) == 22
    assert until(1.0, 30, measure) == 30
    assert seen == [7, 10, 15, 22, 10, 15, 22, 30]
    assert (parse_width("2%"), parse_width("2.5")) == (2.0, 2.5)


@pytest.mark.parametrize(
    ("texts", "worlds", "message"),
    [
        (
            ["ground.friction=0.6:0.9:3"],
            2,
            "ground.friction: makes no difference here, it is drawn",
        ),
        (["seed=1,2"], 2, "seed: makes no difference here"),
        (["variant=ref,dyn"], 0, "variant: makes no difference here, --variants say it"),
    ],
)
def test_a_key_that_makes_no_difference_is_refused(texts, worlds, message):
    with pytest.raises(SweepError, match=message):
        made(*texts).check(worlds)


def test_what_the_world_scales_makes_a_difference():
    made("ground.stiffness=1e6:2e6:2", f"{HEIGHT}=0.05,0.06").check(2)
    made("ground.friction=0.6:0.9:3").check(0)


def test_a_point_that_cannot_be_is_named():
    sweep = made("pattern.step_time=0.8,0.9", "pattern.double_support=0.3,0.85")
    with pytest.raises(ScenarioError, match=r"the point pattern.step_time=0.8.*support=0.85"):
        sweep.check(0)


@pytest.mark.parametrize("options", [{"metric": "speed"}, {"variants": ("ref", "ref")}])
def test_other_metrics_and_variants_are_refused(options):
    with pytest.raises(SweepError, match="metric: 'speed', there are max_|all be different"):
        made(f"{HEIGHT}=0.06,0.08", **options)


def test_units_are_those_of_the_settings():
    assert unit_of(HEIGHT) == "m"
    assert unit_of(DELTA) == "s"
    assert unit_of("pattern.phase_reset") == unit_of("no.such.key") == ""


def test_one_key_is_curves(content):
    survived, metric = sweep_figure(content).axes
    assert survived.get_xlabel() == f"{HEIGHT} (m)"
    assert list(survived.lines[0].get_ydata()) == [100.0, 0.0]
    assert np.isnan(metric.lines[0].get_ydata()[1])


def test_two_keys_are_maps_with_the_first_along_x():
    wanted = made(f"{HEIGHT}=0.04,0.06,0.08", f"{DELTA}=0.02,0.03")
    figure = sweep_figure(run_sweep(Known(), wanted, worlds=0))
    ref = figure.axes[0].images[0].get_array()
    assert ref.shape == (2, 3)
    assert ref.tolist() == [[100.0, 100.0, 0.0]] * 2
    dyn = figure.axes[3].images[0].get_array()
    assert list(dyn[0]) == pytest.approx([4.0, 6.0, 8.0], abs=0.01)


def test_spread_points_are_drawn_over_each_key():
    wanted = made(f"{HEIGHT}=0.04:0.08", f"{DELTA}=0.02:0.03", design="latin", count=8)
    figure = sweep_figure(run_sweep(Known(), wanted, worlds=0))
    assert len(figure.axes) == 2


def test_the_table_has_a_row_for_each_point(content):
    table = sweep_table(content)
    assert table.row_count == 2 and len(table.columns) == 6
    assert "ref fell 20 times, first: late contact of the left foot" in table.caption
