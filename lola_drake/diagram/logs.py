"""Which part of a block diagram is for logs only, and the diagram without it."""

import re
from collections import Counter
from dataclasses import replace

from lola_drake.diagram.block import Block, Net


def mark_logs(children: list[Block], nets: tuple[Net, ...]) -> list[Block]:
    """Give the kind `logging` also to what only prepares a log."""
    logs = {child.name for child in children if child.kind == "logging"}
    readers: dict[str, set[str]] = {}
    for net in nets:
        readers.setdefault(net.source[0], set()).update(block for block, _ in net.sinks)
    return [
        replace(child, kind="logging")
        if child.source is None and readers.get(child.name) and readers[child.name] <= logs
        else child
        for child in children
    ]


def called_by_sources(
    children: list[Block], nets: tuple[Net, ...]
) -> tuple[list[Block], tuple[Net, ...]]:
    """Call the nameless inputs of logs (u0, u1 …) as the outputs that they read."""
    logs = {child.name for child in children if child.kind == "logging"}
    found = {end: _said(*net.source) for net in nets for end in net.sinks if end[0] in logs}
    taken = Counter((block, name) for (block, _), name in found.items())
    names = {
        end: name
        for end, name in found.items()
        if re.fullmatch(r"u\d+", end[1]) and taken[end[0], name] == 1
    }

    def called(child: Block) -> Block:
        inputs = (replace(p, name=names.get((child.name, p.name), p.name)) for p in child.inputs)
        return replace(child, inputs=tuple(inputs))

    ends = [tuple((end[0], names.get(end, end[1])) for end in net.sinks) for net in nets]
    renamed = tuple(replace(net, sinks=sinks) for net, sinks in zip(nets, ends, strict=True))
    return [called(child) for child in children], renamed


def _said(block: str, port: str) -> str:
    """Return what flows out of a port: its name, or that of its block where it has none."""
    return block if block and re.fullmatch(r"y\d+", port) else port


def wired(child: Block, nets: tuple[Net, ...]) -> Block:
    """Note which ports are connected; of library blocks only those are worth showing."""
    read = {port for net in nets for block, port in net.sinks if block == child.name}
    made = {net.source[1] for net in nets if net.source[0] == child.name}

    def marked(ports, used):
        ports = [replace(port, connected=port.name in used) for port in ports]
        return tuple(port for port in ports if port.connected or child.source is not None)

    return replace(child, inputs=marked(child.inputs, read), outputs=marked(child.outputs, made))


def without_logs(block: Block) -> Block:
    """Return the diagram without its logs, and without what its diagrams only give to them."""
    children = [child for child in block.children if child.kind != "logging"]
    kept = {"", *(child.name for child in children)}
    nets = tuple(
        replace(net, sinks=sinks)
        for net in block.nets
        if (sinks := tuple(sink for sink in net.sinks if sink[0] in kept))
    )
    children = [wired(without_logs(child), nets) for child in children]
    children = [
        pruned(child, {port.name for port in child.outputs if not port.connected})
        if child.children
        else child
        for child in children
    ]
    return replace(block, children=tuple(children), nets=nets)


def pruned(block: Block, unused: set[str]) -> Block:
    """Return the diagram without some of its outputs."""
    nets = tuple(
        replace(net, sinks=sinks)
        for net in block.nets
        if (sinks := tuple(s for s in net.sinks if s[0] or s[1] not in unused))
    )
    return replace(
        block,
        outputs=tuple(port for port in block.outputs if port.name not in unused),
        children=tuple(wired(child, nets) for child in block.children),
        nets=nets,
    )
