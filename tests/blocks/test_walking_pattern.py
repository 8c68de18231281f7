"""What the pattern generator hands over, tick by tick, over whole walks."""

import numpy as np
import pytest

from lola_drake.blocks.walking_pattern import WalkingPatternParams, standing_request
from lola_drake.signals import GAIT_PHASE, IDEAL_WRENCH, PLANNED_MOTION, TASK_REFERENCE
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.footholds import sole
from lola_drake.theory.step_request import HORIZON, pack_request, unpack_request

DT = 0.001
MASS = 60.0


def field(rows, signal, name):
    return rows[signal.name][:, signal.slice(name)]


def test_each_plan_continues_the_last_one(straight_walk):
    """Nowhere, also not where a new plan begins, does the motion jump in position or speed."""
    com, velocity = (field(straight_walk, PLANNED_MOTION, n) for n in ("com", "com_velocity"))
    moved, mean = np.diff(com, axis=0), (velocity[1:] + velocity[:-1]) / 2
    np.testing.assert_allclose(moved, DT * mean, atol=2e-7)
    assert np.abs(np.diff(velocity, axis=0)).max() < 6.0 * DT
    for foot in ("foot_l", "foot_r"):
        pose = field(straight_walk, PLANNED_MOTION, foot)
        assert np.abs(np.diff(pose, n=2, axis=0)).max() < 30.0 * DT**2


def test_task_rates_are_the_derivatives_of_the_task(straight_walk):
    """But for the instants in which a load begins or ends to move: there the sink has a kink."""
    for w, w_dot in (("w_l", "w_dot_l"), ("w_r", "w_dot_r"), ("toes", "toe_rates")):
        value = field(straight_walk, TASK_REFERENCE, w)
        rate = field(straight_walk, TASK_REFERENCE, w_dot)
        difference = (value[2:] - value[:-2]) / (2 * DT)
        wrong = np.abs(difference - rate[1:-1]).max(axis=1) > 2e-4
        changes = np.diff(field(straight_walk, GAIT_PHASE, "load")[:, 0], n=2)
        kinks = np.convolve(np.abs(changes) > 1e-9, np.ones(5), mode="same") > 0
        assert not np.any(wrong & ~kinks)


def test_loads_are_shared_and_rest_on_feet_that_stand(straight_walk):
    load, support = (field(straight_walk, GAIT_PHASE, name) for name in ("load", "support"))
    np.testing.assert_allclose(load.sum(axis=1), 1.0)
    assert load.min() >= 0
    assert np.all(load[support == 0] < 1e-9)
    assert np.all(support.sum(axis=1) >= 1)
    blend = field(straight_walk, GAIT_PHASE, "blend")
    assert blend.min() >= 0
    assert blend.max() <= 1


def test_ideal_wrench_acts_at_the_zmp(straight_walk):
    """Without yaw: F = m (c'' + g), and its torque about the CoM is that of F in the ZMP."""
    force, torque = (field(straight_walk, IDEAL_WRENCH, name) for name in "FT")
    velocity = field(straight_walk, PLANNED_MOTION, "com_velocity")
    acceleration = np.gradient(velocity, DT, axis=0)
    expected = MASS * (acceleration + [0, 0, GRAVITY])
    # A new plan may change the acceleration at once, and a difference quotient smears that.
    begun = field(straight_walk, GAIT_PHASE, "time_in_step")[:, 0] < 1.5 * DT
    inside = ~np.convolve(begun, np.ones(5), mode="same").astype(bool)
    np.testing.assert_allclose(force[inside], expected[inside], atol=0.5)
    com, zmp = (field(straight_walk, PLANNED_MOTION, name) for name in ("com", "zmp"))
    lever = np.column_stack([zmp, np.zeros(len(zmp))]) - com
    np.testing.assert_allclose(torque[:, :2], np.cross(lever, force)[:, :2], atol=1e-6)


def test_walk_arrives_and_comes_to_rest(straight_walk):
    com = field(straight_walk, PLANNED_MOTION, "com")
    forward = 5 * 0.3333 + WalkingPatternParams().zmp_forward
    np.testing.assert_allclose(com[-1, :2], [forward, 0.0], atol=2e-3)
    assert np.abs(field(straight_walk, PLANNED_MOTION, "com_velocity")[-1]).max() < 1e-3
    np.testing.assert_allclose(field(straight_walk, GAIT_PHASE, "load")[-1], 0.5)
    feet = [field(straight_walk, PLANNED_MOTION, foot)[-1] for foot in ("foot_l", "foot_r")]
    np.testing.assert_allclose(feet[0] - feet[1], [0, WalkingPatternParams().step_width, 0, 0])


def test_without_steps_it_stands(play_pattern):
    rows = play_pattern(900)
    for values in (rows["task_reference"], rows["ideal_wrench"]):
        np.testing.assert_allclose(values, values[:1].repeat(len(values), axis=0), atol=1e-9)
    assert np.all(field(rows, GAIT_PHASE, "step_index") == 0)


def test_steps_begin_when_they_are_to(play_pattern):
    rows = play_pattern(420, steps=np.tile([0.3, 0.0, 0.0, 0.0], (2, 1)), start_time=0.3)
    moving = np.abs(field(rows, PLANNED_MOTION, "com_velocity")).max(axis=1) > 1e-9
    assert 300 <= np.flatnonzero(moving)[0] <= 302


