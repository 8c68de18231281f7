"""The CoM's height follows the ground as the feet find it, without a bump."""

import numpy as np
import pytest
from ticking import Ticking

from lola_drake.blocks.foot_force_control import FootForceControl
from lola_drake.blocks.height_adaptation import (
    FASTEST,
    HEIGHT_RATES,
    HEIGHTS,
    REACH,
    TIME_CONSTANT,
    HeightAdaptivePattern,
    bumpless,
    lift_rate,
    task_command,
)
from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.blocks.walking_pattern import WalkingPattern, WalkingPatternParams
from lola_drake.robot import Kinematics, leg_model
from lola_drake.signals import PERIOD, PLANNED_MOTION
from lola_drake.theory.step_request import unpack_request

HALF = np.array([0.5, 0.5])


@pytest.fixture(scope="module")
def legs():
    return leg_model(Kinematics())


def test_law_is_the_loads_mean_of_what_the_feet_added():
    rate = lift_rate(np.array([0.25, 0.75]), np.array([-0.02, 0.01]), 0.0, 0.87)
    assert rate == pytest.approx(-(0.25 * -0.02 + 0.75 * 0.01) / TIME_CONSTANT)
    assert lift_rate(HALF, np.array([-0.02, -0.02]), 0.0, 0.87) > 0, "lower ground lets feet down"


def test_rate_and_reach_are_limited():
    assert lift_rate(HALF, np.full(2, -0.08), 0.0, 0.87) == FASTEST
    assert lift_rate(HALF, np.full(2, 0.08), 0.0, 0.87) == -FASTEST
    assert lift_rate(HALF, np.full(2, -0.08), REACH[1] - 0.87, 0.87) == pytest.approx(0, abs=1e-9)
    assert lift_rate(HALF, np.full(2, 0.08), REACH[0] - 0.87, 0.87) == pytest.approx(0, abs=1e-9)


def patterns(legs):
    params = WalkingPatternParams(first_double_support=0.3)
    steps = np.tile([0.3, 0.0, 0.0, 0.0], (6, 1))
    made = [
        Ticking(block(params, legs, steps=steps, start_time=0.0))
        for block in (WalkingPattern, HeightAdaptivePattern)
    ]
    for pattern in made:
        pattern.fix("contact", np.ones(8))
    return made


def test_undisturbed_it_walks_bit_for_bit_as_the_plan(legs):
    plain, adaptive = patterns(legs)
    for _ in range(1500):
        for name in ("task_reference", "gait_phase", "ideal_wrench", "planned_motion"):
            assert np.array_equal(plain.output(name), adaptive.output(name))
        plain.step()
        adaptive.step()


def test_feet_are_let_down_with_the_rate_that_is_said(legs):
    plain, adaptive = patterns(legs)
    for foot in "lr":
        adaptive.fix(f"task_modification_{foot}", [0.0, 0.0, -0.006])
    rates, lowered, rate_offsets = [], [], []
    for _ in range(200):
        rates.append(adaptive.output("height_rate")[0])
        one, other = plain.output("task_reference"), adaptive.output("task_reference")
        lowered.append(other[HEIGHTS] - one[HEIGHTS])
        rate_offsets.append(other[HEIGHT_RATES] - one[HEIGHT_RATES])
        plain.step()
        adaptive.step()
    rates, lowered = np.array(rates), np.array(lowered)
    assert rates[1:].max() == pytest.approx(0.02, abs=2e-4)
    np.testing.assert_allclose(np.diff(lowered[:, 0]), -PERIOD * rates[:-1], atol=1e-12)
    np.testing.assert_allclose(rate_offsets, -rates[:, None].repeat(2, axis=1), atol=1e-12)
    assert np.array_equal(lowered[:, 0], lowered[:, 1])


def test_next_plan_takes_the_com_to_its_height_above_the_ground_as_found(legs):
    _, adaptive = patterns(legs)
    for foot in "lr":
        adaptive.fix(f"task_modification_{foot}", [0.0, 0.0, -0.006])
    adaptive.step(1200)
    lift = unpack_request(adaptive.state("request")).lift
    assert 0.01 < lift < 0.05
    adaptive.step(700)
    com = adaptive.output("planned_motion")[PLANNED_MOTION.slice("com")]
    assert com[2] < 0.87 - 0.9 * lift


def test_force_control_takes_back_what_the_plan_lets_down():
    plain = FootForceControl.laws["task_command"]
    w, w_dot = np.arange(6.0) / 10, np.arange(6.0) / 100
    given = (w, w_dot, 0.7, (0.1, 0.2, 0.03), (1.0,), np.array([0.01, 0.02, 0.03]), np.zeros(2))
    given += (np.array([0.01, 0.0, -0.02]), np.array([-1.0]), 6.0, 1.0, 0.03, 0.05, 0.25)
    given += (np.full(3, 0.2), np.full(3, 1.0))
    change = np.subtract(task_command(*given, np.array([0.04])), plain(*given))
    assert change[8] == pytest.approx(0.04)
    assert not np.delete(change, 8).any()


def test_a_bumpless_law_is_the_same_law_but_for_the_height():
    law = bumpless(HybridForceControl)
    assert law.laws["force_rate"] is HybridForceControl.laws["force_rate"]
    assert law.laws["task_command"] is task_command
    assert HybridForceControl.laws["task_command"] is not task_command
