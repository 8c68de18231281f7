"""The paper's events happen as it tells them; nothing here states how much anything improves."""

import numpy as np
import pytest

from lola_drake.contact_events import landings
from lola_drake.metrics import inclination_deg, torque_error
from lola_drake.signals import FEET, GAIT_PHASE

SHORT = "duration=7"
"""Until the unexpected contacts are over."""


def first(result, kind):
    return next(landing for landing in landings(result) if landing.kind == kind)


def between(result, start, duration):
    """Return the samples of a part of the run, times in s."""
    return (result.times >= start) & (result.times < start + duration)


def stance_rate(result, swing_foot):
    """Return the vertical Delta w_a,f' of the stance foot: positive lets the CoM down."""
    (stance,) = set(FEET) - {swing_foot}
    return result.signals[f"com_dynamics_rate_{stance}"][:, 2]


def rise(result, start, duration):
    """Return by how much the CoM has risen over the plan's since `start` (m)."""
    unplanned = result.signals["com_position"][:, 2] - result.signals["planned_motion"][:, 2]
    at = np.searchsorted(result.times, [start, start + duration])
    return float(unplanned[at[1]] - unplanned[at[0]])


@pytest.mark.parametrize("scenario", ["step_down", "board_9cm"])
def test_late_contact_tips_and_dyn_lets_the_com_down(run, scenario):
    ref, dyn = run(scenario, "variant=ref", SHORT), run(scenario, "variant=dyn", SHORT)
    late = first(dyn, "late")
    assert first(ref, "late").foot == late.foot
    assert first(ref, "late").planned == pytest.approx(late.planned, abs=0.01)
    waiting = late.measured - late.planned
    assert stance_rate(dyn, late.foot)[between(dyn, late.planned, waiting)].max() > 0.05
    assert not stance_rate(ref, late.foot).any()
    assert rise(dyn, late.planned, waiting) < rise(ref, late.planned, waiting) < 0.0
    assert late.measured < first(ref, "late").measured - 0.005
    tilt = {
        result: np.abs(inclination_deg(result.signals["torso_pose"]))[
            between(result, late.planned, 0.8)
        ].max(axis=0)
        for result in (ref, dyn)
    }
    assert (tilt[ref] > 1.0).all()
    assert (tilt[dyn] < tilt[ref]).all()


def test_early_contact_tips_back_and_dyn_pushes_the_com_up(run):
    ref, dyn = run("board_9cm", "variant=ref", SHORT), run("board_9cm", "variant=dyn", SHORT)
    early = first(dyn, "early")
    assert first(ref, "early").measured == pytest.approx(early.measured, abs=0.01)
    assert stance_rate(dyn, early.foot)[between(dyn, early.measured, 0.1)].min() < -0.02
    assert rise(dyn, early.measured, 0.1) > 0.0
    pitch = {
        result: inclination_deg(result.signals["torso_pose"])[:, 1][
            between(result, early.measured, 0.4)
        ].mean()
        for result in (ref, dyn)
    }
    assert pitch[ref] < 0.0
    assert pitch[ref] < pitch[dyn]


def test_phase_reset_makes_the_board_the_foothold(run):
    result = run("board_9cm", "variant=dyn", SHORT)
    early = first(result, "early")
    stands = between(result, early.measured + 0.1, 0.3)
    height = result.signals[f"foot_pose_{early.foot}"][stands, 2]
    assert height == pytest.approx(0.09, abs=0.01)


def test_step_down_has_no_phase_reset_and_no_early_contact_before_the_edge(run):
    result = run("step_down", "variant=dyn", SHORT)
    late = first(result, "late")
    before = [landing for landing in landings(result) if landing.measured < late.measured]
    assert [landing.kind for landing in before] == ["punctual"] * 3
    assert result.signals[f"foot_pose_{late.foot}"][-1, 2] == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize("variant", ["ref", "dyn"])
def test_the_torque_error_after_a_late_contact_is_over_where_the_other_foot_lifts_off(run, variant):
    """That foot is let go of when it lifts off, not before: nothing presses it down until then."""
    result = run("board_9cm", f"variant={variant}", SHORT)
    late = first(result, "late")
    other = FEET.index(late.foot) ^ 1
    support = result.signals["gait_phase"][:, GAIT_PHASE.slice("support")][:, other]
    lifted = result.times[np.flatnonzero(np.diff(support) < 0) + 1]
    lift_off = lifted[lifted > late.measured][0]
    square = torque_error(result.signals) ** 2
    while_lifting = square[between(result, lift_off - 0.02, 0.14)].sum(axis=0)
    while_landing = square[between(result, late.measured - 0.02, 0.14)].sum(axis=0)
    assert (while_lifting < 0.05 * while_landing).all()


@pytest.mark.parametrize("variant", ["ref", "original"])
def test_a_late_foot_that_seeks_the_ground_finds_it_earlier(run, variant):
    waiting, seeking = (
        run("step_down", f"variant={variant}", f"control.force.search_speed={speed}", SHORT)
        for speed in (0.0, 0.22)
    )
    assert first(seeking, "late").measured < first(waiting, "late").measured - 0.02
    for axis in "xy":
        tilt = [result.metrics["max_inclination_deg"][axis] for result in (seeking, waiting)]
        assert tilt[0] < 0.8 * tilt[1]
