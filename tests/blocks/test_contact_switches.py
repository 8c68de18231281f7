"""The contact switches: their hysteresis, and which pad belongs to which switch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.blocks.contact_switches import ContactSwitches, ContactSwitchesParams
from lola_drake.parameters import ParameterError
from lola_drake.scenario import Scenario
from lola_drake.signals import PERIOD
from lola_drake.world import build_simulation

CLOSE, OPEN = 15.0, 8.0


class _Force:
    def __init__(self, force):
        self._force = np.array(force)

    def translational(self):
        return self._force


class _Id:
    def __init__(self, value):
        self._value = value

    def get_value(self):
        return self._value


class _Contact:
    """A contact between two geometries, as the plant reports it."""

    def __init__(self, m, n, force):
        self._m, self._n, self._force = m, n, force

    def contact_surface(self):
        return self

    def id_M(self):
        return _Id(self._m)

    def id_N(self):
        return _Id(self._n)

    def F_Ac_W(self):
        return _Force(self._force)


class Results:
    def __init__(self, *contacts):
        self._contacts = contacts

    def num_hydroelastic_contacts(self):
        return len(self._contacts)

    def hydroelastic_contact_info(self, i):
        return self._contacts[i]


def switched(closed, force, close_force, open_force):
    """Return the new state of a switch; all the others are pressed and stay closed."""
    contact, forces = np.ones(8), np.tile([9.0, -9.0, 1e3], 8)
    contact[5], forces[3 * 5 + 2] = closed, force
    after = ContactSwitches.laws["next_contact"](contact, forces, close_force, open_force)
    assert np.delete(after, 5).all()
    return after[5]


def test_open_switch_closes_above_the_upper_threshold():
    states = [switched(0.0, force, CLOSE, OPEN) for force in (0.0, 10.0, CLOSE, CLOSE + 0.1)]
    assert states == [0.0, 0.0, 0.0, 1.0]


def test_closed_switch_opens_at_the_lower_threshold():
    states = [switched(1.0, force, CLOSE, OPEN) for force in (20.0, 10.0, OPEN, OPEN - 0.1)]
    assert states == [1.0, 1.0, 0.0, 0.0]


@given(st.floats(OPEN, CLOSE, exclude_min=True), st.sampled_from([0.0, 1.0]))
def test_between_the_thresholds_nothing_switches(force, closed):
    assert switched(closed, force, CLOSE, OPEN) == closed


@pytest.mark.parametrize("closed", [0.0, 1.0])
@given(force=st.floats(-50, 50))
def test_ideal_switch_has_no_hysteresis(closed, force):
    ideal = ContactSwitchesParams().ideal()
    assert switched(closed, force, ideal.close_force, ideal.open_force) == float(force > 1.0)


def test_thresholds_in_the_wrong_order_are_refused():
    with pytest.raises(ParameterError, match="open_force"):
        ContactSwitchesParams(close_force=5.0, open_force=6.0)


def test_forces_on_a_pad_add_up_with_their_signs():
    results = Results(
        _Contact(100, 1, [1.0, 2.0, 30.0]),
        _Contact(2, 100, [-4.0, 0.0, -5.0]),
        _Contact(8, 9, [7.0, 7.0, 7.0]),
    )
    forces = ContactSwitches(ContactSwitchesParams(), {100: 6}).read_pad_forces(results)
    expected = np.zeros((8, 3))
    expected[6] = [5.0, 2.0, 35.0]
    assert np.array_equal(np.reshape(forces, (8, 3)), expected)


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
