"""The polar plot of pushes."""

import numpy as np
import pytest

from lola_drake.studies.push_figure import push_figure


def evaluation(law, half):
    """Return an evaluation whose variants fall at a push, of directions in any order."""
    trials = {"board": {"direction_deg": None}}
    for direction in (180, 0, 270, 90):
        curve = [{"size": 6}, {"size": 40}]
        trial = {"unit": "Ns", "direction_deg": direction, "curves": {"ref": curve, "dyn": curve}}
        trials[f"push, {direction}"] = {
            **trial,
            "half": {"ref": 10.0 + direction / 90, "dyn": half},
        }
    return {"law": law, "margins": {"ref": {}, "dyn": {}}, "trials": trials}


def test_a_law_has_a_plot_and_each_of_its_settings_a_line():
    changed = "hybrid pattern.step_adaptation=true"
    figure = push_figure([evaluation(law, 20.0) for law in ("hybrid", changed, "damping")])
    first, second = figure.axes
    assert [ax.get_title("left") for ax in (first, second)] == ["hybrid", "damping"]
    assert len(first.lines) == 4 and len(second.lines) == 2
    names = [text.get_text() for text in figure.legends[0].texts]
    assert names == ["ref", "dyn", *(f"{v}, pattern.step_adaptation=true" for v in ("ref", "dyn"))]


def test_directions_are_in_their_order_and_forward_is_up_and_left_is_left():
    (ax,) = push_figure([evaluation("hybrid", 20.0)]).axes
    angles, reach = ax.lines[0].get_data()
    assert np.degrees(angles) == pytest.approx([0, 90, 180, 270, 0])
    assert reach == pytest.approx([10, 11, 12, 13, 10])
    assert ax.get_theta_offset() == pytest.approx(np.pi / 2) and ax.get_theta_direction() == 1


def test_what_nothing_felled_is_drawn_at_the_largest_that_was_tried():
    (ax,) = push_figure([evaluation("hybrid", None)]).axes
    assert ax.lines[1].get_data()[1] == pytest.approx([40] * 5)
    assert ax.get_rmax() == pytest.approx(42)
    ref, dyn = (rings.get_facecolor() for rings in ax.collections)
    assert (dyn[:, :3] == 1).all() and (ref[:, :3] != 1).any()


def test_two_directions_make_no_plot():
    few = evaluation("hybrid", 20.0)
    few["trials"] = dict(list(few["trials"].items())[:3])
    assert push_figure([few]) is None
