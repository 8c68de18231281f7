"""An early contact: the swing stops, the touched ground becomes the foothold, the gait goes on."""

from dataclasses import replace

import numpy as np
import pytest
from ticking import Ticking

from lola_drake.blocks.walking_pattern import (
    RESET_SUPPORTS,
    WalkingPattern,
    WalkingPatternParams,
    standing_request,
)
from lola_drake.robot import Kinematics, leg_model
from lola_drake.signals import GAIT_PHASE, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.footholds import foothold
from lola_drake.theory.step_request import pack_request, unpack_request

CLOSED = np.ones(4)


@pytest.fixture(scope="module")
def legs():
    return leg_model(Kinematics())


class Walker(Ticking):
    """A pattern generator; the ground is where it is planned."""

    def __init__(self, legs, **params):
        steps = np.tile([0.3, 0.0, 0.0, 0.0], (6, 1))
        super().__init__(
            WalkingPattern(WalkingPatternParams(**params), legs, steps=steps, start_time=0.0)
        )
        self.early = False
        self.contact(CLOSED, CLOSED)

    def contact(self, left, right):
        self.fix("contact", np.r_[left, right])

    def request(self):
        return unpack_request(self.state("request"))

    def step(self):
        support = self.output("gait_phase")[GAIT_PHASE.slice("support")]
        closed = np.repeat(np.maximum(support, self.early), 4)
        self.contact(closed[:4], closed[4:])
        super().step()

    def walk_until(self, step_index, time_in_step):
        for _ in range(10000):
            phase = self.output("gait_phase")
            if (
                phase[GAIT_PHASE.index("step_index")] == step_index
                and phase[GAIT_PHASE.index("time_in_step")] >= time_in_step - 1e-9
            ):
                return
            self.step()
        raise AssertionError(f"step {step_index} never came to {time_in_step} s")


def test_request_survives_packing():
    request = replace(standing_request(WalkingPatternParams()), displacements=np.eye(4)[:2])
    again = unpack_request(pack_request(request))
    assert np.array_equal(pack_request(again), pack_request(request))
    assert len(again.displacements) == 2


def test_contact_while_swinging_becomes_the_foothold(legs):
    walker = Walker(legs, phase_reset=True)
    walker.walk_until(1, 0.65)
    swing = walker.request().swing
    before = walker.output("planned_motion").copy()
    walker.early = True
    walker.step()
    request = walker.request()
    assert request.step_index == 2 and request.swing == 1 - swing
    assert request.support in RESET_SUPPORTS
    foot = PLANNED_MOTION.slice("foot_" + "lr"[swing])
    assert request.feet[swing] == pytest.approx(before[foot])
    assert request.ground == pytest.approx(before[foot][2])
    # The path goes on in the middle between this foothold and that of the other foot.
    width = walker.block.params.step_width
    assert foothold(request.path, swing, width) == pytest.approx(before[foot][[0, 1, 3]])
    after = walker.output("planned_motion")
    for name in ("com", "com_velocity"):
        part = PLANNED_MOTION.slice(name)
        assert after[part] == pytest.approx(before[part], abs=2e-3)
    w_dot = walker.output("task_reference")[TASK_REFERENCE.slice("w_dot_" + "lr"[swing])]
    assert w_dot[:3] == pytest.approx(-after[PLANNED_MOTION.slice("com_velocity")], abs=0.02)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_ground_behind_an_early_foothold_is_where_it_is_said_to_be(legs, share):
    walker = Walker(legs, phase_reset=True, ground_behind=share)
    walker.walk_until(1, 0.65)
    swing = walker.request().swing
    height = walker.output("planned_motion")[PLANNED_MOTION.slice("foot_" + "lr"[swing])][2]
    walker.early = True
    walker.step()
    walker.early = False
    assert height > 0.01
    assert walker.request().ground == pytest.approx(share * height)
    walker.walk_until(3, 0.0)
    foot = PLANNED_MOTION.slice("foot_" + "rl"[swing])
    assert walker.output("planned_motion")[foot][2] == pytest.approx(share * height, abs=1e-6)


def test_force_control_follows_an_early_contact_within_20_ms_from_where_it_was(legs):
    walker = Walker(legs, phase_reset=True)
    walker.walk_until(1, 0.65)
    swing = walker.request().swing
    blend = GAIT_PHASE.slice("blend")
    before = walker.output("gait_phase")[blend][swing]
    walker.early = True
    walker.step()
    assert walker.output("gait_phase")[blend][swing] == pytest.approx(before, abs=2e-3)
    assert before < 0.1
    for _ in range(20):
        walker.step()
    assert walker.output("gait_phase")[blend][swing] == pytest.approx(1.0)


@pytest.mark.parametrize("time_in_step", [0.4, 0.79])
def test_contact_after_lift_off_or_just_before_touchdown_is_no_early_one(legs, time_in_step):
    walker = Walker(legs, phase_reset=True)
    walker.walk_until(1, time_in_step)
    walker.early = True
    walker.step()
    assert walker.request().step_index == 1


def test_without_phase_reset_a_contact_changes_nothing(legs):
    touched, free = Walker(legs), Walker(legs)
    for walker in (touched, free):
        walker.walk_until(1, 0.6)
    touched.early = True
    for _ in range(150):
        touched.step()
        free.step()
        assert np.array_equal(touched.output("task_reference"), free.output("task_reference"))


def test_gait_goes_on_to_the_end_and_stands(legs):
    walker = Walker(legs, phase_reset=True)
    walker.walk_until(1, 0.65)
    walker.early = True
    walker.step()
    walker.early = False
    for _ in range(7000):
        walker.step()
    assert not len(walker.request().displacements)
    load = walker.output("gait_phase")[GAIT_PHASE.slice("load")]
    assert load == pytest.approx([0.5, 0.5])
    assert (
        np.abs(walker.output("planned_motion")[PLANNED_MOTION.slice("com_velocity")]).max() < 1e-3
    )
