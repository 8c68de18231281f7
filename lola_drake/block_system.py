"""The Drake system of a block: ports, tickets, state, gains and updates out of its declaration."""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import (
    BasicVector_,
    Context,
    LeafSystem,
    LeafSystem_,
    NumericParameterIndex,
    OutputPort,
    SystemScalarConverter,
)
from pydrake.systems.scalar_conversion import TemplateSystem

from lola_drake.block import Argument, Block, Reading
from lola_drake.compiled import NotCompilable, compiled, compiling
from lola_drake.signals import PERIOD

_DIFFERENTIATED = {"object", "noise"}
"""Arguments that no AutoDiffXd passes through."""


def tick_of(context) -> int:
    """Return the number of the tick that a context is in."""
    return round(context.get_time() / PERIOD)


@TemplateSystem.define("BlockSystem_", T_list=[float, AutoDiffXd])
def BlockSystem_(T):  # noqa: N802
    """Return the Drake system of blocks over a scalar."""

    class Impl(LeafSystem_[T]):
        """The Drake system of a block; its gains are numeric parameters of one entry each."""

        def _construct(self, block: Block, converter=None):
            convertible = block.differentiable and not block.steps_in_python
            convertible &= not any(
                kind in _DIFFERENTIATED for args in block.arguments.values() for kind, *_ in args
            )
            LeafSystem_[T].__init__(self, converter if convertible else SystemScalarConverter())
            self.block = block
            self.gain_index = {
                name: self.DeclareNumericParameter(BasicVector_[T]([getattr(block.params, name)]))
                for name in block.gains
            }
            self._inputs = {name: self._input(name, what) for name, what in block.inputs.items()}
            self._states = {n: self.DeclareDiscreteState(x) for n, x in block.initial.items()}
            self._laws: dict[str, OutputPort] = {}
            for name in block.outputs:
                self._declare_output(name)
            if self._states:
                self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update())

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, other.block, converter=converter)

        def _input(self, name: str, what):
            if isinstance(what, Reading):
                return self.DeclareAbstractInputPort(name, what.model())
            return self.DeclareVectorInputPort(name, what.size)

        def _declare_output(self, name: str) -> None:
            block = self.block
            if name in self._states:
                self.DeclareStateOutputPort(name, self._states[name])
                return
            function, read = self._law(name)
            size = block.signal(name).size

            def calculate(context, output):
                values = function(*[r(context) for r in read])
                check_size(name, values, size)
                output.SetFromVector(values)

            port = self.DeclareVectorOutputPort(
                name,
                size,
                calculate,
                prerequisites_of_calc=self._tickets(name) or {self.nothing_ticket()},
            )
            self._laws[name] = port

        def _update(self) -> Callable:
            return self._python_update() if self.block.steps_in_python else self._law_update()

        def _python_update(self) -> Callable:
            block, states = self.block, self._states
            read = self._readers_of("next_state", as_arrays=True)
            ends = np.cumsum([len(part) for part in block.initial.values()])

            def update(context, state):
                following = block.next_state(*[r(context) for r in read])
                check_size("next_state", following, ends[-1])
                parts = np.split(following, ends[:-1])
                for index, values in zip(states.values(), parts, strict=True):
                    state.set_value(index, values)

            return update

        def _law_update(self) -> Callable:
            block, states = self.block, self._states
            steps = [(name, index, *self._law(f"next_{name}")) for name, index in states.items()]

            def update(context, state):
                for name, index, function, read in steps:
                    values = function(*[r(context) for r in read])
                    check_size(f"next_{name}", values, len(block.initial[name]))
                    state.set_value(index, np.asarray(values))

            return update

        def _law(self, name: str) -> tuple[Callable, list[Callable]]:
            """Return a law, compiled if it can be, and what reads its arguments."""
            function = self.block.laws[name]
            if T is float and compiling():
                try:
                    function = compiled(function, sample_arguments(self.block, name))
                    return function, self._readers_of(name, as_arrays=True)
                except NotCompilable:
                    pass
            return function, self._readers_of(name, as_arrays=False)

        def _readers_of(self, name: str, *, as_arrays: bool) -> list[Callable]:
            return [self._reader(argument, as_arrays) for argument in self.block.arguments[name]]

        def _tickets(self, law: str) -> set:
            return set().union(*map(self._ticket, self.block.arguments[law]))

        def _ticket(self, argument: Argument) -> set:
            kind, name, _ = argument
            if kind in ("input", "object"):
                port = self._inputs[self.block.objects[name].port if kind == "object" else name]
                return {port.ticket()}
            if kind == "output":
                return self._tickets(name)
            if kind == "state":
                return {self.discrete_state_ticket(self._states[name])}
            if kind == "gain":
                index = NumericParameterIndex(self.gain_index[name])
                return {self.numeric_parameter_ticket(index)}
            return set() if kind == "constant" else {self.time_ticket()}

        def _reader(self, argument: Argument, as_array: bool) -> Callable:
            kind, name, where = argument
            form = (lambda v: v) if as_array else (lambda v: v.tolist())
            if kind == "output":
                ports = self._laws
                return lambda context: form(ports[name].Eval(context))
            if kind == "input":
                port = self._inputs[name]
                if where is None:
                    return lambda context: form(port.Eval(context))
                if isinstance(where, int):
                    return lambda context: port.Eval(context).item(where)
                return lambda context: form(port.Eval(context)[where])
            if kind == "state":
                index = self._states[name]
                return lambda context: form(context.get_discrete_state(index).CopyToVector())
            if kind == "gain":
                index = self.gain_index[name]
                return lambda context: context.get_numeric_parameter(index).GetAtIndex(0)
            if kind == "object":
                port = self._inputs[self.block.objects[name].port]
                read = getattr(self.block, f"read_{name}")
                return lambda context: form(np.asarray(read(port.Eval(context)), dtype=float))
            if kind == "noise":
                sample = self.block.constant(name)
                return lambda context: form(sample(tick_of(context)))
            if kind == "time":
                return lambda context: context.get_time()
            value = self.block.constant(name)
            value = machine_value(value) if as_array else plain_value(value)
            return lambda context: value

    return Impl


