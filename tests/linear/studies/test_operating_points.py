"""Equilibria of the closed loop, and moments of a walk."""

import numpy as np
import pytest

import lola_drake as lola
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.studies.operating_points import situation
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.signals import GROUND_FORCE

FORCES = [GROUND_FORCE.slice(f"F_{foot}").start + 2 for foot in "lr"]


def forces(situation) -> np.ndarray:
    """Return the ground's vertical force on both feet after a few ticks (N)."""
    ticks = TickLoop(situation.diagram, situation.context)
    return ticks.run(["ground_force"], 3)[-1, FORCES]


def test_standing_is_an_equilibrium(standing):
    model = lola.linearize(standing.diagram, [], [], standing.context, equilibrium=1e-6)
    assert standing.residual <= 1e-8
    assert model.operating_point.residual == pytest.approx(standing.residual, abs=1e-8)
    left, right = forces(standing)
    assert left == pytest.approx(right, rel=1e-6)
    assert left + right == pytest.approx(60.0 * 9.81, rel=1e-3)


def test_nothing_moves_in_an_equilibrium(standing):
    record = TickLoop(standing.diagram, standing.context).run(
        ["contact_wrench_l", "torso_orientation"], 50
    )
    assert np.ptp(record, axis=0).max() < 1e-5


def test_on_one_foot_the_other_hangs_in_the_air(on_left):
    left, right = forces(on_left)
    assert right == 0.0
    assert left == pytest.approx(60.0 * 9.81, rel=1e-3)
    assert on_left.residual <= 1e-6


def test_a_pose_may_be_any():
    step = situation(lola.load_scenario("stand"), "load=0.7 stride=0.2 height=0.85")
    left, right = forces(step)
    assert left / (left + right) == pytest.approx(0.7, abs=0.01)


def test_any_time_of_any_scenario():
    moment = situation(lola.load_scenario("walk_flat"), "t=0.05")
    assert moment.context.get_time() == pytest.approx(0.05)
    assert moment.residual is None
    model = lola.linearize(moment.diagram, [], [], moment.context)
    assert model.operating_point.time == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("at", "message"),
    [
        ("nowhere", "no operating point 'nowhere': say stand, left, right"),
        ("t=99", "stand lasts 5 s, 99 s is outside"),
        ("load=2", "a pose's load is between 0 and 1"),
        ("height=2", "the pose cannot be taken"),
        ("depth=1", "a pose has load, stride, width, height, lift"),
    ],
)
def test_an_operating_point_that_does_not_exist_is_one_clear_error(at, message):
    with pytest.raises(AnalysisError, match=message):
        situation(lola.load_scenario("stand"), at)


def height(situation) -> float:
    """Return the torso's height (m)."""
    plant = situation.diagram.GetSubsystemByName("plant")
    return plant.GetPositions(plant.GetMyContextFromRoot(situation.context))[6]


def test_a_law_that_holds_no_height_stands_where_it_is(standing):
    """Nothing chooses the height, so the search for an equilibrium may not carry it away."""
    scenario = lola.load_scenario("stand", {"control.stabilizer.height_stiffness": 0.0})
    free = situation(scenario, "stand")
    assert free.residual < 1e-6
    assert height(free) == pytest.approx(height(standing), abs=0.002)


def test_the_predecessors_law_stands_too():
    """Its joint angles are its own state: it has no inverse kinematics beside it."""
    place = situation(lola.load_scenario("stand", {"variant": "original"}), "stand")
    left, right = forces(place)
    assert place.residual <= 1e-8
    assert left == pytest.approx(right, rel=1e-6)
    assert left + right == pytest.approx(60.0 * 9.81, rel=1e-3)
