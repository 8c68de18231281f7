"""A diagram flattened to its blocks: which output feeds which input, and every signal by name."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import (
    Diagram,
    InputPort,
    InputPortIndex,
    OutputPort,
    OutputPortIndex,
    System,
)

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.signal_names import entry_names, is_vector
from lola_drake.linear.units import entry_units
from lola_drake.typed_yaml import suggestion


class Source(NamedTuple):
    """Where a signal comes from: a block's output, or an input that nothing inside feeds.

    Attributes:
        block: path of the block; empty for the whole system.
        port: its number.
        is_input: whether the port is an input: of the whole, or of a block if it hangs in the air.
    """

    block: str
    port: int
    is_input: bool = False


class Target(NamedTuple):
    """One input port of a block."""

    block: str
    port: int


@dataclass(frozen=True)
class Selection:
    """Some entries of one signal.

    Attributes:
        source: the signal.
        entries: their positions.
        labels: their names, unique, in the form `signal/field/entry`.
        units: of them; empty where none is known.
    """

    source: Source
    entries: np.ndarray
    labels: tuple[str, ...]
    units: tuple[str, ...]

    @property
    def labels_with_units(self) -> list[str]:
        """Return the labels, each with its unit in brackets if it has one."""
        pairs = zip(self.labels, self.units, strict=True)
        return [f"{label} ({unit})" if unit else label for label, unit in pairs]


class Wiring:
    """The blocks of a system and how they are connected.

    Attributes:
        system: what was flattened: a Diagram, or one block.
        blocks: every leaf system by its path below `system`, such as `controller.imu_stabilizer`.
        feeds: the source of every input port of every block.
    """

    def __init__(self, system: System):
        """Flatten a system."""
        self.system = system
        self.blocks = dict(_leaves(system, ""))
        self._paths = {block.GetSystemPathname(): path for path, block in self.blocks.items()}
        self.feeds: dict[Target, Source] = {}
        for source, targets in self._connections():
            self.feeds.update(dict.fromkeys(targets, source))
        for path, block in self.blocks.items():
            for i in range(block.num_input_ports()):
                self.feeds.setdefault(Target(path, i), Source(path, i, is_input=True))
        self._names = self._collect_names()

    def port(self, source: Source) -> InputPort | OutputPort:
        """Return Drake's port of a source."""
        system = self.blocks[source.block] if source.block else self.system
        return (
            system.get_input_port(source.port)
            if source.is_input
            else system.get_output_port(source.port)
        )

    def size(self, source: Source) -> int:
        """Return the number of entries of a source's signal."""
        return len(self.entry_names(source))

    def entry_names(self, source: Source) -> tuple[str, ...]:
        """Return the names of the entries of a source's signal."""
        return entry_names(*self._described(source))

    def _described(self, source: Source) -> tuple[System, InputPort | OutputPort]:
        """Return the block and its port that know best what a signal is: its source, or a reader.

        An input of the whole is what its first reader takes it for.
        """
        if source.block:
            return self.blocks[source.block], self.port(source)
        targets = self.targets(source)
        if not targets:
            return self.system, self.port(source)
        block = self.blocks[targets[0].block]
        return block, block.get_input_port(targets[0].port)

    def targets(self, source: Source) -> list[Target]:
        """Return the input ports that a source feeds."""
        return [target for target, feeding in self.feeds.items() if feeding == source]

    def select(self, name: str) -> Selection:
        """Return the entries that a name means.

        Args:
            name: `[block.]signal`, `[block.]signal.field` or `[block.]signal.field.entry`; a
                signal of both feet takes `_l` or `_r` behind its name for one of them. A slash
                does for a point, and a unit is passed over, so that every label is a name.

        Raises:
            AnalysisError: if the name means nothing, or more than one signal.
        """
        parts = name.split(" (")[0].replace("/", ".").split(".")
        for n in range(len(parts), 0, -1):
            head, tail = ".".join(parts[:n]), ".".join(parts[n:])
            for stem, foot in ((head, ""), (head[:-2], head[-2:])):
                if stem in self._names and foot in ("", "_l", "_r"):
                    return self._selection(name, stem, foot, tail)
        short = [known for known in self._names if "." not in known or "." in name]
        raise AnalysisError(f"no signal {name!r}{suggestion(name, short)}")

    def _selection(self, name: str, stem: str, foot: str, tail: str) -> Selection:
        sources = self._names[stem]
        if len(sources) > 1:
            which = " or ".join(f"{source.block}.{stem}" for source in sorted(sources))
            raise AnalysisError(f"more than one signal {name!r}, say {which}")
        (source,) = sources
        if not is_vector(self.port(source)):
            raise AnalysisError(f"the signal {name!r} is not a vector")
        names = self.entry_names(source)
        chosen = [i for i, entry in enumerate(names) if _means(entry, tail) and _of(entry, foot)]
        if not chosen:
            raise AnalysisError(f"{name!r}: {stem} has no such entry{suggestion(tail, names)}")
        head = stem.replace(".", "/")
        labels = (f"{head}/{names[i]}".replace(".", "/").rstrip("/") for i in chosen)
        units = entry_units(*self._described(source), len(names))
        return Selection(source, np.array(chosen), tuple(labels), tuple(units[i] for i in chosen))

    def _connections(self) -> Iterator[tuple[Source, list[Target]]]:
        for i in range(self.system.num_input_ports()):
            yield Source("", i, is_input=True), self._inputs_behind(self.system, i)
        for diagram in _diagrams(self.system):
            for (reader, i), (writer, o) in diagram.connection_map().items():
                yield self._output_behind(writer, o), self._inputs_behind(reader, i)

    def _output_behind(self, system: System, index: int) -> Source:
        while isinstance(system, Diagram):
            system, index = system.get_output_port_locator(OutputPortIndex(int(index)))
        return Source(self._paths[system.GetSystemPathname()], int(index))

    def _inputs_behind(self, system: System, index: int) -> list[Target]:
        if not isinstance(system, Diagram):
            return [Target(self._paths[system.GetSystemPathname()], int(index))]
        locators = system.GetInputPortLocators(InputPortIndex(int(index)))
        return [target for inner, i in locators for target in self._inputs_behind(inner, i)]

    def _collect_names(self) -> dict[str, set[Source]]:
        names: dict[str, set[Source]] = {}

        def add(source: Source, port: str, *owners: str):
            for name in {port, *(f"{owner}.{port}" for owner in owners if owner)}:
                names.setdefault(name, set()).add(source)

        for path, block in self.blocks.items():
            for o in range(block.num_output_ports()):
                port = block.get_output_port(o).get_name()
                add(Source(path, o), port, path, path.split(".")[-1])
            if block.num_output_ports() == 1:
                add(Source(path, 0), path.split(".")[-1])
        for diagram in _diagrams(self.system):
            for o in range(diagram.num_output_ports()):
                source = self._output_behind(diagram, o)
                add(source, diagram.get_output_port(o).get_name(), diagram.get_name())
        for source in set(self.feeds.values()):
            if source.is_input:
                port = self.port(source).get_name()
                add(source, port, source.block, source.block.split(".")[-1])
        # A port of the whole goes before those inside that are called the same.
        own = self._own_ports()
        names |= {port: {source for name, source in own if name == port} for port, _ in own}
        return names

    def _own_ports(self) -> list[tuple[str, Source]]:
        """Return the names of the whole system's ports, and their sources."""
        system = self.system
        if not isinstance(system, Diagram):
            return []
        inputs = range(system.num_input_ports())
        outputs = range(system.num_output_ports())
        return [
            *((system.get_input_port(i).get_name(), Source("", i, is_input=True)) for i in inputs),
            *(
                (system.get_output_port(o).get_name(), self._output_behind(system, o))
                for o in outputs
            ),
        ]


def _leaves(system: System, path: str) -> Iterator[tuple[str, System]]:
    if not isinstance(system, Diagram):
        yield path or system.get_name() or type(system).__name__, system
        return
    for inner in system.GetSystems():
        yield from _leaves(inner, f"{path}.{inner.get_name()}".lstrip("."))


def _diagrams(system: System) -> Iterator[Diagram]:
    if isinstance(system, Diagram):
        yield system
        for inner in system.GetSystems():
            yield from _diagrams(inner)


def _means(entry: str, tail: str) -> bool:
    return not tail or entry == tail or entry.startswith(tail + ".")


def _of(entry: str, foot: str) -> bool:
    parts = entry.split(".")
    return not foot or any(part == foot[1:] or part.endswith(foot) for part in parts)
