"""YAML text to frozen dataclasses and back, with errors that say where and what.

A dataclass is its own schema: its fields are the keys that may appear, a field that is a
dataclass is a mapping, a `tuple[SomeDataclass, ...]` is a list of mappings. Ranges are checked by
the dataclasses themselves (see `parameters`); this module adds the way to the key.
"""

import dataclasses
import difflib
import re
import typing
from collections.abc import Iterable

import yaml

from lola_drake.errors import LolaError, short
from lola_drake.parameters import ParameterError, element_type


class KeyPathError(LolaError):
    """A key that does not exist."""

    def __init__(self, key: str, name: object, known: Iterable[str]):
        whole = _join(short(key, 60), short(str(name), 40))
        super().__init__(f"{whole}: no such key{suggestion(name, known)}")
        self.key = key


def suggestion(name: object, known: Iterable[str]) -> str:
    """Return the end of an error about an unknown name: what may have been meant."""
    known = list(known)
    near = difflib.get_close_matches(str(name)[:100], known)
    if near:
        return f", did you mean {' or '.join(near)}?"
    return f", there are {short(', '.join(known), 80)}" if known else ", there is nothing below it"


class _Loader(yaml.SafeLoader):
    """SafeLoader of the core of YAML 1.2, without repeated keys and tags.

    Version 1.1 reads 1:30 as 90, 010 as 8, no as false and 2017-06-01 as a date. Here they are
    texts, so that what asks for a number refuses them.
    """

    yaml_implicit_resolvers = {}

    def compose_node(self, parent: yaml.Node | None, index: typing.Any) -> yaml.Node | None:
        """Compose a node, but none with a tag of its own such as !!timestamp."""
        event = self.peek_event()
        if getattr(event, "tag", None) is not None:
            problem = f"the tag {short(event.tag, 40)} is not wanted, write a plain value"
            raise yaml.constructor.ConstructorError(None, None, problem, event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        """Build a dict, but not from a mapping in which one key hides another."""
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        seen = set()
        for key in keys:
            if key.value in seen:
                problem = f"the key {short(key.value, 40)!r} appears twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


_WHOLE = r"[-+]?(0|[1-9]\d{0,17})"
_EXPONENT = r"[eE][-+]?\d{1,4}"
_FLOAT = rf"[-+]?((0|[1-9]\d*)(\.\d*)?|\.\d+)({_EXPONENT})?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"


class _Dumper(yaml.SafeDumper):
    """SafeDumper that quotes what is a number in either version of YAML."""


for _tag, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", _WHOLE, list("-+0123456789")),
    ("float", _FLOAT, list("-+.0123456789")),
):
    _resolver = f"tag:yaml.org,2002:{_tag}", re.compile(rf"(?:{_pattern})$"), _first
    _Loader.add_implicit_resolver(*_resolver)
    _Dumper.add_implicit_resolver(*_resolver)


def parse(text: str) -> typing.Any:
    """Return the plain data of a YAML text; ValueError with the line if it is malformed."""
    try:
        return yaml.load(text, Loader=_Loader)  # a SafeLoader
    except yaml.MarkedYAMLError as error:
        problem = short(" ".join(str(error.problem or error.context).split()), 120)
        mark = error.problem_mark or error.context_mark
        raise ValueError(f"line {mark.line + 1}: {problem}" if mark else problem) from None
    except yaml.YAMLError as error:
        raise ValueError(short(str(error).splitlines()[0], 120)) from None
    except RecursionError:
        raise ValueError("nested too deeply") from None


def build(schema: type, data: object, key: str = "") -> typing.Any:
    """Return the dataclass `schema` made from plain data; absent keys keep their defaults.

    Args:
        schema: A dataclass whose fields all have defaults.
        data: A mapping, as `parse` returns it.
        key: Where `data` lies in the whole, for errors.
    """
    if not isinstance(data, dict):
        raise ParameterError(key or "content", data, "a mapping of keys to values")
    kinds = typing.get_type_hints(schema)
    for name in data:
        if name not in kinds:
            raise KeyPathError(key, name, kinds)
    values = {
        name: _value(schema, name, kinds[name], data[name], _join(key, name)) for name in data
    }
    try:
        return schema(**values)
    except ParameterError as error:
        raise (error.under(key) if key else error) from None


def _value(schema: typing.Any, name: str, kind: type, entry: typing.Any, key: str) -> typing.Any:
    if dataclasses.is_dataclass(kind):
        return build(kind, entry, key)
    field = schema.__dataclass_fields__[name]
    if field.default != ():
        return entry
    longest = field.metadata["longest"]
    if not isinstance(entry, list) or len(entry) > longest:
        raise ParameterError(key, entry, f"a list of at most {longest} entries")
    element = element_type(schema, name)
    return tuple(build(element, item, f"{key}[{i}]") for i, item in enumerate(entry))


def plain(value: typing.Any) -> typing.Any:
    """Return dataclasses, tuples and NumPy numbers as the dicts, lists and numbers of YAML."""
    if dataclasses.is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value.tolist() if hasattr(value, "tolist") else value


def dump(value: object) -> str:
    """Return a dataclass as YAML text from which `parse` and `build` make an equal one."""
    return yaml.dump(
        plain(value),
        Dumper=_Dumper,
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=None,
        width=100,
    )


def set_at(data: typing.Any, path: str, value: object) -> None:
    """Set one value of nested plain data in place.

    Args:
        data: Dicts and lists, complete: only what is there can be set.
        path: Dotted keys and list positions, such as `ground.obstacles.0.height`, or
            `ground.obstacles[0].height` as errors write it.
        value: The new value.
    """
    way, walked = path.replace("[", ".").replace("]", "").split("."), ""
    for depth, name in enumerate(way):
        if isinstance(data, list):
            known = {str(i): i for i in range(len(data))}
        else:
            known = {key: key for key in data} if isinstance(data, dict) else {}
        if name not in known:
            raise KeyPathError(walked, name, known)
        if depth == len(way) - 1:
            data[known[name]] = value
        data, walked = data[known[name]], _join(walked, name)


def leaves(data: typing.Any, key: str = "") -> dict[str, typing.Any]:
    """Return nested dicts as one flat dict with dotted keys; lists count as values."""
    if not isinstance(data, dict):
        return {key: data}
    return {k: v for name in data for k, v in leaves(data[name], _join(key, name)).items()}


def _join(key: str, name: object) -> str:
    return f"{key}.{name}" if key else str(name)
