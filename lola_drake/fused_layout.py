"""Where everything of the fused system is: one vector of numbers, and one of integers.

    [ state of all blocks | outputs | inputs | next state | gains, constants, readings, noise ]

Constants that are arrays lie in it end to end, and those that are named tuples field by field, so
that machine code takes two arrays and no objects. The laws are put in an order in which each finds
what it reads.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.block import Argument, Block, BlockError, Reading
from lola_drake.block_system import machine_value
from lola_drake.signals import of_foot

Blocks = Mapping[str, Block]
"""Blocks by their names in the diagram; one of one foot ends in _l or _r."""


@dataclass(frozen=True)
class Call:
    """One law in its place.

    Attributes:
        block: the name of its block.
        name: of the law, or `next_state` for a block that steps in Python.
        function: the law.
        arguments: where each argument is.
        results: where what it returns goes, end to end.
    """

    block: str
    name: str
    function: Callable
    arguments: tuple["Place", ...]
    results: tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class Place:
    """Where an argument of a call is: a number, some numbers in a row, or a named tuple of these.

    Attributes:
        where: a position or a slice of a vector; None for a named tuple or a text.
        vector: "v", or "n" for that of integers.
        shape: of an array.
        parts: of a named tuple.
        value: of a constant, as machine code takes it.
    """

    where: int | slice | None = None
    vector: str = "v"
    shape: tuple[int, ...] = ()
    parts: tuple["Place", ...] = ()
    value: object = None


class Layout:
    """Where everything is in the vector, and in which order the laws run.

    Attributes:
        blocks: the blocks.
        inputs: names and sizes of the vectors that come from outside.
        readings: names, blocks and readings of the vectors that are read from objects.
        state: where the state of each block's parts is, by block and part.
        signals: where each signal is that a block gives, or that comes from outside, by its name.
        gains: where each gain is, by block and gain.
        calls: all laws, in order.
        start: the vector as it is at the beginning.
        integers: the vector of integers.
        states, following: where the whole state is, and the next one.
        tick: where all of that is that a tick has to say: from the state to the next one.
    """

    def __init__(self, blocks: Blocks):
        """Lay out blocks that read each other's outputs by name."""
        self.blocks = dict(blocks)
        self._values = {"v": [np.zeros(0)], "n": [np.zeros(0, dtype=int)]}
        self._sizes = {"v": 0, "n": 0}
        self.signals: dict[str, slice] = {}
        self.state: dict[tuple[str, str], slice] = {}
        self.gains: dict[tuple[str, str], int] = {}
        self.inputs: dict[str, slice] = {}
        self.readings: dict[tuple[str, str], slice] = {}
        self.noise: dict[tuple[str, str], slice] = {}
        self._known: dict[tuple, Place] = {}
        self._constants: dict[tuple[str, str], Place] = {}
        self._lay_states()
        self._lay_outputs()
        self._lay_inputs()
        self.following = self._take(np.zeros(self.states.stop))
        self.tick = slice(0, self.following.stop)
        self._lay_rest()
        self.start, self.integers = (np.concatenate(self._values[vector]) for vector in "vn")
        self.calls = [*self._output_calls(), *self._update_calls()]

    def _take(self, value: Sequence[float] | np.ndarray, vector: str = "v") -> slice:
        where = slice(self._sizes[vector], self._sizes[vector] + len(value))
        self._values[vector].append(np.asarray(value))
        self._sizes[vector] = where.stop
        return where

    def _lay_states(self) -> None:
        for hidden in (True, False):
            first_of_kind = self._sizes["v"]
            for name, block in self.blocks.items():
                for part, state in block.states.items():
                    if state.hidden == hidden:
                        where = self.state[name, part] = self._take(block.initial[part])
                        if not hidden:
                            self.signals[of_foot(part, block.foot)] = where
        self.states = slice(0, self._sizes["v"])
        self.visible = slice(first_of_kind, self._sizes["v"])

    def _lay_outputs(self) -> None:
        for block in self.blocks.values():
            for name, signal in block.outputs.items():
                if name in block.laws:
                    self.signals[of_foot(name, block.foot)] = self._take(np.zeros(signal.size))

    def _lay_inputs(self) -> None:
        for block in self.blocks.values():
            for port, what in block.inputs.items():
                if isinstance(what, Reading):
                    continue
                source = self._source(block, port)
                if source not in self.signals:
                    self.signals[source] = self.inputs[source] = self._take(np.zeros(what.size))
        self.row = slice(0, self._sizes["v"])
        self.visible = slice(self.visible.start, self._sizes["v"])

    def _lay_rest(self) -> None:
        self.clock = self._take(np.zeros(1)).start
        first_gain = self._sizes["v"]
        for name, block in self.blocks.items():
            for gain in block.gains:
                self.gains[name, gain] = self._take([getattr(block.params, gain)]).start
        self.turned = slice(first_gain, self._sizes["v"])
        first_noise = self._sizes["v"]
        for name, block, what in self._arguments("noise"):
            self.noise[name, what] = self._take(np.zeros(block.constant(what).size))
        self.noises = slice(first_noise, self._sizes["v"])
        for name, block, what in self._arguments("object"):
            self.readings[name, what] = self._take(np.zeros(block.objects[what].size))
        for name, block, what in self._arguments("constant"):
            self._constants[name, what] = self._constant(machine_value(block.constant(what)))

    def _arguments(self, kind: str) -> Iterator[tuple[str, Block, str]]:
        """Yield the arguments of a kind, once for each block: its name, itself, their names."""
        for name, block in self.blocks.items():
            all_of_it = (a for arguments in block.arguments.values() for a in arguments)
            for what in dict.fromkeys(a.name for a in all_of_it if a.kind == kind):
                yield name, block, what

    def _constant(self, value: object) -> Place:
        """Return the place of a constant; equal ones have one."""
        if isinstance(value, tuple):
            parts = tuple(map(self._constant, value))
            return self._known.setdefault((type(value), parts), Place(parts=parts, value=value))
        if isinstance(value, str):
            return Place(value=value)
        array = np.asarray(value)
        vector = "n" if array.dtype.kind == "i" else "v"
        key = vector, array.shape, array.tobytes()
        if key not in self._known:
            taken = self._take(array.ravel(), vector)
            where = taken if array.ndim else taken.start
            self._known[key] = Place(where, vector, array.shape, value=value)
        return self._known[key]

    def _source(self, block: Block, port: str) -> str:
        """Return the signal that an input port of a block gets: its own foot's, or that of both."""
        own = of_foot(port, block.foot)
        return own if own in self.signals else port

    def gain_index(self, block: str, gain: str) -> int:
        """Return the place of a gain in the numeric parameter."""
        return self.gains[block, gain] - self.turned.start

    def place(self, name: str, argument: Argument) -> Place:
        """Return where an argument of a law of the block `name` is."""
        block = self.blocks[name]
        kind, what, where = argument
        if kind == "constant":
            return self._constants[name, what]
        if kind == "gain":
            return Place(self.gains[name, what])
        if kind == "time":
            return Place(self.clock)
        if kind == "state":
            return Place(self.state[name, what])
        if kind in ("object", "noise"):
            return Place((self.readings if kind == "object" else self.noise)[name, what])
        source = of_foot(what, block.foot) if kind == "output" else self._source(block, what)
        at = self.signals[source]
        if where is None:
            return Place(at)
        if isinstance(where, int):
            return Place(at.start + where)
        return Place(slice(at.start + where.start, at.start + where.stop))

    def _call(self, name: str, function: str, results: tuple[slice, ...]) -> Call:
        block = self.blocks[name]
        law = block.laws.get(function) or getattr(block, function)
        places = tuple(self.place(name, argument) for argument in block.arguments[function])
        return Call(name, function, law, places, results)

    def _loop(self, waiting: dict[str, tuple[str, str]]) -> list[str]:
        """Return the waiting signals without those for which no other one waits."""
        read = {signal: self._read_signals(*place) for signal, place in waiting.items()}
        while last := read.keys() - set().union(*read.values()):
            read = {signal: needs for signal, needs in read.items() if signal not in last}
        return list(read)

    def _output_calls(self) -> list[Call]:
        """Return the laws of all outputs such that each comes after those whose output it reads."""
        waiting = {
            of_foot(output, block.foot): (name, output)
            for name, block in self.blocks.items()
            for output in block.outputs
            if output in block.laws
        }
        calls = []
        while waiting:
            ready = [
                signal
                for signal, (name, output) in waiting.items()
                if not self._read_signals(name, output) & waiting.keys()
            ]
            if not ready:
                loop = ", ".join(self._loop(waiting))
                raise BlockError(f"these signals wait for one another: {loop}")
            for signal in ready:
                name, output = waiting.pop(signal)
                calls.append(self._call(name, output, (self.signals[signal],)))
        return calls

    def _read_signals(self, name: str, output: str) -> set[str]:
        block = self.blocks[name]
        own = {of_foot(n, block.foot) for n in block.needed_outputs(output)}
        return own | {
            self._source(block, what)
            for kind, what, _ in block.arguments[output]
            if kind == "input"
        }

    def _update_calls(self) -> list[Call]:
        calls = []
        for name, block in self.blocks.items():
            following = {
                part: slice(self.following.start + at.start, self.following.start + at.stop)
                for (owner, part), at in self.state.items()
                if owner == name
            }
            if block.steps_in_python:
                order = [following[part] for part in block.states]
                calls.append(self._call(name, "next_state", _joined(order)))
            else:
                calls += [
                    self._call(name, f"next_{part}", (following[part],)) for part in block.states
                ]
        # Plain Python last, so that machine code runs in one go.
        return sorted(calls, key=lambda call: call.name == "next_state")


def _joined(slices: list[slice]) -> tuple[slice, ...]:
    """Return the same with each one that begins where the one before it ends joined to that."""
    joined = slices[:1]
    for where in slices[1:]:
        if where.start == joined[-1].stop:
            joined[-1] = slice(joined[-1].start, where.stop)
        else:
            joined.append(where)
    return tuple(joined)
