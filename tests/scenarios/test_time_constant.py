"""What delta means in the whole loop: the time constant of the measured force (eq. 14)."""

import numpy as np
import pytest

from lola_drake.block_system import set_gain
from lola_drake.linear.isolated import fix_port
from lola_drake.linear.studies.operating_points import situation
from lola_drake.linear.tick_loop import TickLoop
from lola_drake.linear.wiring import Wiring
from lola_drake.scenario import load_scenario
from lola_drake.signals import DESIRED_WRENCH, FEET

T_X, T_Y, F_Z = range(3)
SIZES = (3.0, 3.0, 30.0)
"""Of the steps (Nm, N)."""

CASES = [("stand", T_X), ("stand", T_Y), ("stand", F_Z), ("left", T_X), ("left", T_Y)]
"""On one foot F_z is the robot's weight, whatever is wanted."""


def step_response(at, entry, delta, feedforward=0.0, ticks=80):
    """Return the answer of the left foot's wrench to a step of lambda_d, tick by tick.

    lambda_d is frozen before, so that no stabiliser answers, and its rate is zero. On both feet the
    right one gets the opposite step, which moves the robot least.
    """
    changes = {
        "variant": "dyn",
        "sensors.ideal": True,
        "control.inverse_kinematics.feedforward": feedforward,
    }
    point = situation(load_scenario("stand", changes), at)
    controller = point.diagram.GetSubsystemByName("controller")
    for foot in FEET:
        block = controller.GetSubsystemByName(f"com_dynamics_{foot}")
        set_gain(block, point.context, "gain", 0.0)
        block = controller.GetSubsystemByName(f"force_control_{foot}")
        set_gain(block, point.context, "time_constant", delta)
    distribution = controller.GetSubsystemByName("force_distribution")
    desired = distribution.GetOutputPort("desired_wrench").Eval(
        distribution.GetMyContextFromRoot(point.context)
    )
    start, stepped = desired[entry], desired.copy()
    stepped[DESIRED_WRENCH.slice("rate_l").start :] = 0.0
    stepped[entry] += SIZES[entry]
    if at == "stand":
        stepped[3 + entry] -= SIZES[entry]
    wiring = Wiring(point.diagram)
    for target in wiring.targets(wiring.select("desired_wrench").source):
        block = wiring.blocks[target.block]
        inside = block.GetMyMutableContextFromRoot(point.context)
        fix_port(block.get_input_port(target.port), inside, stepped)
    answer = TickLoop(point.diagram, point.context).run(["contact_wrench_l"], ticks)[:, entry]
    return (answer - start) / SIZES[entry]


@pytest.mark.parametrize("delta", [0.02, 0.027])
@pytest.mark.parametrize(("at", "entry"), CASES)
def test_a_step_of_the_desired_wrench_is_followed_by_63_percent_in_delta(at, entry, delta):
    answer = step_response(at, entry, delta)
    assert answer[0] == pytest.approx(0.0, abs=1e-3)
    reached = 1 - np.exp(-1)
    k = np.flatnonzero(answer >= reached)[0]
    ticks = k - (answer[k] - reached) / (answer[k] - answer[k - 1])
    assert 1e-3 * ticks == pytest.approx(delta, rel=0.15)


@pytest.mark.parametrize(("at", "entry"), CASES)
def test_the_fed_forward_torque_alone_gives_less_than_a_fifth_of_a_step(at, entry):
    """With a delta of hours nothing else answers. The rate of eq. 15 counts that much twice."""
    answer = step_response(at, entry, delta=1e4, feedforward=1.0, ticks=40)
    assert 0.08 < answer[-1] < 0.2
