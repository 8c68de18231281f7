"""One block alone: its ports with all that flows there, and which output follows which input."""

import textwrap

from lola_drake.diagram.block import Block, Port
from lola_drake.diagram.drawing import Drawing, Group, Item, Label, Line, dot, rectangle
from lola_drake.diagram.layout import CHARACTER
from lola_drake.diagram.sheet import (
    BORDER,
    CSS,
    STYLES,
    WIRES,
    Link,
    block_facts,
    field_lines,
)

SIDE, GAP, LINE, COLUMNS = 330.0, 100.0, 11.5, 69
"""Width of the text beside the block, of the room inside of it, height and length of a line."""


def draw_card(block: Block, link: Link) -> Drawing:
    """Return the picture of one block."""
    facts = [line for text in block_facts(block) for line in textwrap.wrap(text, 130)]
    names = [
        max((len(port.name) for port in ports), default=0)
        for ports in (block.inputs, block.outputs)
    ]
    inside = max(CHARACTER * sum(names) + GAP + 14, CHARACTER * 1.15 * len(block.name) + 14)
    left = BORDER + SIDE + 30
    right = left + inside
    top = 2 * BORDER + 26 + LINE * len(facts)
    in_y, in_end = _heights(block.inputs, top)
    out_y, out_end = _heights(block.outputs, top)
    bottom = max(in_end, out_end, top + 40)
    period = f"{1e3 * block.period:g} ms" if block.period else ""
    head = (
        rectangle(block.kind, left, top, inside, bottom - top, 5),
        Label("ink", (left + right) / 2, top + 13, block.name, 11, "middle", bold=True),
        Label("faint", (left + right) / 2, top + 26, period, 8, "middle"),
    )
    items: list[Item] = [
        rectangle("page", 0, 0, right + 30 + SIDE + BORDER, bottom + BORDER),
        Label("ink", BORDER, BORDER + 2, f"{block.name}: {block.type}", 14, bold=True),
        *(Label("faint", BORDER, BORDER + 20 + LINE * i, t, 9) for i, t in enumerate(facts)),
        Group(head, link(block) and "Open the source file", link(block)),
        *(
            _through(block, (source, sink), left, right, in_y, out_y)
            for source, sink in block.through
            if source in in_y and sink in out_y
        ),
    ]
    for port in block.inputs:
        items += _port(port, left, in_y[port.name], output=False)
    for port in block.outputs:
        items += _port(port, right, out_y[port.name], output=True)
    width, height = right + 30 + SIDE + BORDER, bottom + BORDER
    return Drawing(width, height, tuple(items), STYLES, block.name, block.doc, CSS)


def _lines(port: Port) -> list[str]:
    """Return what is said about a port, its name and size aside."""
    signal = port.signal
    if signal is None or signal.size != port.size:
        return [f"{port.size} numbers" if port.size else "an object of Drake's"]
    texts = [signal.doc, *field_lines(signal)]
    return [line for text in texts for line in textwrap.wrap(text, COLUMNS)]


def _heights(ports: tuple[Port, ...], top: float) -> tuple[dict[str, float], float]:
    """Return the height of each port, and where the last one's text ends."""
    heights, y = {}, top + 46
    for port in ports:
        heights[port.name] = y
        y += LINE * (len(_lines(port)) + 1) + 10
    return heights, y - 8


def _through(block, pair, left, right, in_y, out_y) -> Line:
    """Return the line inside the block from an input to an output that follows it."""
    source, sink = pair
    inputs, outputs = ([port.name for port in ports] for ports in (block.inputs, block.outputs))
    start = left + CHARACTER * max(map(len, inputs)) + 22
    end = right - CHARACTER * max(map(len, outputs)) - 22
    points = (
        (left + CHARACTER * len(source) + 14, in_y[source]),
        (start, in_y[source]),
        (end, out_y[sink]),
        (right - CHARACTER * len(sink) - 14, out_y[sink]),
    )
    return Line(f"wire{inputs.index(source) % len(WIRES)}", points)


def _port(port: Port, edge: float, y: float, *, output: bool) -> list[Item]:
    """Return a port's name inside the block, and outside of it what flows there."""
    away = 1 if output else -1
    inner, outer = ("end", "start") if output else ("start", "end")
    text = edge + away * 30
    items: list[Item] = [
        Line("guide", ((edge, y), (edge + away * 24, y))),
        Label("ink", edge - away * 7, y, port.name, 9.5, inner),
    ]
    if port.size is not None:
        items.append(Label("faint", edge + away * 12, y - 6, str(port.size), 7.5, "middle"))
    if not output:
        items.append(Line("faint", ((edge - 7, y - 3), (edge, y), (edge - 7, y + 3)), closed=True))
    elif port.held:
        items.append(rectangle("faint", edge - 2.5, y - 2.5, 5, 5))
    else:
        items.append(dot("faint", edge, y, 2))
    items.append(Label("ink", text, y, port.name, 9.5, outer, bold=True))
    for i, line in enumerate(_lines(port), start=1):
        items.append(Label("faint", text, y + LINE * i, line, 8.5, outer))
    return items
