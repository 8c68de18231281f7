"""The contact switches: their hysteresis, and which pad belongs to which switch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.tree import JointIndex

from lola_drake.blocks.contact_switches import (
    PAD_NAMES,
    ContactSwitches,
    ContactSwitchesParams,
    DeadSwitch,
    forces_in_world,
)
from lola_drake.parameters import ParameterError
from lola_drake.plant import pad_joints
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario
from lola_drake.signals import PERIOD
from lola_drake.world import build_simulation

CLOSE, OPEN = 15.0, 8.0


NO_GAPS = np.empty((0, 2))
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@pytest.fixture(scope="module")
def switched(kinematics):
    """Return the new state of a switch; all the others are pressed and stay closed."""

    def after(closed, force, close_force, open_force):
        contact, reactions = np.ones(8), np.tile([7.0, 7.0, 7.0, 9.0, -9.0, -1e3], 8)
        contact[5], reactions[6 * 5 + 5] = closed, -force
        law, tree = ContactSwitches.laws["next_contact"], kinematics.tree
        thresholds = np.full(8, close_force), np.full(8, open_force)
        result = law(contact, UPRIGHT, np.zeros(24), reactions, tree, *thresholds, NO_GAPS, 0.0)
        assert np.delete(result, 5).all()
        return result[5]

    return after


def test_open_switch_closes_above_the_upper_threshold(switched):
    states = [switched(0.0, force, CLOSE, OPEN) for force in (0.0, 10.0, CLOSE, CLOSE + 0.1)]
    assert states == [0.0, 0.0, 0.0, 1.0]


def test_closed_switch_opens_at_the_lower_threshold(switched):
    states = [switched(1.0, force, CLOSE, OPEN) for force in (20.0, 10.0, OPEN, OPEN - 0.1)]
    assert states == [1.0, 1.0, 0.0, 0.0]


@given(st.floats(OPEN, CLOSE, exclude_min=True), st.sampled_from([0.0, 1.0]))
def test_between_the_thresholds_nothing_switches(switched, force, closed):
    assert switched(closed, force, CLOSE, OPEN) == closed


@pytest.mark.parametrize("closed", [0.0, 1.0])
@given(force=st.floats(-50, 50))
def test_ideal_switch_has_no_hysteresis(switched, closed, force):
    ideal = ContactSwitchesParams().ideal()
    assert switched(closed, force, ideal.close_force, ideal.open_force) == float(force > 1.0)


def test_thresholds_in_the_wrong_order_are_refused():
    with pytest.raises(ParameterError, match="open_force"):
        ContactSwitchesParams(close_force=5.0, open_force=6.0)


def test_a_pad_bears_the_opposite_of_what_holds_it(kinematics):
    reactions = [SpatialForce([9.0, 9.0, 9.0], [k, 10.0 * k, 100.0 * k]) for k in range(20)]
    joints = (3, 5, 7, 9, 11, 13, 15, 17)
    switches = ContactSwitches(ContactSwitchesParams(), joints, kinematics.tree)
    read = switches.read_pad_reactions(reactions)
    loads = np.reshape(forces_in_world(UPRIGHT, np.zeros(24), read, kinematics.tree), (8, 3))
    np.testing.assert_array_equal(loads, np.outer(joints, [-1.0, -10.0, -100.0]))


def test_forces_are_turned_from_the_pads_to_the_world(kinematics):
    """Against Drake, with the torso and all joints turned."""
    plant, context = kinematics.plant, kinematics.plant.CreateDefaultContext()
    rng = np.random.default_rng(3)
    q, torso = 0.3 * rng.standard_normal(24), RollPitchYaw(0.2, -0.3, 0.7).ToQuaternion()
    plant.SetPositions(context, np.concatenate([torso.wxyz(), rng.standard_normal(3), q]))
    loads = rng.standard_normal((8, 3))
    expected = [
        plant.get_joint(JointIndex(joint))
        .frame_on_child()
        .CalcRotationMatrixInWorld(context)
        .matrix()
        @ load
        for joint, load in zip(pad_joints(plant), loads, strict=True)
    ]
    reactions = np.hstack([np.full((8, 3), 7.0), -loads]).ravel()
    forces = forces_in_world(torso.wxyz(), q, reactions, kinematics.tree)
    np.testing.assert_allclose(np.reshape(forces, (8, 3)), expected, atol=1e-12)


@pytest.fixture(scope="module")
def standing():
    """Return the simulation after a few ticks of standing."""
    from pydrake.systems.analysis import Simulator

    simulator = Simulator(build_simulation(Scenario()))
    simulator.AdvanceTo(20 * PERIOD)
    return simulator


def test_standing_robot_closes_every_switch_and_is_carried(standing):
    system = standing.get_system()
    switches = system.GetSubsystemByName("contact_switches")
    context = switches.GetMyContextFromRoot(standing.get_context())
    assert np.array_equal(switches.GetOutputPort("contact").Eval(context), np.ones(8))
    force = switches.GetOutputPort("ground_force").Eval(context)
    assert force[2] == pytest.approx(force[5], rel=0.02)
    assert force[2] + force[5] == pytest.approx(60.0 * 9.81, rel=0.2)


@pytest.mark.parametrize(("reads", "value"), [("open", 0.0), ("closed", 1.0)])
def test_a_dead_switch_says_the_same_from_the_start_on(kinematics, reads, value):
    dead = DeadSwitch(foot="r", pad="front_left", reads=reads)
    assert dead.number == 6 == 4 + PAD_NAMES.index("front_left")
    block = ContactSwitches(ContactSwitchesParams(dead=(dead,)).ideal(), (), kinematics.tree)
    contact = block.initial["contact"]
    assert contact[6] == value and np.delete(contact, 6).all()
    for load in (1e3, -1e3):
        reactions = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, -load], 8)
        thresholds = block.constant("closes_at"), block.constant("opens_at")
        law = block.laws["next_contact"]
        after = law(
            contact, UPRIGHT, np.zeros(24), reactions, kinematics.tree, *thresholds, NO_GAPS, 0.0
        )
        assert after[6] == value and (np.delete(after, 6) == (load > 0)).all()


def test_a_switch_is_dead_once():
    with pytest.raises(ParameterError, match="dead: .* every switch once"):
        ContactSwitchesParams(dead=(DeadSwitch(), DeadSwitch(reads="closed")))
