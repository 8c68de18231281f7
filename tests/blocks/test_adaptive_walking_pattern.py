"""What changes a step under way: a foothold that is moved, and a load that waits."""

import numpy as np
import pytest
from ticking import Ticking

from lola_drake.blocks.adaptive_walking_pattern import SHIFT, WAIT, AdaptiveWalkingPattern
from lola_drake.blocks.walking_pattern import WalkingPattern, WalkingPatternParams
from lola_drake.robot import Kinematics, leg_model
from lola_drake.signals import GAIT_PHASE, PERIOD, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.step_adaptation import part_ahead, too_low
from lola_drake.theory.step_request import unpack_request

STEPS = np.tile([0.3, 0.0, 0.0, 0.0], (6, 1))
SIGNALS = ("task_reference", "gait_phase", "ideal_wrench", "planned_motion")


@pytest.fixture(scope="module")
def legs():
    return leg_model(Kinematics())


class Walker(Ticking):
    """A pattern on its own; its feet find the ground where it is planned, unless `lost` says no."""

    def __init__(self, legs, block=AdaptiveWalkingPattern, **params):
        params = WalkingPatternParams(first_double_support=0.3, **params)
        super().__init__(block(params, legs, steps=STEPS, start_time=0.0))
        self.lost = False

    def phase(self, name):
        return self.output("gait_phase")[GAIT_PHASE.slice(name)]

    def foot(self, foot):
        return self.output("planned_motion")[PLANNED_MOTION.slice(f"foot_{'lr'[foot]}")]

    def request(self):
        return unpack_request(self.state("request"))

    def tick(self, lean=(0.0, 0.0)):
        down = np.array([self.foot(0)[2] < 1e-6, self.foot(1)[2] < 1e-6 and not self.lost])
        self.fix("contact", np.repeat(down, 4))
        if "torso_orientation" in self.block.inputs:
            self.fix("torso_orientation", [*lean, 0.0, 0.0])
        self.step()

    def walk_until(self, step_index, time_in_step=0.0, lean=(0.0, 0.0)):
        for _ in range(10000):
            step, time = self.phase("step_index")[0], self.phase("time_in_step")[0]
            if (step, time) >= (step_index, time_in_step - 1e-9):
                return
            self.tick(lean)


@pytest.mark.parametrize("switch", ["step_adaptation", "late_foot_probing"])
def test_undisturbed_it_walks_bit_for_bit_as_the_plan(legs, switch):
    plain, adaptive = Walker(legs, WalkingPattern), Walker(legs, **{switch: True})
    for _ in range(2500):
        plain.tick()
        adaptive.tick()
        for name in SIGNALS:
            assert np.array_equal(plain.output(name), adaptive.output(name))


@pytest.mark.parametrize(
    ("lean", "way"), [((0.0, 0.2), (1, 0)), ((0.2, 0.0), (0, -1)), ((0.0, -0.15), (-1, 0))]
)
def test_leaning_torso_moves_the_foothold_to_where_it_falls(legs, lean, way):
    """The right foot swings in the second step: outward is to the right."""
    plain, leaning = Walker(legs, WalkingPattern), Walker(legs, step_adaptation=True)
    for walker in (plain, leaning):
        walker.walk_until(1, 0.34)
    for _ in range(456):
        plain.tick()
        leaning.tick(lean)
    moved = leaning.foot(1)[:2] - plain.foot(1)[:2]
    assert 0.1 < moved @ way < 0.6
    assert np.cross([*moved, 0], [*way, 0])[2] == pytest.approx(0, abs=1e-6)
    assert np.array_equal(leaning.foot(0), plain.foot(0))
    w, motion = leaning.output("task_reference"), leaning.output("planned_motion")
    com, turned = motion[PLANNED_MOTION.slice("com")], motion[PLANNED_MOTION.index("heading")]
    assert turned == 0
    np.testing.assert_allclose(
        w[TASK_REFERENCE.slice("w_r", 2)], leaning.foot(1)[:2] - com[:2], atol=1e-12
    )


def test_late_in_the_swing_the_foothold_stays(legs):
    """But for what the legs' heights follow: the robot leans, and the foot comes down anyway."""
    walker = Walker(legs, step_adaptation=True)
    walker.walk_until(1, 0.7)
    for _ in range(90):
        walker.tick((0.0, 0.2))
    target = SHIFT.slice("target")
    assert not walker.state(SHIFT.name)[target].any()
    walker.walk_until(2, 0.4)
    walker.tick((0.0, 0.2))
    assert walker.state(SHIFT.name)[target][0] > 0.1


