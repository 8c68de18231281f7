"""All laws of sensors and controller in one Drake system: what `simulate` runs.

The blocks are the same that the diagram shows one by one. Here their laws are put in an order in
which each finds what it reads, and one call per tick runs them all over one vector of numbers:

    [ state of all blocks | outputs | inputs | gains, constants, noise | next state ]

Runs of laws that numba compiles become one function of machine code; between them the rest is
called as plain Python: blocks that are no pure law, such as the walking pattern, and laws that
numba does not know.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem

from lola_drake.block import Argument, Block, BlockError, Reading
from lola_drake.block_system import (
    check_size,
    machine_value,
    plain_value,
    sample_arguments,
    tick_of,
)
from lola_drake.compiled import NotCompilable, compiled, compiled_text, compiling
from lola_drake.signals import PERIOD, of_foot

Blocks = Mapping[str, Block]
"""Blocks by their names in the diagram; one of one foot ends in _l or _r."""


@dataclass(frozen=True)
class Call:
    """One law in its place.

    Attributes:
        block: the name of its block.
        name: of the law, or `next_state` for a block that steps in Python.
        function: the law.
        arguments: where in the vector each argument is, or what it is if it is no number.
        results: where what it returns goes, one slice after another.
    """

    block: str
    name: str
    function: Callable
    arguments: tuple["Place", ...]
    results: tuple[slice, ...]


@dataclass(frozen=True)
class Place:
    """An argument of a call: a number, some numbers in a row, or a constant.

    Attributes:
        where: a position or a slice of the vector; None for a constant that is not in it.
        shape: of an array that is more than a row.
        value: the constant.
    """

    where: int | slice | None
    shape: tuple[int, ...] = ()
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
        states, following: where the whole state is, and the next one.
    """

    def __init__(self, blocks: Blocks):
        """Lay out blocks that read each other's outputs by name."""
        self.blocks = dict(blocks)
        self._values: list[np.ndarray] = []
        self._size = 0
        self.signals: dict[str, slice] = {}
        self.state: dict[tuple[str, str], slice] = {}
        self.gains: dict[tuple[str, str], int] = {}
        self.inputs: dict[str, slice] = {}
        self.readings: dict[tuple[str, str], slice] = {}
        self.noise: dict[tuple[str, str], slice] = {}
        self._constants: dict[tuple[str, str], Place] = {}
        self._lay_states()
        self._lay_outputs()
        self._lay_inputs()
        self._lay_rest()
        self.following = self._take(np.zeros(self.states.stop))
        self.start = np.concatenate(self._values)
        self.calls = [*self._output_calls(), *self._update_calls()]

    def _take(self, value: np.ndarray) -> slice:
        where = slice(self._size, self._size + len(value))
        self._values.append(np.asarray(value, dtype=float))
        self._size = where.stop
        return where

    def _lay_states(self) -> None:
        for hidden in (True, False):
            first_of_kind = self._size
            for name, block in self.blocks.items():
                for part, state in block.states.items():
                    if state.hidden == hidden:
                        where = self.state[name, part] = self._take(block.initial[part])
                        if not hidden:
                            self.signals[of_foot(part, block.foot)] = where
        self.states = slice(0, self._size)
        self.visible = slice(first_of_kind, self._size)

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
        self.row = slice(0, self._size)
        self.visible = slice(self.visible.start, self._size)

    def _lay_rest(self) -> None:
        self.clock = self._take(np.zeros(1)).start
        first_gain = self._size
        for name, block in self.blocks.items():
            for gain in block.gains:
                self.gains[name, gain] = self._take([getattr(block.params, gain)]).start
        self.turned = slice(first_gain, self._size)
        for name, block in self.blocks.items():
            read = dict.fromkeys(a[:2] for arguments in block.arguments.values() for a in arguments)
            for kind, what in read:
                self._lay_constant(name, block, kind, what)

    def _lay_constant(self, name: str, block: Block, kind: str, what: str) -> None:
        if kind == "object":
            self.readings[name, what] = self._take(np.zeros(block.objects[what].size))
        elif kind == "noise":
            self.noise[name, what] = self._take(np.zeros(block.constant(what).size))
        elif kind == "constant":
            value = machine_value(block.constant(what))
            if isinstance(value, float):
                place = Place(self._take([value]).start)
            elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
                place = Place(self._take(value.ravel()), value.shape)
            else:
                place = Place(None, value=value)
            self._constants[name, what] = place

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
                raise BlockError(f"these signals wait for one another: {', '.join(waiting)}")
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
                order = tuple(following[part] for part in block.states)
                calls.append(self._call(name, "next_state", order))
            else:
                calls += [
                    self._call(name, f"next_{part}", (following[part],)) for part in block.states
                ]
        # Plain Python last, so that machine code runs in one go.
        return sorted(calls, key=lambda call: call.name == "next_state")


