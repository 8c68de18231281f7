"""The data of a block diagram: blocks, ports, nets, and what they mean."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lola_drake.signals import Signal


@dataclass(frozen=True)
class Port:
    """One port of a block.

    Attributes:
        name: Unique among the block's inputs or outputs.
        size: Number of entries; None if it carries an object.
        held: Of an output: whether it hangs on the block's state alone, so that it shows an
            input one period later.
        connected: Whether a net of the picture ends here.
        signal: What flows here, if it is known.
    """

    name: str
    size: int | None
    held: bool = False
    connected: bool = True
    signal: Signal | None = None


End = tuple[str, str]
"""The name of a block ("" for the diagram itself) and of one of its ports."""


@dataclass(frozen=True)
class Net:
    """A signal's way from where it is made to all who read it."""

    source: End
    sinks: tuple[End, ...]


@dataclass(frozen=True)
class Block:
    """One system.

    Attributes:
        name: Unique inside its diagram.
        type: Name of its class.
        kind: Command, sensor, planning, control, actuation, plant or logging.
        doc: One line.
        equations: Numbers of the paper's equations that its source file speaks of.
        module: Where its class is defined.
        source: The source file; None if it is not Python.
        period: Of its discrete update (s), None without.
        states: Size of each group of its discrete state.
        inputs, outputs: The ports to be shown.
        through: Which input which output follows at once (direct feed-through).
        children, nets: What is inside of a diagram.
    """

    name: str
    type: str
    kind: str
    doc: str
    equations: tuple[int, ...]
    module: str
    source: Path | None
    period: float | None
    states: tuple[int, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    through: tuple[tuple[str, str], ...] = ()
    children: tuple["Block", ...] = ()
    nets: tuple[Net, ...] = ()

    def child(self, name: str) -> "Block":
        """Return the block of that name inside."""
        return next(child for child in self.children if child.name == name)

    def walk(self) -> Iterator["Block"]:
        """Return this block and all that are inside."""
        yield self
        for child in self.children:
            yield from child.walk()