if TYPE_CHECKING:

    class BlockSystem(LeafSystem):
        """What mypy has to know about the system that comes out of the template."""

        block: Block
        gain_index: dict[str, int]

        def __init__(self, block: Block): ...

else:
    BlockSystem = BlockSystem_[float]


def system_of(block: Block) -> BlockSystem:
    """Return the Drake system of a block; in Drake's own drawings it is called as the block is."""
    return _named(type(block).__name__)(block)


@cache
def _named(name: str) -> type[BlockSystem]:
    return type(name, (BlockSystem,), {"__module__": __name__})


def check_size(law: str, values: object, size: int) -> None:
    """Check that a law gives as many numbers, in a row, as its signal has."""
    found = len(values) if hasattr(values, "__len__") else "no row of"
    if found != size:
        raise ValueError(f"{law} gives {found} numbers, it must give {size}")


def machine_value(value: Any) -> Any:
    """Return a constant as machine code takes it: a number, an array, or a named tuple of these."""
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*map(machine_value, value))
    if isinstance(value, (bool, int, np.integer)):
        return int(value)
    if isinstance(value, (float, str)):
        return value
    array = np.ascontiguousarray(value)
    return array.astype(int if array.dtype.kind == "i" else float)


def plain_value(value: Any) -> Any:
    """Return a constant as plain Python takes it: the same with nested lists for arrays."""
    value = machine_value(value)
    if isinstance(value, tuple):
        return type(value)(*map(plain_value, value))
    return value.tolist() if isinstance(value, np.ndarray) else value


def sample_arguments(block: Block, name: str) -> tuple:
    """Return values of the kinds that a law of a block gets in machine code."""
    return tuple(_sample(block, argument) for argument in block.arguments[name])


def _sample(block: Block, argument: Argument) -> object:
    kind, name, where = argument
    if kind in ("gain", "time") or isinstance(where, int):
        return 1.0
    if kind == "constant":
        return machine_value(block.constant(name))
    return np.zeros(1)


def gain_of(system: BlockSystem, root: Context, name: str) -> float:
    """Return a gain of a block as it is in the context of its diagram."""
    context = system.GetMyContextFromRoot(root)
    return float(context.get_numeric_parameter(system.gain_index[name]).GetAtIndex(0))


def set_gain(system: BlockSystem, root: Context, name: str, value: float) -> None:
    """Turn a gain of a block in the context of its diagram; it acts at once."""
    context = system.GetMyMutableContextFromRoot(root)
    context.get_mutable_numeric_parameter(system.gain_index[name]).SetAtIndex(0, value)
