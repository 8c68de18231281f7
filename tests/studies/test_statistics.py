"""Statistics of many runs against numbers known from elsewhere."""

import pytest

from lola_drake.studies.statistics import share


@pytest.mark.parametrize(("fallen", "low", "high"), [(0, 0.8389, 1.0), (10, 0.2993, 0.7007)])
def test_the_interval_is_wilsons(fallen, low, high):
    point = share([{"fell": k < fallen} for k in range(20)])
    assert point["share"] == 1 - fallen / 20
    assert (point["low"], point["high"]) == pytest.approx((low, high), abs=1e-4)


def test_who_fails_does_not_survive():
    runs = [{"fell": False, "error": None}, {"fell": False, "error": "no number"}]
    assert share(runs)["share"] == 0.5
