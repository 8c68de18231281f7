"""Signals by their names."""

import pytest
from linear_toys import discrete, loop
from pydrake.systems.framework import LeafSystem

import lola_drake as lola
from lola_drake.block_system import BlockSystem
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.signal_names import signal_of, switches
from lola_drake.linear.wiring import Source, Target, Wiring
from lola_drake.signals import Field, Signal


@pytest.fixture(scope="module")
def wiring(standing):
    return Wiring(standing.diagram)


def test_every_input_is_fed_by_a_block_through_all_levels(wiring):
    target = Target("controller.imu_stabilizer", 1)
    assert wiring.feeds[target] == Source("imu", 0)
    assert wiring.feeds[Target("plant", 1)] == Source("controller.joint_servos", 1)


def test_an_input_that_hangs_in_the_air_is_its_own_source(wiring):
    source = wiring.select("plant.applied_generalized_force").source
    assert source == Source("plant", 2, is_input=True)


@pytest.mark.parametrize(
    ("name", "count", "first"),
    [
        ("measured_wrench", 12, "measured_wrench/F_l/x"),
        ("measured_wrench_l", 6, "measured_wrench/F_l/x"),
        ("measured_wrench.F_r.z", 1, "measured_wrench/F_r/z"),
        ("measured_wrench/F_r/z", 1, "measured_wrench/F_r/z"),
        ("task_command_r.w", 6, "task_command_r/w/x"),
        ("force_control_r.task_command.w.z", 1, "force_control_r/task_command/w/z"),
        ("plant.state.q.tkfl", 1, "plant/state/q/tkfl"),
        ("reaction_forces.fts_l.F", 3, "reaction_forces/fts_l/F/x"),
        ("walk_command", 3, "walk_command/0"),
    ],
)
def test_names_mean_entries(wiring, name, count, first):
    selection = wiring.select(name)
    assert (len(selection.entries), selection.labels[0]) == (count, first)
    assert wiring.select(selection.labels[-1]).entries[0] == selection.entries[-1]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("measured_rench", "no signal 'measured_rench', did you mean measured_wrench?"),
        ("task_command", "more than one signal 'task_command', say"),
        ("contact_results", "the signal 'contact_results' is not a vector"),
        ("measured_wrench.F_l.q", "measured_wrench has no such entry, did you mean F_l.z"),
    ],
)
def test_a_name_that_means_nothing_is_one_clear_error(wiring, name, message):
    with pytest.raises(AnalysisError, match=message):
        wiring.select(name)


def test_a_single_block_has_its_inputs_as_signals():
    block = discrete(0.5, 1.0, 1.0)
    block.set_name("filter")
    assert Wiring(block).select("u0").source == Source("", 0, is_input=True)
    assert Wiring(loop(block)).select("plant.y0").source == Source("plant", 0)


class Pressures(lola.Block):
    """A block of one's own, whose `contact` is no switch."""

    signals = (
        Signal("contact", "Pressures.", (Field("p", tuple("01234567"), "Pa"),)),
        Signal("load", "Their sum.", (Field("sum", ("",), "Pa"),)),
    )

    @lola.law
    def load(contact):
        """Return the sum of two, shape (1,)."""
        return (contact[0] + contact[7],)


def test_a_signal_is_what_the_block_declares_not_what_its_name_suggests():
    own = BlockSystem(Pressures()).get_input_port(0)
    assert (own.get_name(), own.size()) == ("contact", 8)
    assert not switches(own).any()
    assert signal_of(own).entry_units() == ("Pa",) * 8
    undeclared = LeafSystem().DeclareVectorInputPort("contact", 8)
    assert switches(undeclared).all()
