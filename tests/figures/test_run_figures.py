"""The figures of a run: what they show, and where things are from above."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from lola_drake.figures.comparison import labels
from lola_drake.figures.footprints import (
    planned_footsteps,
    pressure_point,
    sole_corners,
    stances,
    to_world,
    zero_moment_point,
)
from lola_drake.figures.run_figures import FIGURES, figure_bytes
from lola_drake.figures.style import intervals, look, plot
from lola_drake.scenario import Scenario, override
from lola_drake.signals import CONTACT_WRENCH, PLANNED_MOTION


@pytest.fixture
def result(make_result):
    return make_result(steps=2)


def set_wrench(result, foot, T_x, T_y, F_z):
    wrench = CONTACT_WRENCH.slice("wrench")
    result.signals[f"contact_wrench_{foot}"][:, wrench] = (T_x, T_y, F_z)


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_has_units_and_the_gait_under_its_time_axis(result, name):
    with look():
        figure = FIGURES[name](result)
    if name in ("foot_pressure", "phase_portrait"):
        units = {(ax.get_xlabel(), ax.get_ylabel()) for ax in figure.axes}
        assert units <= {("to the right (m)", "forward (m)"), ("φ (deg)", "dφ/dt (deg/s)")}
        return
    below = [ax for ax in figure.axes if ax.get_xlabel() == "time (s)"]
    if name == "footprints":
        (axes,) = figure.axes
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")
        return
    assert below and all(ax.get_yticklabels()[0].get_text() == "L" for ax in below)
    titles = figure.get_suptitle() + "".join(ax.get_ylabel() for ax in figure.axes)
    assert any(unit in titles for unit in ("(deg)", "(N)", "(Nm)", "(cm)", "(mm)", "(m)"))


def test_the_same_run_gives_the_same_svg(result):
    first, second = (figure_bytes(FIGURES["footprints"](result), "svg") for _ in range(2))
    assert first == second
    ElementTree.fromstring(first)


def test_a_fall_is_written_on_the_figure(make_result):
    fallen = make_result(steps=1, completed=False, fall_time=1.5)
    assert b"fell at 1.50 s" in figure_bytes(FIGURES["inclination"](fallen), "svg")


def test_thinning_keeps_extremes():
    from matplotlib.figure import Figure

    times = np.arange(20000) / 1000
    values = np.zeros(len(times))
    values[12345], values[777] = 5.0, -3.0
    axes = Figure().add_subplot()
    plot(axes, times, values)
    x, y = axes.lines[0].get_data()
    assert len(x) < 3000 and np.all(np.diff(x) >= 0)
    assert y.max() == 5.0 and y.min() == -3.0 and x[y.argmax()] == 12.345


def test_intervals_of_time():
    times = np.arange(6) / 10
    true = np.array([True, True, False, True, False, True])
    assert np.array(intervals(times, true)) == pytest.approx(
        np.array([(0.0, 0.2), (0.3, 0.1), (0.5, 0.0)])
    )


def test_pressure_acts_where_force_and_torque_say(result):
    result.signals["foot_pose_l"][:, :2] = (1.0, 0.1)
    set_wrench(result, "l", T_x=6.0, T_y=-12.0, F_z=300.0)
    # A force at (x, y) from the TCP has the torques T_x = y F_z and T_y = -x F_z.
    assert pressure_point(result.signals, "l")[0] == pytest.approx([1.04, 0.12])
    result.signals["torso_pose"][:, 5] = np.pi / 2
    assert pressure_point(result.signals, "l")[0] == pytest.approx([0.98, 0.14])


def test_the_zmp_lies_between_the_feet_by_their_loads(result):
    for foot, y in (("l", 0.1), ("r", -0.1)):
        result.signals[f"foot_pose_{foot}"][:, :2] = (0.5, y)
    set_wrench(result, "l", 0.0, 0.0, 150.0)
    set_wrench(result, "r", 0.0, 0.0, 450.0)
    assert zero_moment_point(result.signals)[0] == pytest.approx([0.5, -0.05])
    for foot in "lr":
        set_wrench(result, foot, 0.0, 0.0, 5.0)
    assert np.isnan(zero_moment_point(result.signals)).all()


def test_footprints_are_taken_once_per_stance(make_result):
    walk = make_result(steps=4)
    assert len(stances(walk, "l")) + len(stances(walk, "r")) == 2 + 4
    corners = sole_corners(np.array([1.0, 2.0, np.pi / 2]))
    assert np.ptp(corners, axis=0) == pytest.approx([0.22, 0.27])
    assert corners.mean(axis=0) == pytest.approx([1.0, 2.0])


def test_the_plan_is_drawn_where_the_robot_started(make_result):
    scenario = override(Scenario(), {"start.x": 1.0, "start.y": 2.0, "start.heading_deg": 90.0})
    result = make_result(scenario, steps=1)
    assert to_world(scenario, np.array([[0.5, 0.1]]))[0] == pytest.approx([0.9, 2.5])
    result.signals["planned_motion"][:, PLANNED_MOTION.slice("foot_l")] = (0.5, 0.1, 0.0, 0.2)
    steps = planned_footsteps(result)["l"]
    assert steps[0] == pytest.approx([0.9, 2.5, 0.0, np.pi / 2 + 0.2])


def test_runs_in_one_figure_are_called_by_what_tells_them_apart(make_result):
    ref, dyn = (make_result(override(Scenario(), {"variant": v}), steps=1) for v in ("ref", "dyn"))
    other = make_result(override(Scenario(), {"seed": 1}), steps=1)
    assert labels([ref, dyn]) == ["ref", "dyn"]
    assert labels([dyn, other]) == ["unnamed dyn seed 0", "unnamed dyn seed 1"]
    assert labels([dyn, dyn]) == ["unnamed dyn seed 0 (1)", "unnamed dyn seed 0 (2)"]
