"""A Drake system as plain data for a drawing: blocks, ports, nets, and what they mean.

Everything is read from the system itself: the wiring from Drake, one line of description, the
equation numbers and the source file from its Python class. Nothing in it depends on addresses or
run-time numbers, so that equal systems give equal data.
"""

import dataclasses
import inspect
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from pydrake.systems.framework import (
    Diagram,
    InputPort,
    InputPortIndex,
    OutputPort,
    OutputPortIndex,
    PortDataType,
    System,
)

from lola_drake.diagram.block import Block, End, Net, Port
from lola_drake.diagram.logs import called_by_sources, mark_logs, pruned, wired, without_logs
from lola_drake.signals import Signal, signal_of

_LIBRARY_KINDS = {
    "ConstantVectorSource": "command",
    "TrajectorySource": "command",
    "MultibodyPlant": "plant",
    "SceneGraph": "plant",
    "VectorLogSink": "logging",
}
_LIBRARY_DOCS = {
    "ConstantVectorSource": "A constant.",
    "TrajectorySource": "A function of time.",
    "MultibodyPlant": "The robot's bodies and joints, its servos' gains, and the contact.",
    "SceneGraph": "Where all geometry is, and what touches what.",
    "Multiplexer": "Stacks vectors into one.",
    "VectorLogSink": "Keeps every sample of a vector.",
}


def read_block(system: System, *, logging: bool = False) -> Block:
    """Return a system as a drawing needs it.

    Args:
        system: A diagram or a single system.
        logging: Whether to keep the logs, and the outputs that exist for logs only: signals that
            a diagram also passes on between its own blocks, or that nobody reads.
    """
    block = _read(system)
    if logging or not block.children:
        return block
    taps = {
        port
        for net in block.nets
        for owner, port in net.sinks
        if owner == "" and len(net.sinks) > 1
    }
    return pruned(without_logs(block), taps)


def _read(system: System) -> Block:
    declared = getattr(system, "block", None)
    cls = type(system if declared is None else declared)
    library = (_LIBRARY_KINDS.get(base.__name__) for base in cls.__mro__)
    kind = declared.kind if declared else next(filter(None, library), "control")
    children: tuple[Block, ...] = ()
    nets: tuple[Net, ...] = ()
    if isinstance(system, Diagram):
        nets = _nets(system)
        inside = mark_logs([_read(child) for child in system.GetSystems()], nets)
        inside, nets = called_by_sources(inside, nets)
        children = tuple(wired(child, nets) for child in inside)
    own = {signal.name: signal for signal in declared.signals} if declared else {}
    inputs = [_port(system.get_input_port(i), own) for i in range(system.num_input_ports())]
    outputs = [_port(system.get_output_port(i), own) for i in range(system.num_output_ports())]
    through = tuple(
        (source.name, sink.name)
        for i, source in enumerate(inputs)
        for k, sink in enumerate(outputs)
        if system.HasDirectFeedthrough(i, k)
    )
    direct = {sink for _, sink in through}
    return Block(
        name=system.get_name() or cls.__name__,
        type=cls.__name__,
        kind=kind,
        doc=_one_line(cls),
        equations=_equations(cls),
        module=cls.__module__,
        source=_source_file(cls),
        period=_period(system),
        states=() if isinstance(system, Diagram) else _states(system),
        inputs=tuple(inputs),
        outputs=tuple(
            dataclasses.replace(port, held=bool(inputs) and port.name not in direct)
            for port in outputs
        ),
        through=through,
        children=children,
        nets=nets,
    )


def _port(port: InputPort | OutputPort, own: Mapping[str, Signal]) -> Port:
    abstract = port.get_data_type() == PortDataType.kAbstractValued
    name = port.get_name()
    signal = own.get(name) or signal_of(name)
    return Port(name, None if abstract else port.size(), signal=signal)


def _period(system: System) -> float | None:
    attribute = system.GetUniquePeriodicDiscreteUpdateAttribute()
    return attribute.period_sec() if attribute else None


def _states(system: System) -> tuple[int, ...]:
    context = system.CreateDefaultContext()
    groups = range(context.num_discrete_state_groups())
    return tuple(context.get_discrete_state(i).size() for i in groups)


def _nets(diagram: Diagram) -> tuple[Net, ...]:
    """Return the wiring inside, sorted as the blocks and ports are."""
    order = {"": -1} | {system.get_name(): i for i, system in enumerate(diagram.GetSystems())}
    wires = [
        ((system.get_name(), int(index)), (target.get_name(), int(port)))
        for (target, port), (system, index) in diagram.connection_map().items()
    ]
    for i in range(diagram.num_input_ports()):
        for target, port in diagram.GetInputPortLocators(InputPortIndex(i)):
            wires.append((("", i), (target.get_name(), int(port))))
    for i in range(diagram.num_output_ports()):
        system, index = diagram.get_output_port_locator(OutputPortIndex(i))
        wires.append(((system.get_name(), int(index)), ("", i)))
    sinks: dict[tuple, list] = {}
    for source, sink in wires:
        sinks.setdefault(source, []).append(sink)

    def place(end):
        return order[end[0]], end[1]

    def end(block: str, index: int, *, is_source: bool) -> End:
        system = diagram.GetSubsystemByName(block) if block else diagram
        as_input = is_source == (block == "")
        port = (system.get_input_port if as_input else system.get_output_port)(index)
        return block, port.get_name()

    return tuple(
        Net(
            end(*source, is_source=True),
            tuple(end(*sink, is_source=False) for sink in sorted(sinks[source], key=place)),
        )
        for source in sorted(sinks, key=place)
    )


def _one_line(cls: type) -> str:
    if cls.__module__.startswith("pydrake"):
        return _LIBRARY_DOCS.get(cls.__name__, "")
    return " ".join((inspect.getdoc(cls) or "").split("\n\n")[0].split())


def _source_file(cls: type) -> Path | None:
    if cls.__module__.startswith("pydrake"):
        return None
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    return Path(file) if file else None


def _equations(cls: type) -> tuple[int, ...]:
    source = _source_file(cls)
    if source is None:
        return ()
    lists = re.findall(r"\beq\. (\d+(?:(?:, | and |, and )\d+)*)", source.read_text("utf-8"))
    return tuple(sorted({int(number) for text in lists for number in re.findall(r"\d+", text)}))
