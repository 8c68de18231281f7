"""A law of one's own in place of a block."""

import hashlib
import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from pydrake.systems.framework import InputPort, LeafSystem, OutputPort, PortDataType

from lola_drake.atomic_file import reason
from lola_drake.block import Block, BlockError, Reading
from lola_drake.scenario import OwnLaw
from lola_drake.signals import Signal, of_foot, signal_of, split_foot
from lola_drake.typed_yaml import suggestion

Replacement = Block | LeafSystem | type[Block] | Callable[[Block], Block | LeafSystem]
"""A block or a system of Drake's; or a class of blocks, or a function of the block it replaces."""


def swapped(
    blocks: Mapping[str, Block], replacements: Mapping[str, Replacement]
) -> dict[str, Block | LeafSystem]:
    """Return blocks with some of them replaced.

    Args:
        blocks: by name.
        replacements: by the names of what they replace; a name without its foot means both feet.

    Raises:
        BlockError: if there is no such block, or the replacement's ports do not fit.
    """
    result: dict[str, Block | LeafSystem] = dict(blocks)
    for name, replacement in replacements.items():
        targets = [known for known in blocks if name in (known, split_foot(known)[0])]
        if not targets:
            raise BlockError(f"no block is called {name!r}{suggestion(name, blocks)}")
        if len(targets) > 1 and isinstance(replacement, (Block, LeafSystem)):
            raise BlockError(f"{name}: give a class, or one block each for {' and '.join(targets)}")
        for target in targets:
            result[target] = _made(target, replacement, blocks[target])
    _check_sources(blocks, result)
    return result


def load_laws(laws: Iterable[OwnLaw]) -> dict[str, Replacement]:
    """Return the classes that a scenario names, by the blocks whose place they take.

    Raises:
        BlockError: if there is no such file or class, or its code fails.
    """
    return {own.name: _load(own.law) for own in laws}


@cache
def _load(law: str) -> Replacement:
    """Return the class at FILE.py:CLASS; a system of Drake's is made without arguments."""
    path, _, name = law.rpartition(":")
    module_name = f"lola_drake_law_{hashlib.sha256(path.encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise BlockError(f"{path}: no file of Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except OSError as error:
        raise BlockError(f"{path}: {error.strerror}") from None
    except Exception as error:
        raise BlockError(f"{path}: {type(error).__name__}: {reason(error)}") from error
    found = getattr(module, name, None)
    if isinstance(found, type) and issubclass(found, Block):
        return found
    if isinstance(found, type) and issubclass(found, LeafSystem):
        return lambda _: found()
    raise BlockError(f"{path}: holds no Block and no LeafSystem called {name}")


def _made(name: str, replacement: Replacement, block: Block) -> Block | LeafSystem:
    make: Any = replacement
    if isinstance(replacement, type) and issubclass(replacement, Block):
        make = replacement.in_place_of
    made = make if isinstance(make, (Block, LeafSystem)) or not callable(make) else make(block)
    if not isinstance(made, (Block, LeafSystem)):
        raise BlockError(f"{name}: {made!r} is neither a Block nor a LeafSystem")
    if isinstance(made, Block) and made.foot != block.foot:
        feet = (f"the foot {foot!r}" if foot else "no foot" for foot in (made.foot, block.foot))
        raise BlockError(f"{name}: {_called(made)} is one of {', it must be one of '.join(feet)}")
    given = made.outputs if isinstance(made, Block) else _ports(made)[1]
    for port, signal in block.outputs.items():
        if port not in given:
            if signal in block.signals:
                continue
            raise BlockError(f"{name}: {_called(made)} gives no {port!r}, as it must")
        if _size(given[port]) != signal.size:
            raise BlockError(
                f"{name}: {port!r} of {_called(made)} has {_size(given[port])} entries, "
                f"it must have {signal.size}"
            )
    if isinstance(made, LeafSystem):
        _check_inputs(name, made, block)
    return made


def _check_inputs(name: str, system: LeafSystem, block: Block) -> None:
    for port, size in _ports(system)[0].items():
        what = block.inputs.get(port) or signal_of(port)
        known = 0 if isinstance(what, Reading) else what and what.size
        if known != size:
            there_is = f"{known} entries" if known else "no signal of that name"
            has = f"input {port!r} of {_called(system)} has {size}"
            raise BlockError(f"{name}: {has}, there is {there_is}")


def _check_sources(before: Mapping[str, Block], after: Mapping[str, Block | LeafSystem]) -> None:
    """Check that all inputs come from one block each, or from where the blocks before had them."""
    outside = {port for _, port in _without_source(before)}
    for name, port in _without_source(after):
        if port not in outside:
            raise BlockError(f"{name}: no block gives its input {port!r}")


def _without_source(blocks: Mapping[str, Block | LeafSystem]) -> Iterator[tuple[str, str]]:
    """Yield the blocks and their inputs that no block gives."""
    sources: dict[str, str] = {}
    for name, block in blocks.items():
        outputs = block.outputs if isinstance(block, Block) else _ports(block)[1]
        for port in outputs:
            signal = of_foot(port, split_foot(name)[1])
            if signal in sources:
                raise BlockError(f"{sources[signal]} and {name} both give {signal!r}")
            sources[signal] = name
    for name, block in blocks.items():
        for port in block.inputs if isinstance(block, Block) else _ports(block)[0]:
            if not {port, of_foot(port, split_foot(name)[1])} & sources.keys():
                yield name, port


def _ports(system: LeafSystem) -> tuple[dict[str, int], dict[str, int]]:
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    return _sizes(inputs), _sizes(outputs)


def _sizes(ports: Sequence[InputPort] | Sequence[OutputPort]) -> dict[str, int]:
    """Return the sizes of ports, by name; 0 for those that carry no vector."""
    return {
        port.get_name(): port.size() if port.get_data_type() == PortDataType.kVectorValued else 0
        for port in ports
    }


def _size(port: Signal | int) -> int:
    return port if isinstance(port, int) else port.size


def _called(made: Block | LeafSystem) -> str:
    return type(made).__name__