def programs(layout: Layout, compile_laws: bool) -> list[Callable[[np.ndarray], None]]:
    """Return what runs all laws over a vector, one program after the other."""
    if not compile_laws:
        return [_in_python(call) for call in layout.calls]
    try:
        return _programs(layout, lambda call: call.name != "next_state")
    except NotCompilable:
        refused = {id(call) for call in layout.calls if not _compiles(layout, call)}
        return _programs(layout, lambda call: id(call) not in refused)


def _programs(layout: Layout, fit: Callable[[Call], bool]) -> list[Callable]:
    found = []
    for compile_them, group in groupby(layout.calls, fit):
        calls = list(group)
        found += [_in_machine_code(calls)] if compile_them else map(_in_python, calls)
    return found


def _compiles(layout: Layout, call: Call) -> bool:
    if call.name == "next_state":
        return False
    try:
        compiled(call.function, sample_arguments(layout.blocks[call.block], call.name))
        _in_machine_code([call])  # What it returns may be nothing that fits into the vector.
    except NotCompilable:
        return False
    return True


def _in_python(call: Call) -> Callable[[np.ndarray], None]:
    as_lists = call.name != "next_state"
    constants = [plain_value(p.value) if p.where is None else None for p in call.arguments]

    def run(v: np.ndarray) -> None:
        values = []
        for place, constant in zip(call.arguments, constants, strict=True):
            if place.where is None:
                values.append(constant)
            elif isinstance(place.where, int):
                values.append(v.item(place.where))
            else:
                part = v[place.where].reshape(place.shape or -1)
                values.append(part.tolist() if as_lists else part)
        result = call.function(*values)
        for where, value in zip(call.results, result if not as_lists else [result], strict=True):
            check_size(call.name, value, where.stop - where.start)
            v[where] = value

    return run


def _alone(layout: Layout, call: Call, v: np.ndarray) -> Callable[[], object]:
    """Return what calls a law once, in machine code if it can be."""
    function = call.function
    if compiling() and _compiles(layout, call):
        function = compiled(function, sample_arguments(layout.blocks[call.block], call.name))
    values = [
        place.value
        if place.where is None
        else v.item(place.where)
        if isinstance(place.where, int)
        else v[place.where].reshape(place.shape or -1)
        for place in call.arguments
    ]
    return lambda: function(*values)


