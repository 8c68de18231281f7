"""The layout of the signals."""

import pytest

from lola_drake import signals
from lola_drake.signals import JOINTS, Field, Signal

ALL = [value for value in vars(signals).values() if isinstance(value, Signal)]


@pytest.mark.parametrize("signal", ALL, ids=lambda signal: signal.name)
def test_fields_cover_the_vector_once(signal):
    covered = [i for field in signal.fields for i in range(signal.size)[signal.slice(field.name)]]
    assert covered == list(range(signal.size))
    names = signal.entry_names()
    assert len(set(names)) == signal.size == len(signal.entry_units()) == len(signal.entry_frames())


def test_names_are_their_own():
    assert len({signal.name for signal in ALL}) == len(ALL)
    assert len(set(JOINTS)) == len(JOINTS) == 24


SIGNAL = Signal("some", "", (Field("p", ("x", "y", "z"), "m"), Field("angle", ("",), "rad")))


def test_slice_can_be_the_beginning_of_a_field():
    assert SIGNAL.slice("p") == slice(0, 3)
    assert SIGNAL.slice("p", 2) == slice(0, 2)
    assert SIGNAL.index("angle") == 3
    assert SIGNAL.entry_names() == ("p.x", "p.y", "p.z", "angle")


@pytest.mark.parametrize("ask", [SIGNAL.slice, SIGNAL.index])
def test_unknown_field_is_an_error(ask):
    with pytest.raises(KeyError, match="some has no field 'q'"):
        ask("q")


def test_wide_field_has_no_single_index():
    with pytest.raises(KeyError, match="3 entries"):
        SIGNAL.index("p")