@pytest.mark.parametrize(("first", "later"), [(0.1, -0.1), (-0.1, 0.1)])
def test_the_first_step_says_which_foot_goes_first(play_pattern, first, later):
    """It is the one on the side to which it goes, wherever the later ones go."""
    steps = np.array([[0.0, first, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, later, 0.0, 0.0]])
    rows = play_pattern(3000, steps=steps)
    sideways = [field(rows, PLANNED_MOTION, foot)[:, 1] for foot in ("foot_l", "foot_r")]
    left, right = (np.flatnonzero(np.abs(y - y[0]) > 1e-6)[0] for y in sideways)
    assert (left < right) == (first > 0)


def test_command_starts_steers_and_stops_the_walk(play_pattern):
    def command(time):
        return np.array([0.3, 0.0, 0.2]) if time < 2.0 else np.zeros(3)

    rows = play_pattern(7000, command=command)
    heading = field(rows, PLANNED_MOTION, "heading")[:, 0]
    steps = field(rows, GAIT_PHASE, "step_index")[:, 0]
    assert steps[1500] >= 1
    assert heading[-1] > 0.3
    assert steps[-1] == steps[-1500]
    assert np.abs(field(rows, PLANNED_MOTION, "com_velocity")[-1]).max() < 2e-3


@pytest.mark.parametrize("stop", [2.1, 2.5])
@pytest.mark.parametrize("asked", [(0.5, 0.0, 0.0), (0.0, 0.18, 0.0), (0.0, 0.0, -0.49), (9, 9, 9)])
def test_stops_within_two_steps_in_any_phase(play_pattern, asked, stop):
    """The step that has begun is taken, and at most two follow; the feet are side by side then."""
    rows = play_pattern(6000, command=lambda time: np.array(asked) * (0.5 < time < stop))
    steps = field(rows, GAIT_PHASE, "step_index")[:, 0]
    begun = steps[round(stop / DT)] + 1
    assert begun <= steps[-1] <= begun + 2
    np.testing.assert_allclose(field(rows, GAIT_PHASE, "load")[-1], 0.5)
    left, right = (field(rows, PLANNED_MOTION, foot)[-1] for foot in ("foot_l", "foot_r"))
    width = WalkingPatternParams().step_width
    assert np.linalg.norm(left - right) == pytest.approx(width, abs=1e-6)
    np.testing.assert_allclose(sole(left[[0, 1, 3]]).overlaps(sole(right[[0, 1, 3]])), False)
    loaded = field(rows, GAIT_PHASE, "load").min(axis=1) > 0
    poses = [field(rows, PLANNED_MOTION, foot)[loaded][::50] for foot in ("foot_l", "foot_r")]
    for one, other in zip(*poses, strict=True):
        assert not sole(one[[0, 1, 3]]).overlaps(sole(other[[0, 1, 3]]))


def test_commands_turn_and_move_sideways_as_fast_as_asked(play_pattern):
    rows = play_pattern(6000, command=lambda time: np.array([0.0, 0.1, 0.2]))
    heading = field(rows, PLANNED_MOTION, "heading")[:, 0]
    pace = 2 * WalkingPatternParams().step_time
    assert heading[-1] - heading[-round(pace / DT) - 1] == pytest.approx(0.2 * pace, abs=1e-6)


def test_planned_height_is_climbed_step_by_step(play_pattern):
    steps = [[0.3, 0.0, 0.0, 0.1]] * 2 + [[0.3, 0.0, 0.0, -0.05]]
    rows = play_pattern(6000, steps=np.array(steps))
    left, right = (field(rows, PLANNED_MOTION, foot)[:, 2] for foot in ("foot_l", "foot_r"))
    index = field(rows, GAIT_PHASE, "step_index")[:, 0]
    landed = [np.flatnonzero(index == k)[0] for k in (1, 2, 3, 4)]
    np.testing.assert_allclose(left[landed], [0.1, 0.1, 0.15, 0.15], atol=1e-9)
    np.testing.assert_allclose(right[landed], [0.0, 0.2, 0.2, 0.15], atol=1e-9)
    com = field(rows, PLANNED_MOTION, "com")[:, 2]
    assert com[-1] == pytest.approx(WalkingPatternParams().com_height + 0.15)


def test_step_lasts_as_long_as_it_should(straight_walk):
    begins = np.flatnonzero(np.diff(field(straight_walk, GAIT_PHASE, "step_index")[:, 0])) * DT
    np.testing.assert_allclose(np.diff(begins), WalkingPatternParams().step_time, atol=1e-9)


def test_request_has_room_for_the_horizon():
    request = standing_request(WalkingPatternParams())
    packed = pack_request(request)
    assert unpack_request(packed).displacements.shape == (0, 4)
    assert packed.size == pack_request(unpack_request(packed)).size
    assert HORIZON == 3


@pytest.mark.parametrize(
    "step", [(0.3, 0.0, 0.0, 0.0), (0.2, 0.05, 0.1, 0.0), (-0.1, 0.0, -0.2, 0.0)]
)
def test_feet_never_sink_into_the_ground(play_pattern, step):
    rows = play_pattern(3000, steps=np.tile(step, (2, 1)))
    for foot in ("foot_l", "foot_r"):
        assert field(rows, PLANNED_MOTION, foot)[:, 2].min() > -1e-9
