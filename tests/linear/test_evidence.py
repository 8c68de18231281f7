"""The linear models against the nonlinear simulation: steps, frequency responses, borders."""

import numpy as np
import pytest

import lola_drake as lola
from lola_drake.linear.frequency import frequency_response
from lola_drake.linear.studies.analyses import step_response
from lola_drake.linear.studies.measured_response import deviation, measured_response
from lola_drake.linear.studies.stability_border import predicted_border, swings_up
from lola_drake.linear.studies.workpoint import make_workpoint
from lola_drake.linear.tick_loop import TickLoop


def test_a_step_of_the_desired_force_is_the_same_in_both_within_2_percent(standing):
    """5 N on the left foot: every millisecond of the first 100."""
    signal, output = "desired_wrench.wrench_l.F_z", "contact_wrench_l.wrench.F_z"
    added = np.full((100, 1), 5.0)
    ticks = TickLoop(standing.diagram, standing.context)
    simulated = ticks.run([output], 100, signal, added)[:, 0]
    model = lola.linearize(standing.diagram, signal, output, standing.context)
    linear = step_response(model, 0, 5.0, duration=0.1)[1][:, 0]
    deviations = np.abs(simulated - simulated[0] - linear)
    assert deviations.max() <= 0.02 * 5.0
    assert linear.max() > 1.0, "the force follows"


def test_the_measured_response_is_the_models_within_1_dB_and_5_degrees(standing):
    signal, output = "desired_wrench.wrench_l.F_z", "contact_wrench_l.wrench.F_z"
    frequencies = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0)
    measured = measured_response(
        standing, signal, output, 1.0, frequencies, settling=0.5, duration=1.0
    )
    model = lola.linearize(standing.diagram, signal, output, standing.context)
    gain, phase = deviation(measured, frequency_response(model, np.array(frequencies)))
    assert np.abs(gain).max() <= 1.0
    assert np.abs(phase).max() <= 5.0


@pytest.mark.parametrize("at", ["standing", "on_left"])
def test_the_simulation_meets_the_predicted_border_within_10_percent(at, request):
    point = request.getfixturevalue(at)
    workpoint = make_workpoint(lola.load_scenario("stand"), point.description, point=point)
    border = predicted_border(workpoint, accuracy=0.01)
    assert swings_up(workpoint.situation, 0.9 * border, duration=0.6)
    assert not swings_up(workpoint.situation, 1.1 * border, duration=0.6)
