"""The contact switches: hysteresis, and the true force of every pad."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from lola_drake.blocks.contact_switches import ContactSwitchesParams, pad_forces, switched
from lola_drake.parameters import ParameterError
from lola_drake.scenario import load_scenario
from lola_drake.signals import CONTACT, GROUND_FORCE
from lola_drake.simulation import build_simulation, pad_geometries
from lola_drake.theory.constants import GRAVITY

CLOSE, OPEN = 15.0, 8.0


@given(st.lists(st.floats(0, 40), min_size=1, max_size=50))
def test_switch_closes_and_opens_at_its_thresholds(forces):
    closed = 1.0
    for force in forces:
        before, closed = closed, switched(closed, force, CLOSE, OPEN)
        if force > CLOSE:
            assert closed == 1.0
        elif force <= OPEN:
            assert closed == 0.0
        else:
            assert closed == before


def test_opening_force_must_not_be_the_larger_one():
    with pytest.raises(ParameterError, match="open_force"):
        ContactSwitchesParams(close_force=5.0, open_force=6.0)


class Standing:
    """LOLA on the floor, lifted or tilted at will; its switches are looked at without time."""

    def __init__(self):
        self.diagram = build_simulation(load_scenario("stand", {"sensors.ideal": True}))
        self.simulator = Simulator(self.diagram)
        self.simulator.AdvanceTo(0.3)
        self.context = self.simulator.get_mutable_context()
        self.plant = self.diagram.GetSubsystemByName("plant")
        self.plant_context = self.plant.GetMyMutableContextFromRoot(self.context)
        self.state = self.plant.GetPositionsAndVelocities(self.plant_context)
        self.pads = pad_geometries(self.plant, self.diagram.GetSubsystemByName("scene_graph"))

    def lift(self, height):
        moved = self.state.copy()
        moved[6] += height
        self.plant.SetPositionsAndVelocities(self.plant_context, moved)

    def switches(self):
        """Return the next state of the switches, and the ground's force on both feet."""
        block = self.diagram.GetSubsystemByName("contact_switches")
        update = block.EvalUniquePeriodicDiscreteUpdate(block.GetMyContextFromRoot(self.context))
        return update.value(0), update.value(1)

    def forces(self):
        results = self.plant.get_contact_results_output_port().Eval(self.plant_context)
        return np.array(pad_forces(results, self.pads))


@pytest.fixture(scope="module")
def standing():
    return Standing()


def test_every_pad_has_a_switch(standing):
    assert sorted(standing.pads.values()) == list(range(CONTACT.size))


def test_standing_closes_all_and_the_forces_carry_the_weight(standing):
    standing.lift(0.0)
    closed, ground_force = standing.switches()
    np.testing.assert_array_equal(closed, 1.0)
    vertical = ground_force[[GROUND_FORCE.slice(f"F_{foot}").stop - 1 for foot in "lr"]]
    assert vertical.sum() == pytest.approx(60.0 * GRAVITY, rel=5e-3)
    np.testing.assert_allclose(
        ground_force, standing.forces().reshape(2, 4, 3).sum(axis=1).ravel(), atol=1e-9
    )


def test_lifted_robot_opens_all(standing):
    standing.lift(0.05)
    closed, ground_force = standing.switches()
    np.testing.assert_array_equal(closed, 0.0)
    np.testing.assert_array_equal(ground_force, 0.0)


@pytest.mark.parametrize(("pitch", "loaded"), [(-0.02, [0, 1, 4, 5]), (0.02, [2, 3, 6, 7])])
def test_leaning_loads_the_pads_in_front_or_in_the_rear(standing, pitch, loaded):
    moved = standing.state.copy()
    moved[:4] = [np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0]
    standing.plant.SetPositionsAndVelocities(standing.plant_context, moved)
    force = standing.forces()[:, 2]
    assert force[loaded].min() > np.delete(force, loaded).max()
