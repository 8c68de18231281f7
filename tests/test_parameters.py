"""Parameters that exist are valid."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lola_drake.parameters import ParameterError, parameter, validate


@dataclass(frozen=True)
class Params:
    """One field of each kind."""

    gain: float = parameter(0.5, "a gain", "1/s", minimum=0.0, maximum=1.0)
    time: float = parameter(1.0, "a time", "s", above=0.0, maximum=60)
    count: int = parameter(2, "a count", minimum=1, maximum=9)
    pair: tuple[float, float] = parameter((1.0, 2.0), "an array", "m", above=0.0, maximum=5)
    kind: str = parameter("a", "a choice", choices=("a", "b"))
    text: str = parameter("", "a text")
    on: bool = parameter(True, "a switch")

    def __post_init__(self):
        validate(self)


def test_defaults_are_valid():
    assert Params() == Params(0.5, 1.0, 2, (1.0, 2.0), "a", "", True)


def test_values_take_the_type_of_the_default():
    params = Params(gain=1, count=3.0, pair=[np.float64(3), np.int64(4)])
    assert (type(params.gain), type(params.count)) == (float, int)
    assert params.pair == (3.0, 4.0) and {type(entry) for entry in params.pair} == {float}
    assert hash(params) == hash(Params(gain=1.0, count=3, pair=(3.0, 4.0)))


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("gain", -0.1, "a number >= 0 and <= 1 1/s"),
        ("gain", 1.1, "a number >= 0 and <= 1 1/s"),
        ("gain", True, "a number >= 0 and <= 1 1/s"),
        ("gain", "0.5", "a number >= 0 and <= 1 1/s"),
        ("time", 0.0, "a number > 0 and <= 60 s"),
        ("time", math.nan, "a number > 0 and <= 60 s"),
        ("time", math.inf, "a number > 0 and <= 60 s"),
        ("time", None, "a number > 0 and <= 60 s"),
        ("time", 10**400, "a number > 0 and <= 60 s"),
        ("count", 2.5, "a whole number >= 1 and <= 9"),
        ("count", 0, "a whole number >= 1 and <= 9"),
        ("pair", 1.0, "a list of 2 numbers > 0 and <= 5 m"),
        ("pair", [1.0], "a list of 2 numbers > 0 and <= 5 m"),
        ("kind", "c", "one of a, b"),
        ("kind", 1, "one of a, b"),
        ("text", 5, "plain text of at most 60 characters"),
        ("on", 1, "true or false"),
    ],
)
def test_error_names_key_value_and_what_is_allowed(key, value, allowed):
    with pytest.raises(ParameterError) as caught:
        Params(**{key: value})
    message = str(caught.value)
    assert message.startswith(f"{key}: ") and message.endswith(f"it must be {allowed}")
    assert "\n" not in message and len(message) < 150


def test_error_names_the_entry_of_an_array():
    with pytest.raises(ParameterError, match=r"^pair\[1\]: -2.0 is not allowed"):
        Params(pair=(1.0, -2.0))


def test_error_seen_from_above_has_the_whole_key():
    with pytest.raises(ParameterError) as caught:
        Params(time=-1)
    assert str(caught.value.under("control")) == (
        "control.time: -1 is not allowed, it must be a number > 0 and <= 60 s"
    )


@given(st.floats() | st.integers())
def test_a_number_is_taken_exactly_or_refused(value):
    allowed = math.isfinite(float(value)) and 0 <= value <= 1 if abs(value) < 1e300 else False
    try:
        assert Params(gain=value).gain == value and allowed
    except ParameterError:
        assert not allowed


@pytest.mark.parametrize("bounds", [{}, {"minimum": 0}, {"maximum": 1}, {"above": 0}])
def test_a_number_without_a_bound_on_both_sides_cannot_be_declared(bounds):
    with pytest.raises(TypeError, match="parameter 'a gain': a number needs maximum= and one of"):
        parameter(0.5, "a gain", "1/s", **bounds)


@pytest.mark.parametrize("text", ["a\nb", "\x1b[2J", "\ud800", "\u202e", " a", "a ", "x" * 61])
def test_a_text_is_plain_and_short(text):
    with pytest.raises(ParameterError, match="plain text of at most 60 characters"):
        Params(text=text)
    assert Params(text="Straße, 100 % φ").text == "Straße, 100 % φ"
