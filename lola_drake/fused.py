"""All laws of sensors and controller in one Drake system: what `simulate` runs.

The blocks are the same that the diagram shows one by one. Here one call per tick runs their laws
over one vector of numbers, which `lola_drake.fused_layout` lays out. Runs of laws that numba
compiles become one function of machine code; between them the rest is called as plain Python:
blocks that are no pure law, such as the walking pattern, and laws that numba does not know.
"""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem

from lola_drake.block_system import check_size, plain_value, sample_arguments, tick_of
from lola_drake.compiled import NotCompilable, compiled, compiled_text, compiling, is_kept
from lola_drake.fused_layout import Blocks, Call, Layout, Place
from lola_drake.signals import PERIOD
from lola_drake.theory.noise import Noises

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

COMPILING = "lola: compiling the controller's laws, once; this takes 10 to 25 s"


@cache
def _say_compiling() -> None:
    """Say it once: what is compiled may be tried in several parts."""
    print(COMPILING, file=sys.stderr, flush=True)


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
    found: list[Callable] = []
    for compile_them, group in groupby(layout.calls, fit):
        calls = list(group)
        found += [_in_machine_code(layout, calls)] if compile_them else map(_in_python, calls)
    return found


def _compiles(layout: Layout, call: Call) -> bool:
    if call.name == "next_state":
        return False
    try:
        compiled(call.function, sample_arguments(layout.blocks[call.block], call.name))
        _in_machine_code(
            layout, [call]
        )  # What it returns may be nothing that fits into the vector.
    except NotCompilable:
        return False
    return True


def _in_python(call: Call) -> Callable[[np.ndarray], None]:
    as_lists = call.name != "next_state"

    def reader(place: Place) -> Callable[[np.ndarray], object]:
        where = place.where
        if place.value is not None:
            value = plain_value(place.value)
            return lambda v: value
        if isinstance(where, int):
            return lambda v: v.item(where)
        return (lambda v: v[where].tolist()) if as_lists else (lambda v: v[where])

    read = [reader(place) for place in call.arguments]
    sizes = [where.stop - where.start for where in call.results]
    size, ends = sum(sizes), np.cumsum([0, *sizes]).tolist()
    parts = [(where, slice(*ends[i : i + 2])) for i, where in enumerate(call.results)]

    def run(v: np.ndarray) -> None:
        result = call.function(*[r(v) for r in read])
        check_size(call.name, result, size)
        for where, part in parts:
            v[where] = result[part]

    return run


def _alone(layout: Layout, call: Call, v: np.ndarray) -> Callable[[], object]:
    """Return what calls a law once, in machine code if it can be."""
    function = call.function
    if compiling() and _compiles(layout, call):
        function = compiled(function, sample_arguments(layout.blocks[call.block], call.name))
    values = [
        place.value
        if place.value is not None
        else v.item(place.where)
        if isinstance(place.where, int)
        else v[place.where]
        for place in call.arguments
    ]
    return lambda: function(*values)


def _in_machine_code(layout: Layout, calls: list[Call]) -> Callable[[np.ndarray], None]:
    """Return one compiled function of the vector that makes all these calls.

    Positions are data, not code: a run with another delay uses the same machine code.
    """
    at: list[int] = []
    names: dict[Any, str] = {}
    lines = []

    def named(what: object) -> str:
        return names.setdefault(what, f"{getattr(what, '__name__', 'tuple')}_{len(names)}")

    def position(value: int) -> str:
        at.append(value)
        return f"at[{len(at) - 1}]"

    def text(place: Place) -> str:
        if place.parts:
            if place not in names:
                parts = ", ".join(map(text, place.parts))
                lines.append(f"    {named(place)} = {named(type(place.value))}({parts})")
            return names[place]
        if place.where is None:
            return repr(place.value)
        if isinstance(place.where, int):
            return f"{place.vector}[{position(place.where)}]"
        row = f"{place.vector}[{position(place.where.start)} : {position(place.where.stop)}]"
        shape = ", ".join(position(n) for n in place.shape)
        return f"{row}.reshape(({shape}))" if len(place.shape) > 1 else row

    for call in calls:
        given = f"result_{len(lines)}"
        arguments = ", ".join(map(text, call.arguments))
        (result,) = call.results
        first, last = position(result.start), position(result.stop)
        lines.append(
            f"    {given} = {named(call.function)}({arguments})\n"
            f"    if len({given}) != {last} - {first}:\n"
            f"        raise ValueError('{call.name} gives too many or too few numbers')\n"
            f"    for i in range(len({given})):\n"
            f"        v[{first} + i] = {given}[i]"
        )
    program = "\n".join(["def tick(v, n, at):", *lines, ""])
    called = {name: what for what, name in names.items() if callable(what)}
    integers, positions = layout.integers, np.array(at)
    try:
        function = compiled_text("tick", program, called)
        if not is_kept(function):
            _say_compiling()
        _compile(function)
    except Exception as error:
        raise NotCompilable(str(error)) from error
    return lambda v: function(v, integers, positions)


def _compile(function: "Dispatcher") -> None:
    from numba import float64, int64

    function.compile((float64[::1], int64[::1], int64[::1]))


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
        self._noises = Noises(blocks[name].constant(what) for name, what in layout.noise)
        self.gains = self.DeclareNumericParameter(BasicVector(layout.start[layout.turned]))
        state = self.DeclareDiscreteState(layout.start[layout.states])
        self.DeclareStateOutputPort("state", state)
        self._tick = self.DeclareVectorOutputPort("tick", layout.tick.stop, self._calculate)
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
        v[layout.noises] = self._noises(tick_of(context))
        for program in self._programs:
            program(v)
        output.SetFromVector(v[layout.tick])

    def laws_alone(self, root: Context) -> Iterator[tuple[str, Callable[[], object]]]:
        """Yield each law's block, and what calls it with what it reads in this tick."""
        self._tick.Eval(self.GetMyContextFromRoot(root))
        vector = self._vector.copy()
        for call in self.layout.calls:
            yield call.block, _alone(self.layout, call, vector)

    def _update(self, context, state) -> None:
        state.set_value(self._tick.Eval(context)[self.layout.following])
