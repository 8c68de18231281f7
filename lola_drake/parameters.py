"""Declared, validated parameters: every number a user can set knows its unit and its range.

A block's parameters are one frozen dataclass whose fields are made by `parameter`; its
`__post_init__` calls `validate`, so that an object that exists is an object that is valid.
"""

import dataclasses
import math
import numbers
import typing
from functools import cache

from lola_drake.errors import LolaError, shown

TEXT = 60
"""Greatest length of a text, unless it says otherwise."""


class ParameterError(LolaError):
    """A parameter that cannot be used: names the key, the value and what is allowed."""

    def __init__(self, key: str, value: object, allowed: str):
        super().__init__(f"{key}: {shown(value)} is not allowed, it must be {allowed}")
        self.key, self.value, self.allowed = key, value, allowed

    def __reduce__(self):
        return type(self), (self.key, self.value, self.allowed)

    def under(self, parent: str) -> "ParameterError":
        """Return the same error, seen from one level further up."""
        return ParameterError(f"{parent}.{self.key}", self.value, self.allowed)


def parameter(
    default: object,
    doc: str,
    unit: str = "",
    *,
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
    choices: tuple[str, ...] | None = None,
    symbol: str = "",
    slider: tuple[float, float, float] | None = None,
    longest: int = TEXT,
) -> typing.Any:
    """Declare one field: its default, its meaning, its unit and the range it may have.

    A number needs a bound on both sides: the one that physics gives it. A text has a greatest
    length, and no characters that a terminal could obey.

    Args:
        default: A number, a text or a truth value; a list or tuple declares an array of that
            length, and the range then holds for each entry.
        doc: What it is, in a few words.
        unit: Of the number.
        minimum: The least value.
        above: What it must be greater than, in place of `minimum`.
        maximum: The greatest value.
        choices: What a text may be.
        symbol: That of the paper, for sliders.
        slider: Least value, greatest value and step: the parameter is a gain, which may be turned
            while its block runs.
        longest: Greatest length of a text.
    """
    if isinstance(default, list):
        default = tuple(default)
    is_number = not isinstance(default, (bool, str))
    if is_number and (maximum is None or (minimum is None) == (above is None)):
        raise TypeError(f"parameter {doc!r}: a number needs maximum= and one of minimum=, above=")
    metadata = {
        "doc": doc,
        "unit": unit,
        "minimum": minimum,
        "above": above,
        "maximum": maximum,
        "choices": choices,
        "symbol": symbol,
        "slider": slider,
        "longest": longest,
    }
    return dataclasses.field(default=default, metadata=metadata)


def listing(doc: str, longest: int) -> typing.Any:
    """Declare a field `tuple[SomeParameters, ...]`, empty unless given: meaning, most entries."""
    return dataclasses.field(default=(), metadata={"doc": doc, "unit": "", "longest": longest})


def validate(parameters: typing.Any) -> None:
    """Check every field; raise ParameterError for the first bad one.

    Fields made by `parameter` take the type of their default, those made by `listing` become
    tuples, and a field with parameters of its own must hold such.
    """
    for field in dataclasses.fields(parameters):
        value = getattr(parameters, field.name)
        if "choices" in field.metadata:
            checked = _checked(field, value)
        elif "longest" in field.metadata:
            checked = _checked_list(field, value, element_type(parameters.__class__, field.name))
        else:
            checked = _checked_section(field, value)
        object.__setattr__(parameters, field.name, checked)


@cache
def element_type(owner: type, name: str) -> type:
    """Return what the entries of a field made by `listing` are."""
    return typing.get_args(typing.get_type_hints(owner)[name])[0]


def _checked_section(field: dataclasses.Field, value: typing.Any) -> typing.Any:
    kind = field.default_factory
    if isinstance(kind, type) and not isinstance(value, kind):
        raise ParameterError(field.name, value, f"of the class {kind.__name__}")
    return value


def _checked_list(field: dataclasses.Field, value: typing.Any, kind: type) -> tuple:
    longest = field.metadata["longest"]
    fits = isinstance(value, (list, tuple)) and len(value) <= longest
    if not fits or not all(isinstance(entry, kind) for entry in value):
        allowed = f"a list of at most {longest} entries of the class {kind.__name__}"
        raise ParameterError(field.name, value, allowed)
    return tuple(value)


def _checked(field: dataclasses.Field, value: typing.Any) -> typing.Any:
    if not isinstance(field.default, tuple):
        return _checked_scalar(field, field.name, value, type(field.default))
    length = len(field.default)
    if not isinstance(value, (list, tuple)) or len(value) != length:
        raise ParameterError(field.name, value, f"a list of {length} numbers{_range(field)}")
    return tuple(
        _checked_scalar(field, f"{field.name}[{i}]", entry, float) for i, entry in enumerate(value)
    )


def _checked_scalar(
    field: dataclasses.Field, key: str, value: typing.Any, kind: type
) -> typing.Any:
    if kind is bool:
        if not isinstance(value, bool):
            raise ParameterError(key, value, allowed(field))
        return value
    if kind is str:
        choices, longest = (field.metadata[k] for k in ("choices", "longest"))
        fits = isinstance(value, str) and len(value) <= longest and value.isprintable()
        if not fits or (choices and value not in choices) or value != value.strip():
            raise ParameterError(key, value, allowed(field))
        return value
    if not isinstance(value, bool) and isinstance(value, numbers.Real) and _is_finite(value):
        low, above, high = (field.metadata[k] for k in ("minimum", "above", "maximum"))
        inside = (value >= low if above is None else value > above) and value <= high
        if inside and (kind is float or value == math.floor(value)):
            return kind(value)
    whole = "a whole number" if kind is int else "a number"
    raise ParameterError(key, value, whole + _range(field))


def _is_finite(value: numbers.Real) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def allowed(field: dataclasses.Field) -> str:
    """Return what a field may be, in words."""
    default, metadata = field.default, field.metadata
    if "choices" not in metadata:
        return f"a list of at most {metadata['longest']} entries"
    if isinstance(default, tuple):
        return f"a list of {len(default)} numbers{_range(field)}"
    if isinstance(default, bool):
        return "true or false"
    if isinstance(default, str):
        text = f"plain text of at most {metadata['longest']} characters"
        return f"one of {', '.join(metadata['choices'])}" if metadata["choices"] else text
    return ("a whole number" if isinstance(default, int) else "a number") + _range(field)


def _range(field: dataclasses.Field) -> str:
    parts = [
        f"{sign} {field.metadata[key]:g}"
        for key, sign in (("minimum", ">="), ("above", ">"), ("maximum", "<="))
        if field.metadata[key] is not None
    ]
    unit = f" {field.metadata['unit']}" if field.metadata["unit"] not in ("", "-") else ""
    return " " + " and ".join(parts) + unit
