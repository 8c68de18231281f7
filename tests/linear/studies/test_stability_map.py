"""Stability over parameters, the flexible torso, and what a workpoint recomputes."""

import numpy as np
import pytest

import lola_drake as lola
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.poles import spectral_radius
from lola_drake.linear.presentation.study_figures import map_figure
from lola_drake.linear.studies.bisection import stable_spans
from lola_drake.linear.studies.flexible_torso import FlexibleTorso, with_torso
from lola_drake.linear.studies.map_kinds import (
    DELTA,
    GAIN,
    MAPS,
    SETTINGS,
    Axis,
    MapKind,
    map_kind,
)
from lola_drake.linear.studies.stability_border import predicted_border
from lola_drake.linear.studies.stability_map import (
    AtSetting,
    StabilityMap,
    finer,
    growth_rate,
    growth_rates,
    largest_share,
    stability_map,
)
from lola_drake.linear.studies.workpoint import make_workpoint

SIGNALS = ("torso_orientation", "measured_wrench")


@pytest.fixture(scope="module")
def workpoint(standing):
    return make_workpoint(lola.load_scenario("stand"), "stand", SIGNALS, SIGNALS, standing)


@pytest.mark.parametrize(
    "changes",
    [
        {DELTA: 0.03, "control.stabilizer.damping": 100.0},
        {"sensors.imu.delay_ticks": 6, "control.servos.delay_ticks": 4},
    ],
)
def test_turning_a_parameter_is_the_same_as_building_with_it(workpoint, changes):
    """Only the blocks the parameter belongs to are linearised again, at the same point."""
    varied = workpoint.varied(changes)
    anew = make_workpoint(lola.load_scenario("stand", changes), "stand", SIGNALS, SIGNALS)
    z = [np.sort(np.abs(np.linalg.eigvals(with_torso(b, None).A))) for b in (varied, anew)]
    np.testing.assert_allclose(z[0][-60:], z[1][-60:], atol=2e-4)


def test_a_parameter_that_moves_the_equilibrium_finds_it_again(workpoint):
    soft = workpoint.varied({"ground.stiffness": 1.5e5})
    assert soft.situation is not workpoint.situation
    assert soft.situation.residual < 1e-6


def test_a_stiff_torso_is_a_rigid_one(workpoint):
    rigid, stiff = (
        spectral_radius(with_torso(workpoint, torso).A)
        for torso in (None, FlexibleTorso(300.0, 0.7))
    )
    assert stiff == pytest.approx(rigid, abs=1e-6)
    unseen = spectral_radius(with_torso(workpoint, FlexibleTorso(12.0, 0.05, share=0.0)).A)
    assert unseen == pytest.approx(rigid, abs=1e-9)


def test_a_torso_that_swings_can_make_standing_unstable(workpoint):
    """As on the robot (V.B): the mode reaches the IMU and the loop closes around it."""
    assert growth_rate(workpoint) < 0
    assert growth_rate(workpoint, FlexibleTorso(15.0, 0.05)) > 0


def test_a_map_says_where_it_is_stable():
    kind = MapKind(
        "delta and g_a",
        Axis(DELTA, (0.0015, 0.03), "delta (ms)", 1e3),
        Axis(GAIN, (0.0, 1.0), "g_a"),
        "stand",
    )
    result = stability_map(kind, lola.load_scenario("stand"), jobs=2)
    assert (result.growth[:, 0] > 0).all()
    assert (result.growth[:, 1] < 0).all()
    assert (result.disk[:, 0] == 0).all()
    assert (result.disk[:, 1] > 0.2).all()
    assert "to 30" in result.as_text()
    for spans in result.spans[""]:
        ((border, last),) = spans
        assert last == 0.03
        assert border == pytest.approx(0.0029, abs=0.0005), "found between the map's two points"
    assert result.as_numbers()["growth_per_s"][0][0] > 0
    assert result.settings["simulation"].growth < 0


def test_the_ends_of_what_is_stable_are_found_between_the_points_of_a_map():
    values = np.array([0.0, 2.0, 4.0, 6.0])
    stable = np.abs(values - 3.0) < 1.7
    ((low, high),) = stable_spans(values, stable, lambda x: abs(x - 3.0) < 1.7)
    assert (low, high) == (pytest.approx(1.3, rel=0.005), pytest.approx(4.7, rel=0.005))
    assert abs(low - 3.0) < 1.7 > abs(high - 3.0)


def test_whole_numbers_stay_whole():
    assert stable_spans((1, 5, 12), np.array([1, 1, 0]) > 0, lambda x: x < 6.5) == [(1, 6)]


def test_the_maps_border_is_where_bisection_finds_it(workpoint):
    """Slow and fast motions are interpolated apart: the one hides where the other tips over."""
    deltas = np.array([delta for delta in MAPS["gains"].x.values if 0.002 < delta < 0.006])
    rates = np.array([growth_rates(workpoint.varied({DELTA: delta})) for delta in deltas])
    fast = finer(rates[:, 1])
    border = np.interp(0.0, -fast, finer(deltas))
    assert border == pytest.approx(predicted_border(workpoint), rel=0.02)
    assert (rates[:, 0] < 0).all()


@pytest.mark.parametrize("torso", [None, FlexibleTorso(12.0, 0.05, 0.5)])
def test_the_loop_of_the_margin_closes_to_the_whole(workpoint, torso):
    opened = with_torso(workpoint, torso, workpoint.select(["measured_wrench"]))
    closed = opened.A + opened.B @ np.linalg.inv(np.eye(12) - opened.D) @ opened.C
    whole = with_torso(workpoint, torso).A
    assert spectral_radius(closed) == pytest.approx(spectral_radius(whole), abs=1e-9)


def test_the_largest_share_of_the_mode_is_on_the_border(workpoint):
    torso = FlexibleTorso(15.0, 0.05)
    share = largest_share(workpoint, torso)
    assert 0 < share < 1
    assert growth_rate(workpoint, FlexibleTorso(15.0, 0.05, share)) < 0
    assert growth_rate(workpoint, FlexibleTorso(15.0, 0.05, share + 0.01)) > 0


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("torso", [None, FlexibleTorso(12.0, 0.05, 0.7)])
def test_a_map_has_a_picture_and_a_text(name, torso):
    kind = map_kind(name)
    rates = np.zeros((2, len(kind.y.values), len(kind.x.values)))
    rates[0], rates[1] = -0.1, np.linspace(50.0, -50.0, rates.shape[2])
    rates[:, 0] = np.nan  # no equilibrium there
    settings = dict.fromkeys(SETTINGS, AtSetting(-0.1, 0.5 if torso else None))
    result = StabilityMap(
        kind,
        "left",
        lola.load_scenario("stand"),
        torso,
        rates,
        0.5 * np.ones(rates.shape[1:]),
        settings,
        dict.fromkeys(SETTINGS, rates),
        dict.fromkeys(["", *SETTINGS], [[(kind.x.values[3], kind.x.values[-1])], *[[]] * 20]),
    )
    figure = map_figure(result)
    figure.draw_without_rendering()
    assert len(figure.axes) == 4
    for label in figure.axes[0].texts:
        ends = label.get_window_extent().intervalx
        assert figure.axes[0].bbox.x0 <= min(ends) and max(ends) <= figure.axes[0].bbox.x1
    assert "nowhere" in result.as_text()
    assert ("up to a share" in result.as_text()) == bool(torso)


def test_a_map_that_does_not_exist_is_one_clear_error():
    with pytest.raises(AnalysisError, match="no map 'gain', did you mean gains?"):
        map_kind("gain")
