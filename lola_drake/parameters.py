"""Declared, validated parameters: every number a user can set knows its unit and its range.

A block's parameters are one frozen dataclass whose fields are made by `parameter`; its
`__post_init__` calls `validate`, so that an object that exists is an object that is valid.
"""

import dataclasses
import math
import numbers
import reprlib
import typing


class ParameterError(ValueError):
    """A parameter that cannot be used: names the key, the value and what is allowed."""

    def __init__(self, key: str, value: object, allowed: str):
        super().__init__(f"{key}: {reprlib.repr(value)} is not allowed, it must be {allowed}")
        self.key, self.value, self.allowed = key, value, allowed

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
) -> typing.Any:
    """Declare one field: its default, its meaning, its unit and the range it may have.

    A list or tuple default declares an array of that length; the range then holds for
    each entry. A parameter with a slider (least value, greatest value, step) is a gain: it may be
    turned while its block runs. Its symbol is that of the paper.
    """
    metadata = {
        "doc": doc,
        "unit": unit,
        "minimum": minimum,
        "above": above,
        "maximum": maximum,
        "choices": choices,
        "symbol": symbol,
        "slider": slider,
    }
    if isinstance(default, list):
        default = tuple(default)
    return dataclasses.field(default=default, metadata=metadata)


def validate(parameters: object) -> None:
    """Check every field made by `parameter`; raise ParameterError for the first bad one."""
    for field in dataclasses.fields(parameters):
        if "unit" not in field.metadata:
            continue
        value = getattr(parameters, field.name)
        if isinstance(field.default, tuple):
            checked = _checked_tuple(field, value)
        else:
            checked = _checked_scalar(field, field.name, value, type(field.default))
        object.__setattr__(parameters, field.name, checked)


def _checked_tuple(field: dataclasses.Field, value: object) -> tuple:
    length = len(field.default)
    if not isinstance(value, (list, tuple)) or len(value) != length:
        raise ParameterError(field.name, value, f"a list of {length} numbers{_range(field)}")
    return tuple(
        _checked_scalar(field, f"{field.name}[{i}]", entry, float) for i, entry in enumerate(value)
    )


def _checked_scalar(field: dataclasses.Field, key: str, value: object, kind: type) -> object:
    if kind is bool:
        if not isinstance(value, bool):
            raise ParameterError(key, value, "true or false")
        return value
    if kind is str:
        choices = field.metadata["choices"]
        if not isinstance(value, str) or (choices and value not in choices):
            raise ParameterError(key, value, f"one of {', '.join(choices)}" if choices else "text")
        return value
    wanted = "a whole number" if kind is int else "a number"
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise ParameterError(key, value, wanted + _range(field))
    if not _is_finite(value) or (kind is int and value != int(value)):
        raise ParameterError(key, value, wanted + _range(field))
    low, above, high = (field.metadata[k] for k in ("minimum", "above", "maximum"))
    outside = (
        (low is not None and value < low)
        or (above is not None and value <= above)
        or (high is not None and value > high)
    )
    if outside:
        raise ParameterError(key, value, wanted + _range(field))
    return kind(value)


def _is_finite(value: numbers.Real) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def _range(field: dataclasses.Field) -> str:
    parts = [
        f"{sign} {field.metadata[key]:g}"
        for key, sign in (("minimum", ">="), ("above", ">"), ("maximum", "<="))
        if field.metadata[key] is not None
    ]
    unit = f" {field.metadata['unit']}" if field.metadata["unit"] else ""
    return (" " + " and ".join(parts) if parts else "") + unit
