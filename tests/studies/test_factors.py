"""What a sweep varies: read as it is written, refused in one line where it cannot be."""

import pytest

from lola_drake.errors import LolaError
from lola_drake.scenario import load_scenario
from lola_drake.studies.designs import MOST_RUNS, points
from lola_drake.studies.factors import Factor, SweepError, parse_factors

BASE = load_scenario("step_down")
FRICTION = Factor("ground.friction", (0.4, 0.8), is_range=True)
TICKS = Factor("sensors.imu.delay_ticks", (1, 4), is_range=True, is_whole=True)
LAWS = Factor("pattern.phase_reset", (True, False))


def parsed(*texts):
    return parse_factors(texts, BASE)


def test_a_range_has_so_many_values_and_both_ends():
    (factor,) = parsed("ground.friction=0.1:0.3:3")
    assert factor.values == (0.1, 0.2, 0.3) and not factor.is_range
    (factor,) = parsed("sensors.imu.delay_ticks=1:5:3")
    assert factor.values == (1, 3, 5)
    assert all(isinstance(value, int) for value in factor.values)


def test_a_list_has_values_of_any_kind():
    (factor,) = parsed("pattern.phase_reset=true,false")
    assert factor.values == (True, False)
    (steps,) = parsed("walk.steps=[{count: 2}],[{count: 3, length: 0.2}]")
    assert steps.values[1] == [{"count": 3, "length": 0.2}]


def test_a_key_in_a_list_can_be_varied():
    (factor,) = parsed("ground.obstacles.0.height=0.03:0.05:2")
    assert factor.values == (0.03, 0.05)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ([], "nothing to sweep over"),
        (["ground.friction"], "not of the form KEY=FROM:TO:N"),
        (["ground.friction="], "not of the form KEY=FROM:TO:N"),
        (["ground.fricton=1,2"], "did you mean friction"),
        (["ground.friction=0.5:0.4:3"], "from a number to a larger one"),
        (["ground.friction=a:b:3"], "all of them numbers"),
        (["ground.friction=0.1:0.2:3:4"], "all of them numbers"),
        (["ground.friction=0.1:0.2:1"], "from 2 to 10,000 values"),
        (["ground.friction=0.1:0.2:2.5"], "from 2 to 10,000 values"),
        (["ground.friction=0.1:0.2:100000"], "from 2 to 10,000 values"),
        (["ground.friction=0.1:.inf:3"], "all of them numbers"),
        (["ground.friction=0.5,0.5"], "all different"),
        (["ground.friction=0.5,[["], "is no list of values"),
        (["sensors.imu.delay_ticks=1:2:3"], "are not whole numbers"),
        (["sensors.imu.delay_ticks=1:2.5"], "from a whole number to another"),
        (["ground.friction=0.5,0.6", "ground.friction=0.1:0.2:2"], "varied twice"),
    ],
)
def test_what_cannot_be_varied_is_one_line(texts, message):
    with pytest.raises(LolaError, match=message) as error:
        parsed(*texts)
    assert "\n" not in str(error.value)


def test_a_grid_has_every_combination_and_the_first_key_changes_last():
    factors = parsed("ground.friction=0.5,0.6", "sensors.imu.delay_ticks=1:3:3")
    found = [tuple(point.values()) for point in points(factors, "grid", None, runs=2)]
    assert found == [(0.5, 1), (0.5, 2), (0.5, 3), (0.6, 1), (0.6, 2), (0.6, 3)]


@pytest.mark.parametrize("design", ["latin", "sobol"])
def test_spread_points_fill_every_factor_and_are_the_same_again(design):
    found = points([FRICTION, TICKS, LAWS], design, 64, runs=2)
    assert found == points([FRICTION, TICKS, LAWS], design, 64, runs=2)
    friction = sorted(point["ground.friction"] for point in found)
    assert all(
        abs(value - 0.4 - 0.4 * (k + 0.5) / 64) < 0.4 / 64 for k, value in enumerate(friction)
    )
    ticks = [point["sensors.imu.delay_ticks"] for point in found]
    assert {ticks.count(k) for k in (1, 2, 3, 4)} == {16}
    assert [point["pattern.phase_reset"] for point in found].count(True) == 32


@pytest.mark.parametrize(
    ("factors", "design", "count", "message"),
    [
        ([FRICTION], "best", None, "design: 'best', there are grid, latin, sobol"),
        ([FRICTION], "grid", None, r"a grid needs their number, 0\.4:0\.8:N"),
        ([LAWS], "grid", 8, "--points is for"),
        ([FRICTION], "latin", None, "needs a number of points"),
        ([FRICTION], "sobol", 1, "at least 2"),
        ([FRICTION], "sobol", MOST_RUNS, "more than 100,000 runs"),
        ([Factor(key, tuple(range(3163))) for key in "ab"], "grid", None, "10,004,569 points"),
    ],
)
def test_a_design_that_cannot_be_is_one_line(factors, design, count, message):
    with pytest.raises(SweepError, match=message):
        points(factors, design, count, runs=2)