def test_task_rates_are_those_of_the_moved_foot(legs):
    walker = Walker(legs, step_adaptation=True)
    walker.walk_until(1, 0.4)
    w, rate = (TASK_REFERENCE.slice(name, 3) for name in ("w_r", "w_dot_r"))
    values = []
    for k in range(300):
        values.append(walker.output("task_reference"))
        walker.tick((0.05, 0.2 if k < 100 else 0.15))
    values = np.array(values)
    difference = np.diff(values[:, w], axis=0) / PERIOD
    np.testing.assert_allclose(difference, values[1:, rate], atol=0.05)
    assert np.abs(difference).max() > 1.0


def test_next_plan_goes_on_from_the_moved_foot_and_knows_the_faster_com(legs):
    plain, leaning = Walker(legs, WalkingPattern), Walker(legs, step_adaptation=True)
    for walker in (plain, leaning):
        walker.walk_until(1, 0.34)
    leaning.walk_until(2, 0.0, (0.0, 0.2))
    plain.walk_until(2)
    one, other = plain.request(), leaning.request()
    shift = other.feet[1][:2] - one.feet[1][:2]
    assert shift[0] > 0.01
    np.testing.assert_allclose(other.path - one.path, [*shift, 0], atol=1e-12)
    np.testing.assert_allclose(other.com, one.com, atol=1e-9)
    faster = np.sqrt(GRAVITY / one.com[2]) * part_ahead(one.com[2], other.support) * shift
    np.testing.assert_allclose(other.com_velocity - one.com_velocity, [*faster, 0], atol=1e-6)
    assert not leaning.state(SHIFT.name)[:6].any()
    assert leaning.foot(1)[:2] == pytest.approx(other.feet[1][:2], abs=1e-9)


@pytest.mark.parametrize("lean", [(0.0, 0.1), (0.0, -0.1), (0.05, 0.1), (-0.05, 0.1)])
def test_swing_foot_comes_down_on_the_ground_that_a_leaning_robot_sees(legs, lean):
    """What it is higher than planned stays when it lands, and then fades."""
    leaning = Walker(legs, step_adaptation=True)
    leaning.walk_until(1, 0.34)
    leaning.walk_until(1, 0.79, lean)
    away = leaning.foot(1) - leaning.foot(0)
    height = too_low(np.array(lean), away[:2])
    assert away[2] == pytest.approx(height, abs=5e-3) and abs(height) > 0.01
    leaning.walk_until(2, 0.0, lean)
    assert leaning.foot(1)[2] == pytest.approx(height, abs=5e-3)
    for _ in range(300):
        leaning.tick()
    assert leaning.foot(1)[2] == pytest.approx(height / np.e, abs=3e-3)


def test_load_waits_for_a_late_foot_until_it_touches(legs):
    walker = Walker(legs, late_foot_probing=True)
    walker.walk_until(1, 0.7)
    walker.lost = True
    walker.walk_until(2, 0.06)
    assert walker.request().wait == WAIT
    assert walker.phase("support").tolist() == [1, 1]
    assert walker.phase("load").tolist() == [1, 0]
    before = walker.output("planned_motion").copy()
    walker.lost = False
    walker.tick()
    assert walker.request().wait == 0 and walker.request().swing == 0
    com = PLANNED_MOTION.slice("com")
    assert walker.output("planned_motion")[com] == pytest.approx(before[com], abs=1e-3)
    walker.tick()
    walker.tick()
    assert walker.phase("load")[1] > 0
    walker.walk_until(3)
    assert walker.phase("step_index") == 3


def test_load_waits_no_longer_than_it_may(legs):
    walker, begun = Walker(legs, late_foot_probing=True), None
    walker.walk_until(1, 0.7)
    walker.lost = True
    for _ in range(2000):
        walker.tick()
        if walker.phase("step_index")[0] == 2:
            begun = walker.ticks if begun is None else begun
            if walker.phase("load")[1] > 0:
                break
    assert (walker.ticks - begun) * PERIOD == pytest.approx(WAIT, abs=2 * PERIOD)
    assert walker.phase("step_index")[0] == 2
