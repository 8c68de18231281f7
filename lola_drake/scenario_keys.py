"""Every setting of a scenario, as it can be looked up: key, default, unit, range, one line."""

import dataclasses
import typing
from collections.abc import Iterator
from dataclasses import dataclass

from lola_drake.parameters import allowed, element_type
from lola_drake.scenario import Scenario, ScenarioError
from lola_drake.typed_yaml import plain, suggestion


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes:
        key: Where it stands in a scenario; `[]` stands for the place in a list.
        default: Of it, as plain data.
        unit: Empty for what has none.
        minimum, above, maximum: Its range, None where that has no part.
        allowed: What it may be, in words.
        doc: What it is, in one line.
    """

    key: str
    default: object
    unit: str
    minimum: float | None
    above: float | None
    maximum: float | None
    allowed: str
    doc: str


def settings(prefix: str = "") -> list[Setting]:
    """Return the settings of a scenario whose keys begin with a prefix.

    Args:
        prefix: A key or the section of one, such as `control.force`; nothing for all.

    Raises:
        ScenarioError: If there are none.
    """
    known = list(_settings(Scenario, ""))
    found = [setting for setting in known if _below(setting.key, prefix)]
    if not found:
        sections = {setting.key.rpartition(".")[0] for setting in known} | {s.key for s in known}
        raise ScenarioError(f"{prefix[:60]}: no such key{suggestion(prefix, sorted(sections))}")
    return found


def _below(key: str, prefix: str) -> bool:
    """Return whether the parts of a key begin with those of a prefix; the last may be begun."""
    return key.startswith(prefix) or key.replace("[]", "").startswith(prefix)


def _settings(schema: type, parent: str) -> Iterator[Setting]:
    for field in dataclasses.fields(schema):
        key = f"{parent}{field.name}"
        if isinstance(field.default_factory, type):
            yield from _settings(field.default_factory, f"{key}.")
            continue
        told = field.metadata
        minimum, above, maximum = (told.get(name) for name in ("minimum", "above", "maximum"))
        yield Setting(
            key=key,
            default=plain(field.default),
            unit=told["unit"],
            minimum=minimum,
            above=above,
            maximum=maximum,
            allowed=allowed(field),
            doc=told["doc"],
        )
        if "choices" not in field.metadata:
            yield from _settings(element_type(schema, field.name), f"{key}[].")


def as_rows(found: list[Setting]) -> list[dict[str, typing.Any]]:
    """Return settings as plain data."""
    return [dataclasses.asdict(setting) for setting in found]