def _in_machine_code(calls: list[Call]) -> Callable[[np.ndarray], None]:
    """Return one compiled function of the vector that makes all these calls.

    Positions are data, not code: a run with another delay uses the same machine code.
    """
    at: list[int] = []
    constants: list[object] = []
    laws: dict[str, Callable] = {}
    known: dict[Callable, str] = {}
    lines = []

    def position(value: int) -> str:
        at.append(value)
        return f"at[{len(at) - 1}]"

    def text(place: Place) -> str:
        if place.where is None:
            constants.append(place.value)
            return f"constants[{len(constants) - 1}]"
        if isinstance(place.where, int):
            return f"v[{position(place.where)}]"
        part = f"v[{position(place.where.start)} : {position(place.where.stop)}]"
        shape = ", ".join(position(n) for n in place.shape)
        return f"{part}.reshape(({shape}))" if len(place.shape) > 1 else part

    for call in calls:
        name = known.setdefault(call.function, f"law_{len(known)}")
        laws[name] = call.function
        (result,) = call.results
        first, last = position(result.start), position(result.stop)
        given = f"result_{len(lines)}"
        lines.append(
            f"    {given} = {name}({', '.join(map(text, call.arguments))})\n"
            f"    if len({given}) != {last} - {first}:\n"
            f"        raise ValueError('{call.name} gives too many or too few numbers')\n"
            f"    for i in range(len({given})):\n"
            f"        v[{first} + i] = {given}[i]"
        )
    positions, values = np.array(at), tuple(constants)
    try:
        function = compiled_text(
            "tick", "\n".join(["def tick(v, at, constants):", *lines, ""]), laws
        )
        _compile(function, positions, values)
    except Exception as error:
        raise NotCompilable(str(error)) from error
    return lambda v: function(v, positions, values)


def _compile(function: Callable, positions: np.ndarray, constants: tuple) -> None:
    import numba

    function.compile((numba.types.float64[::1], numba.typeof(positions), numba.typeof(constants)))


class FusedSystem(LeafSystem):
    """Sensors and controller as one system.

    Its state is that of all blocks. The output `tick` has the state, every signal between the
    blocks and every input, as they are in this tick, and then the next state. Its one numeric
    parameter has the gains of all blocks, see `Layout.gain_index`.
    """

    def __init__(self, blocks: Blocks, *, compile_laws: bool | None = None):
        """Fuse blocks; laws are compiled where they can be, unless `compile_laws` is False."""
        super().__init__()
        self.layout = layout = Layout(blocks)
        self._programs = programs(layout, compiling() if compile_laws is None else compile_laws)
        self._vector = layout.start.copy()
        self._inputs = [
            (self.DeclareVectorInputPort(name, at.stop - at.start), at)
            for name, at in layout.inputs.items()
        ]
        self._readings = self._declare_readings()
        self._noise = [
            (blocks[name].constant(what), at) for (name, what), at in layout.noise.items()
        ]
        self.gains = self.DeclareNumericParameter(BasicVector(layout.start[layout.turned]))
        state = self.DeclareDiscreteState(layout.start[layout.states])
        self.DeclareStateOutputPort("state", state)
        size = layout.row.stop + layout.states.stop
        self._tick = self.DeclareVectorOutputPort("tick", size, self._calculate)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _declare_readings(self) -> list[tuple]:
        """Return every port that carries an object, with what reads it and where that goes."""
        readings: dict[str, tuple[InputPort, list]] = {}
        for (name, what), at in self.layout.readings.items():
            block = self.layout.blocks[name]
            port, model, _ = block.objects[what]
            if port not in readings:
                readings[port] = (self.DeclareAbstractInputPort(port, model()), [])
            readings[port][1].append((getattr(block, f"read_{what}"), at))
        return list(readings.values())

    def _calculate(self, context, output) -> None:
        v, layout = self._vector, self.layout
        v[layout.states] = context.get_discrete_state_vector().value()
        v[layout.turned] = context.get_numeric_parameter(self.gains).value()
        v[layout.clock] = context.get_time()
        for port, at in self._inputs:
            v[at] = port.Eval(context)
        for port, reads in self._readings:
            value = port.Eval(context)
            for read, at in reads:
                v[at] = read(value)
        tick = tick_of(context)
        for sample, at in self._noise:
            v[at] = sample(tick)
        for program in self._programs:
            program(v)
        output.SetFromVector(np.concatenate([v[layout.row], v[layout.following]]))

    def laws_alone(self, root: Context) -> Iterator[tuple[str, Callable[[], object]]]:
        """Yield each law's block, and what calls it with what it reads in this tick."""
        self._tick.Eval(self.GetMyContextFromRoot(root))
        vector = self._vector.copy()
        for call in self.layout.calls:
            yield call.block, _alone(self.layout, call, vector)

    def _update(self, context, state) -> None:
        state.set_value(self._tick.Eval(context)[self.layout.row.stop :])
