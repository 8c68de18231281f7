"""Landings of made-up steps whose times are known, and how a figure marks them."""

import numpy as np
import pytest

from lola_drake.contact_events import landings, surprises
from lola_drake.figures.variants_figure import variants_figure
from lola_drake.reports.payload import events
from lola_drake.scenario import Scenario
from lola_drake.signals import CONTACT, FEET

LIFT_OFFS = (1.2, 2.0, 2.8)
"""Of the made-up walk: left, right, left."""

PATTERN = Scenario().pattern
SWING = PATTERN.step_time - PATTERN.double_support


@pytest.fixture
def walk(make_result):
    """Return a function that makes a walk of three steps, each landing late by so much (s)."""

    def make(*delays, variant="dyn", **changes):
        result = make_result(Scenario(variant=variant), steps=3, **changes)
        contact = result.signals["contact"]
        contact[:] = 1.0
        for k, (lift_off, delay) in enumerate(zip(LIFT_OFFS, delays, strict=True)):
            swinging = (result.times > lift_off + 0.02) & (result.times < lift_off + SWING + delay)
            contact[swinging, CONTACT.slice(f"pads_{FEET[k % 2]}")] = 0.0
        return result

    return make


def test_landings_are_told_by_foot_and_time(walk):
    found = landings(walk(0.0, 0.2, -0.1))
    assert [landing.foot for landing in found] == ["l", "r", "l"]
    assert [landing.kind for landing in found] == ["punctual", "late", "early"]
    planned = np.array(LIFT_OFFS) + SWING
    assert [landing.planned for landing in found] == pytest.approx(planned, abs=2e-3)
    delays = [landing.measured - landing.planned for landing in found]
    assert delays == pytest.approx([0.0, 0.2, -0.1], abs=3e-3)


def test_one_pad_is_a_landing_and_a_bounce_is_not_another(walk):
    result = walk(0.0, 0.0, 0.0)
    right = CONTACT.slice("pads_r")
    early = (result.times > 2.38) & (result.times < 2.4)
    result.signals["contact"][early, right.start + 2] = 1.0
    found = landings(result)
    assert len(found) == 3
    assert found[1].measured == pytest.approx(2.38, abs=2e-3)


def test_a_touch_just_after_lift_off_is_none(walk):
    result = walk(0.0, 0.0, 0.0)
    result.signals["contact"][(result.times > 2.05) & (result.times < 2.1)] = 1.0
    assert [landing.kind for landing in landings(result)] == ["punctual"] * 3


def test_a_foot_that_never_lands_is_left_out(walk):
    result = walk(0.0, 0.0, 0.0)
    result.signals["contact"][result.times > 2.9, CONTACT.slice("pads_l")] = 0.0
    assert [landing.foot for landing in landings(result)] == ["l", "r"]


def test_a_surprise_is_the_same_landing_in_every_run(walk):
    """One run alone was late at the first step; its second is not held against that."""
    late_twice, late_once = walk(0.1, 0.2, 0.0, variant="ref"), walk(0.0, 0.15, 0.0)
    ((first, second),) = surprises([late_twice, late_once])
    assert first.foot == second.foot == "r"
    assert first.planned == second.planned == pytest.approx(LIFT_OFFS[1] + SWING, abs=2e-3)
    texts = variants_figure([late_twice, late_once]).axes[0].texts
    assert [text.get_text() for text in texts] == ["right foot late"]
    (event,) = events([late_twice, late_once])
    assert event["planned"] == first.planned and event["time"] == first.measured


def test_the_figure_shows_what_was_not_expected(walk):
    figure = variants_figure([walk(0.0, 0.2, 0.0, variant="ref"), walk(0.0, 0.15, 0.0)])
    axes = figure.axes
    assert [text.get_text() for text in axes[0].texts] == ["right foot late"]
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == ["ref", "dyn"]
    assert axes[0].get_xlim() == pytest.approx((2.0 + SWING - 1.0, 4.4), abs=3e-3)


def test_without_surprises_the_figure_shows_the_whole_run(walk):
    figure = variants_figure([walk(0.0, 0.0, 0.0, variant="ref"), walk(0.0, 0.0, 0.0)])
    assert not figure.axes[0].texts
    assert figure.axes[0].get_xlim() == pytest.approx((0.0, 4.4), abs=3e-3)


def test_who_falls_does_not_set_the_scale(walk):
    ref, dyn = walk(0.0, 0.2, 0.0, variant="ref", fall_time=4.0), walk(0.0, 0.2, 0.0)
    dyn.signals["torso_pose"][3000:3300, 4] = np.radians(2.0)
    ref.signals["torso_pose"][3000:, 4] = np.radians(44.0)
    figure = variants_figure([ref, dyn])
    assert figure.axes[1].get_ylim()[1] == pytest.approx(2.6)
    assert "fell at 4.0 s" in figure.axes[0].get_legend().get_texts()[0].get_text()


def test_a_foot_that_never_lifts_off_never_lands(make_result):
    assert landings(make_result(steps=0)) == []
