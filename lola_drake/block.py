"""A block is a law: what it reads, what it remembers, what it gives, and how, declared once.

A block's laws are pure functions. What a law's argument is called says what it is:

| argument                          | what the law gets                                        |
|-----------------------------------|----------------------------------------------------------|
| a signal, such as `gait_phase`    | that input port; a block of one foot gets its own foot's |
| one of `parts`                    | some entries of an input port                            |
| one of `objects`                  | a vector read from an input port that is none            |
| another law of the block          | that output                                              |
| one of `state`                    | that part of the block's own state                       |
| a gain                            | a parameter that may be turned while it runs             |
| `foot`, `time`                    | 0 for left and 1 for right; simulated time (s)           |
| anything else                     | a parameter of the block, or one of its constants        |

A law named like a signal is an output, one named `next_` and a state gives that state in the next
tick, one that is named otherwise is an output of its own. From this declaration come the Drake
system (`lola_drake.block_system`), the fused controller (`lola_drake.fused`), the drawings, and the
names in linear models.
"""

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from lola_drake.errors import LolaError, shown
from lola_drake.signals import FEET, SIGNALS, Signal, of_foot, split_foot
from lola_drake.theory.noise import Noise


class BlockError(LolaError):
    """A block whose declaration does not fit; the message is one line that says where."""


class law(staticmethod):  # noqa: N801
    """Marks a pure function in the body of a `Block` as one of its laws."""


class Part(NamedTuple):
    """Some entries of a signal: a field, or several in a row; of the block's own foot, if any.

    Attributes:
        signal: the signal.
        fields: names of the first field and the last one, or of one field.
    """

    signal: Signal
    fields: str | tuple[str, str]

    def where(self, foot: str) -> slice | int:
        """Return the entries; a position instead of a slice where it is a single number."""
        first, last = (self.fields,) * 2 if isinstance(self.fields, str) else self.fields
        run = slice(self._field(first, foot).start, self._field(last, foot).stop)
        return run.start if run.stop - run.start == 1 else run

    def _field(self, name: str, foot: str) -> slice:
        fields = {field.name: field for field in self.signal.fields}
        if of_foot(name, foot) in fields:
            return self.signal.slice(of_foot(name, foot))
        where = self.signal.slice(name)
        if foot and fields[name].entries == FEET:
            where = slice(where.start + FEET.index(foot), where.start + FEET.index(foot) + 1)
        return where


class State(NamedTuple):
    """A part of a block's state.

    Attributes:
        signal: what one sample of it is; it may hold several, the newest first.
        hidden: whether it is not an output.
        start: the value of all its entries at the start, unless its block says otherwise.
    """

    signal: Signal
    hidden: bool = False
    start: float = 0.0

    @property
    def resting(self) -> np.ndarray:
        """Return one sample as it is at the start."""
        return np.full(self.signal.size, self.start)


class Reading(NamedTuple):
    """A vector that is read from a port which carries an object of Drake's.

    Attributes:
        port: the input port.
        model: makes a value such as the port carries.
        size: of the vector.
    """

    port: str
    model: Callable
    size: int


class Argument(NamedTuple):
    """Where an argument of a law comes from.

    Attributes:
        kind: "input", "object", "output", "state", "gain", "constant", "noise" or "time".
        name: of the port, state, gain or constant.
        where: entries of the port, or a position; None for all.
    """

    kind: str
    name: str
    where: slice | int | None = None


