"""The stride-to-stride map: its section, its parts and what it says."""

from dataclasses import replace

import numpy as np
import pytest

import lola_drake as lola
from lola_drake.linear.coordinates import coordinates
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import discrete_state
from lola_drake.linear.presentation.study_figures import multipliers_figure
from lola_drake.linear.studies.gait_section import (
    Section,
    find_section,
    moving_coordinates,
    section_context,
    typical,
)
from lola_drake.linear.studies.operating_points import quiet
from lola_drake.linear.studies.poincare import (
    CONVERGED,
    MOTION,
    PLACE,
    POSTURE,
    TRIED,
    StrideMap,
    converged_step,
    fly,
    forget,
)


@pytest.fixture(scope="module")
def short(standing):
    """Return a section of 12 ticks of standing: long enough for what is tested here."""
    scenario = quiet(lola.load_scenario("stand"))
    context = standing.context
    state = discrete_state(context)
    return Section(scenario, context.get_time(), state, 12, 0.0)


def test_a_section_is_found_again_in_another_diagram(short, standing):
    diagram, context = section_context(short)
    frame = moving_coordinates(diagram, context)
    assert len(frame.names) > 190
    assert not any("walking_pattern" in name or "switches" in name for name in frame.names)
    np.testing.assert_allclose(discrete_state(context), discrete_state(standing.context))
    assert (typical(frame) >= 1).all()


def test_what_is_forgotten_and_what_is_flown_make_the_whole_stride(short):
    """Along a few directions against flying all ticks by differences."""
    later, lasting, forgetting = forget(short, 5)
    assert later.ticks == 7
    assert lasting.shape[1] < 0.7 * len(lasting)
    step = 1e-5
    directions = np.random.default_rng(1).choice([-1.0, 1.0], (2, len(lasting)))
    directions /= np.sqrt(len(lasting))
    whole = fly(short, step * directions, jobs=1) / step
    parts = fly(later, step * (lasting @ forgetting @ directions.T).T, jobs=1) / step
    np.testing.assert_allclose(parts, whole, atol=2e-3 * np.abs(whole).max())


def test_the_step_is_the_one_at_which_the_differences_change_least(short, standing):
    n = len(moving_coordinates(standing.diagram, standing.context).names)
    step, changes = converged_step(short, np.eye(n)[:, -20:], jobs=1)
    assert set(changes) == set(TRIED[1:])
    assert changes[step] == min(changes.values()) < CONVERGED


def test_multipliers_are_the_eigenvalues_and_know_place_and_heading():
    names = ["plant/q/torso_x", "plant/q/torso_rot_y", "plant/v/torso_wy"]
    names.append("controller/inverse_kinematics/q/tafl")
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = [[1.0, 0.2, 0.0], [0.0, 0.4, 0.3], [0.0, -0.3, 0.4]]
    matrix[:, 3] = 0.1, 0.2, 0.3, 0.7  # the arms move the torso, and nothing moves the arms
    section = Section(lola.load_scenario("walk_flat"), 1.0, np.zeros(4), 1600, 1e-9)
    stride = StrideMap(section, matrix, names, 1e-4, {1e-4: 1e-3})
    place, posture, swing = stride.multipliers()
    assert (place.kind, place.dominating) == (PLACE, "plant/q/torso_x")
    assert (posture.kind, swing.kind) == (POSTURE, MOTION)
    assert stride.largest(POSTURE) == pytest.approx(0.7)
    assert swing.value == pytest.approx(0.4 + 0.3j)
    assert stride.radius == pytest.approx(0.5)
    assert "largest multiplier of torso, CoM and legs: 0.5;" in stride.as_text()
    assert "NOT converged" not in stride.as_text()
    assert "NOT converged" in replace(stride, convergence={1e-4: 0.5}).as_text()
    assert stride.as_numbers()["radius"] == pytest.approx(0.5)
    assert multipliers_figure({"dyn": stride}).axes


def test_a_scenario_without_steps_has_no_stride():
    with pytest.raises(AnalysisError, match="stand has no steps"):
        find_section(lola.load_scenario("stand"))


def test_coordinates_move_there_and_back(standing):
    frame = moving_coordinates(standing.diagram, standing.context)
    again = coordinates(frame.wiring, standing.context, list(frame.tangents))
    motion = 1e-3 * np.random.default_rng(2).standard_normal(len(again.names))
    moved = standing.context.Clone()
    frame.move(moved, motion)
    np.testing.assert_allclose(frame.difference(moved, standing.context), motion, atol=1e-12)


def test_a_motion_is_flown_by_half_the_difference_of_both_sides(short, standing):
    """One tick of a moved delay line: what it forwards is what it was moved by."""
    names = moving_coordinates(standing.diagram, standing.context).names
    line = names.index("imu/phi/x@1")
    motion = np.zeros((1, len(names)))
    motion[0, line] = 1e-5
    flown = fly(replace(short, ticks=1), motion, jobs=1)[:, 0]
    assert flown[names.index("imu/phi/x@2")] == pytest.approx(1e-5, rel=1e-6)
