"""What a sweep varies, as it is written on the command line: KEY=FROM:TO:N, or KEY=a,b,c."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lola_drake import typed_yaml
from lola_drake.errors import LolaError, shown
from lola_drake.scenario import Scenario, override

MOST_VALUES = 10_000
"""Of one key."""


class SweepError(LolaError):
    """A sweep that cannot be made; the message is one line that says what and why."""


@dataclass(frozen=True)
class Factor:
    """One key that is varied, over some values or over a range.

    Attributes:
        key: of the scenario.
        values: in their order; of a range without a number, its two ends.
        is_range: whether anything between the ends may be taken.
        is_whole: whether only whole numbers may be taken.
    """

    key: str
    values: tuple[Any, ...]
    is_range: bool = False
    is_whole: bool = False

    def at(self, share: float) -> Any:
        """Return the value at a part of the way, from 0 to below 1."""
        if not self.is_range:
            return self.values[int(share * len(self.values))]
        low, high = self.values
        if self.is_whole:
            return int(low + np.floor(share * (high - low + 1)))
        return float(low + share * (high - low))


def parse_factors(texts: Sequence[str], base: Scenario) -> list[Factor]:
    """Return what some texts want varied of a scenario.

    Raises:
        SweepError: If one of them cannot be understood, or there is none, or a key twice.
        ScenarioError: If a key does not exist.
    """
    factors = [_parsed(text, base) for text in texts]
    if not factors:
        raise SweepError("nothing to sweep over: give --vary KEY=FROM:TO:N or KEY=a,b,c")
    keys = [factor.key for factor in factors]
    for key in keys:
        if keys.count(key) > 1:
            raise SweepError(f"{key}: is varied twice")
    return factors


def _parsed(text: str, base: Scenario) -> Factor:
    key, equals, what = text.partition("=")
    if not (key and equals and what):
        raise SweepError(f"{shown(text)} is not of the form KEY=FROM:TO:N or KEY=a,b,c")
    whole = _is_whole(base, key)
    if ":" in what and "{" not in what:
        return _range(key, what, whole)
    try:
        values = typed_yaml.parse(f"[{what}]")
    except ValueError as error:
        raise SweepError(f"{key}: {shown(what)} is no list of values, {error}") from None
    if len(values) > MOST_VALUES or len(set(map(repr, values))) < len(values):
        raise SweepError(f"{key}: {shown(what)}, all different and at most {MOST_VALUES:,}")
    return Factor(key, tuple(values))


def _range(key: str, what: str, whole: bool) -> Factor:
    parts = what.split(":")
    numbers = [number for part in parts if (number := _number(part)) is not None]
    if not 2 <= len(parts) == len(numbers) <= 3:
        raise SweepError(f"{key}: {shown(what)} is not of the form FROM:TO:N, all of them numbers")
    low, high, *count = numbers
    if not low < high:
        raise SweepError(f"{key}: {shown(what)} must go from a number to a larger one")
    if whole and not (low == int(low) and high == int(high)):
        raise SweepError(f"{key}: {shown(what)} must go from a whole number to another")
    if not count:
        return Factor(key, (low, high), is_range=True, is_whole=whole)
    if count[0] != int(count[0]) or not 2 <= count[0] <= MOST_VALUES:
        raise SweepError(f"{key}: {shown(what)} must have from 2 to {MOST_VALUES:,} values")
    # Rounded, so that 0.1:0.3:3 is 0.2 in the middle, as one would write it.
    values = [float(f"{value:.12g}") for value in np.linspace(low, high, int(count[0]))]
    if whole and any(value != int(value) for value in values):
        raise SweepError(f"{key}: {shown(what)} are not whole numbers, as it has to be")
    return Factor(key, tuple(map(int, values)) if whole else tuple(values))


def _is_whole(base: Scenario, key: str) -> bool:
    """Return whether a key holds whole numbers; ScenarioError if it does not exist."""
    override(base, {key: value_at(base, key)})
    value = value_at(base, key)
    return isinstance(value, int) and not isinstance(value, bool)


def value_at(scenario: Scenario, key: str) -> object:
    """Return a value of a scenario by its dotted key, None if there is none."""
    found: object = typed_yaml.plain(scenario)
    for name in key.replace("[", ".").replace("]", "").split("."):
        if isinstance(found, Mapping):
            found = found.get(name)
        elif isinstance(found, list) and name.isdigit() and int(name) < len(found):
            found = found[int(name)]
        else:
            return None
    return found


def _number(text: str) -> float | None:
    try:
        value = typed_yaml.parse(text)
    except ValueError:
        return None
    return value if _is_number(value) and np.isfinite(value) else None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