class Block:
    """Base class of all blocks; a subclass declares its laws and what stands here.

    Attributes:
        Params: the class of its parameters, a dataclass made of `parameter`.
        kind: what it is in drawings: command, sensor, planning, control or actuation.
        state: the parts of its state.
        parts: arguments that are some entries of an input.
        objects: arguments that are read from objects of Drake's, each by a method `read_NAME`.
        signals: signals of its own and its base's, which `lola_drake.signals` does not know.
        held: whether it stays as it is in linear models: it does not depend on the robot.
        switching: whether its state only switches; it does not move by a little.
        differentiable: whether its laws work on AutoDiffXd.
        acts_outside: parameters on which more than the block depends.
    """

    Params: ClassVar[type | None] = None
    kind: ClassVar[str] = "control"
    state: ClassVar[tuple[Signal | State, ...]] = ()
    parts: ClassVar[Mapping[str, Part]] = {}
    objects: ClassVar[Mapping[str, Reading]] = {}
    signals: ClassVar[tuple[Signal, ...]] = ()
    held: ClassVar[bool] = False
    switching: ClassVar[bool] = False
    differentiable: ClassVar[bool] = True
    acts_outside: ClassVar[tuple[str, ...]] = ()

    laws: ClassVar[dict[str, Callable]] = {}
    states: ClassVar[dict[str, State]] = {}

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        cls.states = {s.signal.name: s for s in (_as_state(s) for s in cls.state)}
        cls.signals = tuple(dict.fromkeys([*super(cls, cls).signals, *cls.signals]))
        own = {n: f.__func__ for n, f in vars(cls).items() if isinstance(f, law)}
        cls.laws = {n: f for n, f in (cls.laws | own).items()}
        cls.__doc__ = f"{inspect.cleandoc(cls.__doc__ or '')}\n\n{_card(cls)}"

    def __init__(
        self,
        params: Any = None,
        foot: str = "",
        *,
        initial: Mapping[str, np.ndarray] | None = None,
        **constants: object,
    ):
        """Create a block.

        Args:
            params: its parameters, a dataclass made of `parameter`; those with a slider are gains.
            foot: "l" or "r" for a block of one foot.
            initial: state at the start, by the names of its parts.
            constants: what else its laws need, by the names of their arguments.

        Raises:
            BlockError: if there is no such foot or state, a law's argument is nothing known, a law
                gives nothing known, a state has no law, or outputs wait for one another.
        """
        self.params: Any = params
        self.foot, self.constants = self._checked_foot(foot), constants
        self.gains = {f.name: f for f in _fields(params) if f.metadata.get("slider")}
        self.initial = self._checked_initial({} if initial is None else initial)
        # All arguments are looked at now, so that what is missing is said at once.
        self.arguments = {
            name: tuple(self._argument(name, argument) for argument in _names(function))
            for name, function in self.laws.items()
        }
        if hasattr(self, "next_state"):
            self.arguments["next_state"] = tuple(
                self._argument("next_state", name) for name in _names(self.next_state)
            )
        self._check_laws()
        self._check_order()

    def __repr__(self):
        foot = f" of foot {self.foot}" if self.foot else ""
        return f"<{type(self).__name__}{foot}: {', '.join(self.outputs)}>"

    @classmethod
    def in_place_of(cls, block: "Block") -> "Block":
        """Return a block of this class that takes another one's place, with what that one knows.

        It has the other's foot and constants, its parameters if they are of the class `Params`, or
        else those of `Params` as they are by default, and its initial state where they share one.
        """
        params = block.params
        if cls.Params is not None and not isinstance(params, cls.Params):
            params = cls.Params()
        new = cls.__new__(cls)
        new.__dict__.update({k: v for k, v in vars(block).items() if k.startswith("_")})
        initial = {
            name: value
            for name, value in block.initial.items()
            if name in cls.states and len(value) % cls.states[name].signal.size == 0
        }
        Block.__init__(new, params, block.foot, initial=initial, **block.constants)
        return new

    @property
    def steps_in_python(self) -> bool:
        """Return whether a method `next_state` gives the next state: it is no pure law.

        It returns one array, with all parts of the state end to end.
        """
        return hasattr(self, "next_state")

    @property
    def outputs(self) -> dict[str, Signal]:
        """Return the signal of each output, in the order of the ports."""
        names = [name for name in self.laws if not name.startswith("next_")]
        visible = {n: state.signal for n, state in self.states.items() if not state.hidden}
        return {name: self.signal(name) for name in names} | visible

    @property
    def inputs(self) -> dict[str, Signal | Reading]:
        """Return the signal of each input port, or how it is read, in the order of first use."""
        found: dict[str, Signal | Reading] = {}
        for arguments in self.arguments.values():
            for kind, name, _ in arguments:
                if kind == "input":
                    found.setdefault(name, self.signal(name))
                elif kind == "object":
                    reading = self.objects[name]
                    found.setdefault(reading.port, reading)
        return found

    def signal(self, name: str) -> Signal:
        """Return the signal that flows at a port; BlockError if there is none."""
        known = SIGNALS | {signal.name: signal for signal in self.signals}
        signal = known.get(name) or known.get(split_foot(name)[0])
        if signal is None:
            raise BlockError(f"{type(self).__name__}: no signal is called {name!r}")
        return signal

    def needed_outputs(self, name: str) -> set[str]:
        """Return the block's own outputs that one of its laws reads."""
        return {n for kind, n, _ in self.arguments[name] if kind == "output"}

    def constant(self, name: str) -> Any:
        """Return a parameter of the block, or one of its constants."""
        if name == "foot":
            return FEET.index(self.foot) if self.foot else 0
        return getattr(self.params, name) if hasattr(self.params, name) else self.constants[name]

    def _checked_foot(self, foot: str) -> str:
        if foot not in ("", *FEET):
            allowed = f"it must be {' or '.join(map(repr, FEET))}, or '' for none"
            raise BlockError(
                f"{type(self).__name__}: foot: {shown(foot)} is not allowed, {allowed}"
            )
        return foot

    def _checked_initial(self, given: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the whole state at the start, of which some parts are given."""
        name, parts = type(self).__name__, ", ".join(self.states) or "none"
        if not isinstance(given, Mapping):
            raise BlockError(f"{name}: initial: {shown(given)} is no mapping of the parts: {parts}")
        for part in given:
            if part not in self.states:
                raise BlockError(f"{name}: initial: no part {shown(part)}, there are: {parts}")
        return {
            part: self._checked_part(part, given.get(part, state.resting), state)
            for part, state in self.states.items()
        }

    def _checked_part(self, part: str, given: np.ndarray, state: State) -> np.ndarray:
        size = state.signal.size
        try:
            value = np.array(given, dtype=float)
        except (TypeError, ValueError):
            value = np.array(np.nan)
        # What nobody sees may be several samples, one behind the other.
        fits = value.ndim == 1 and (value.size % size == 0 if state.hidden else value.size == size)
        if not (fits and np.isfinite(value).all()):
            where = f"{type(self).__name__}: initial[{part!r}]"
            raise BlockError(f"{where}: {shown(given)} is not allowed, it must be {size} numbers")
        return value

    def _argument(self, function: str, name: str) -> Argument:
        if name in self.objects:
            return Argument("object", name)
        if name in self.states:
            return Argument("state", name)
        if name in self.laws and not name.startswith("next_"):
            return Argument("output", name)
        if name in self.parts:
            part = self.parts[name]
            try:
                return Argument("input", part.signal.name, part.where(self.foot))
            except KeyError as error:
                raise BlockError(f"{type(self).__name__}.{name}: {error.args[0]}") from None
        if name in self.gains:
            return Argument("gain", name)
        if name == "time":
            return Argument("time", name)
        if name == "foot" or name in self.constants or hasattr(self.params, name):
            return Argument(
                "noise" if isinstance(self.constants.get(name), Noise) else "constant", name
            )
        try:
            self.signal(name)
        except BlockError:
            raise BlockError(
                f"{type(self).__name__}.{function}: its argument {name!r} is no signal, state, "
                "gain or constant of the block"
            ) from None
        return Argument("input", name)

    def _check_laws(self) -> None:
        steps = {name for name in self.laws if name.startswith("next_")}
        expected = set() if self.steps_in_python else {f"next_{name}" for name in self.states}
        for name in sorted(steps ^ expected):
            what = "no law gives it" if name in expected else "it has no such state"
            raise BlockError(f"{type(self).__name__}.{name}: {what}")
        for name in self.laws.keys() - steps:
            self.signal(name)

    def _check_order(self) -> None:
        waiting = {name for name in self.laws if not name.startswith("next_")}
        while ready := {n for n in waiting if not self.needed_outputs(n) & waiting}:
            waiting -= ready
        if waiting:
            names = ", ".join(n for n in self.laws if n in waiting)
            raise BlockError(f"{type(self).__name__}: these outputs wait for one another: {names}")


def _as_state(state: Signal | State) -> State:
    return state if isinstance(state, State) else State(state)


def _names(function: Callable) -> tuple[str, ...]:
    return tuple(inspect.signature(function).parameters)


def _fields(params: object) -> tuple[dataclasses.Field, ...]:
    return dataclasses.fields(params) if dataclasses.is_dataclass(params) else ()


def _card(cls: type[Block]) -> str:
    """Return Drake's port card of a class of blocks."""
    functions = [*cls.laws.values(), *([cls.next_state] if hasattr(cls, "next_state") else [])]
    known = SIGNALS | {signal.name: signal for signal in cls.signals}
    inputs = []
    for name in (name for function in functions for name in _names(function)):
        if name in cls.objects:
            inputs.append(cls.objects[name].port)
        elif name in cls.parts:
            inputs.append(cls.parts[name].signal.name)
        elif (
            name not in cls.states
            and name not in cls.laws
            and (name in known or split_foot(name)[0] in known)
        ):
            inputs.append(name)
    outputs = [name for name in cls.laws if not name.startswith("next_")]
    outputs += [name for name, state in cls.states.items() if not state.hidden]
    lines = [".. pydrake_system::", "", f"    name: {cls.__name__}"]
    for title, ports in (("input_ports", inputs), ("output_ports", outputs)):
        if ports:
            lines += [f"    {title}:", *(f"    - {port}" for port in dict.fromkeys(ports))]
    return "\n".join(lines)
