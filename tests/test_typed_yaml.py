"""YAML in and out."""

from dataclasses import dataclass, field

import pytest

from lola_drake import typed_yaml
from lola_drake.parameters import ParameterError, listing, parameter, validate


@dataclass(frozen=True)
class Part:
    """The inner dataclass."""

    size: float = parameter(1.0, "a size", "m", above=0.0, maximum=1e300)
    pair: tuple[float, float] = parameter((0.0, 1.0), "an array", minimum=-9, maximum=9)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Whole:
    """The outer dataclass."""

    name: str = parameter("", "a name")
    part: Part = field(default_factory=Part)
    parts: tuple[Part, ...] = listing("parts", 3)

    def __post_init__(self):
        validate(self)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e5", 1e5), ("-2.5E-3", -2.5e-3), ("1.e2", 100.0), (".5e1", 5.0), ("1e5x", "1e5x")],
)
def test_numbers_with_exponent(text, value):
    assert typed_yaml.parse(text) == value


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb: [1", "line 2: "),
        ("a: 1\nb: 2: 3", "line 2: mapping values"),
        ("a: 1\nb:\n  c: 1\n  c: 2", "line 4: the key 'c' appears twice"),
        ("{[1]: 2}", "line 1: found unhashable key"),
        ("a: 1\n---\nb: 2", "line 2: "),
        ("\x07", "unacceptable character"),
        ("a: !!python/object:os.system {}", "line 1: the tag tag:yaml.org,2002"),
        ("[" * 5000, "nested too deeply"),
    ],
)
def test_malformed_text_is_one_line_with_the_place(text, message):
    with pytest.raises(ValueError) as caught:
        typed_yaml.parse(text)
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


def test_build_nests_and_keeps_defaults():
    data = typed_yaml.parse("name: a\nparts: [{size: 2}, {pair: [3, 4]}]")
    expected = Whole("a", parts=(Part(size=2.0), Part(pair=(3.0, 4.0))))
    assert typed_yaml.build(Whole, data) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nam: a", "nam: no such key, did you mean name?"),
        ("part: {q: 1}", "part.q: no such key, there are size, pair"),
        ("parts: [{}, {siz: 1}]", r"parts\[1\].siz: no such key, did you mean size?"),
        ("5: 1", "5: no such key, there are name, part, parts"),
    ],
)
def test_unknown_key_suggests_known_ones(text, message):
    with pytest.raises(typed_yaml.KeyPathError, match=message):
        typed_yaml.build(Whole, typed_yaml.parse(text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1]", "content: [1] is not allowed, it must be a mapping"),
        ("part: 1", "part: 1 is not allowed, it must be a mapping"),
        ("part:", "part: None is not allowed, it must be a mapping"),
        ("parts: {}", "parts: {} is not allowed, it must be a list"),
        (
            "part: {size: -1}",
            "part.size: -1 is not allowed, it must be a number > 0 and <= 1e+300 m",
        ),
        ("parts: [{pair: [1, x]}]", "parts[0].pair[1]: 'x' is not allowed, it must be a number"),
    ],
)
def test_bad_value_has_the_whole_key(text, message):
    with pytest.raises(ParameterError) as caught:
        typed_yaml.build(Whole, typed_yaml.parse(text))
    assert str(caught.value).startswith(message)


def test_dump_is_read_back_exactly():
    whole = Whole("no", Part(1 / 3), (Part(1e-17), Part(1e300, (5.0, -0.0))))
    assert typed_yaml.build(Whole, typed_yaml.parse(typed_yaml.dump(whole))) == whole


def test_set_at_reaches_keys_and_list_entries():
    data = {"a": {"b": [{"c": 1}, 2]}}
    typed_yaml.set_at(data, "a.b.0.c", 3)
    typed_yaml.set_at(data, "a.b[1]", 4)
    assert data == {"a": {"b": [{"c": 3}, 4]}}


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("x", "x: no such key, there are a"),
        ("a.x", "a.x: no such key, there are b"),
        ("a.b.2", "a.b.2: no such key, there are 0, 1"),
        ("a.b.-1", "a.b.-1: no such key, did you mean 1?"),
        ("a.b.0.c", "a.b.0.c: no such key, there is nothing below it"),
    ],
)
def test_set_at_sets_only_what_exists(path, message):
    with pytest.raises(typed_yaml.KeyPathError) as caught:
        typed_yaml.set_at({"a": {"b": [1, 2]}}, path, 3)
    assert str(caught.value) == message


def test_leaves_are_flat():
    data = {"a": {"b": 1, "c": {"d": [2]}}, "e": 3}
    assert typed_yaml.leaves(data) == {"a.b": 1, "a.c.d": [2], "e": 3}


@pytest.mark.parametrize(
    "text",
    ["1:30", "010", "0x1F", "1_000", "yes", "no", "on", "2017-06-01", "1e5", "null", "~", ""],
)
def test_a_text_that_looks_like_something_else_is_read_back(text):
    assert typed_yaml.parse(typed_yaml.dump(Whole(name=text)))["name"] == text


@pytest.mark.parametrize("text", ["1:30", "010", "0x1F", "1_000", "yes", "on", "2017-06-01"])
def test_what_yaml_1_1_reads_as_something_else_is_text(text):
    assert typed_yaml.parse(text) == text
