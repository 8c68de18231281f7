"""The look of a block diagram: blocks, ports and wires as shapes, with hints and links."""

from collections.abc import Callable
from itertools import pairwise

from lola_drake.diagram.block import Block, End, Port
from lola_drake.diagram.drawing import (
    Drawing,
    Group,
    Item,
    Label,
    Line,
    Style,
    dot,
    moved,
    rectangle,
)
from lola_drake.diagram.layout import HEADER, Box, Point, Sheet, Wire, pill_lines
from lola_drake.signals import Signal, of_foot, split_foot

BORDER, TITLE, LEGEND = 16.0, 34.0, 26.0

KIND_COLOURS = {
    "command": (("#eef0f3", "#22272e"), ("#6b7280", "#9aa4b2")),
    "sensor": (("#e3f4ee", "#10291f"), ("#00855f", "#3fcf9f")),
    "planning": (("#f6e9f2", "#33202c"), ("#a8527f", "#e08fbb")),
    "control": (("#e4f0fa", "#112538"), ("#0067a8", "#5fb2ee")),
    "actuation": (("#fdebdf", "#38200f"), ("#c24e00", "#ff965c")),
    "plant": (("#fbf3dc", "#322a10"), ("#96730a", "#e0b83f")),
    "logging": (("#f7f7f7", "#1b1f24"), ("#9ca3af", "#6e7681")),
}
"""Fill and outline of each kind, in light and dark."""

WIRES = (
    ("#0067a8", "#5fb2ee"),
    ("#c24e00", "#ff965c"),
    ("#00855f", "#3fcf9f"),
    ("#a8527f", "#e08fbb"),
    ("#96730a", "#e0b83f"),
    ("#4a5a8a", "#a5b4e8"),
    ("#2a8ca0", "#66d9ef"),
    ("#8a4b2a", "#d9a07a"),
)
"""Colours that wires may have, in light and dark."""

STYLES = {
    "page": Style(fill=("#ffffff", "#0d1117")),
    "frame": Style(fill=("#fbfcfd", "#11161d"), stroke=("#9aa4b2", "#545d68")),
    "ink": Style(fill=("#1f2328", "#e6edf3")),
    "faint": Style(fill=("#5f6873", "#98a2ad")),
    "hollow": Style(fill=("#ffffff", "#0d1117"), stroke=("#6b7280", "#8b949e")),
    "guide": Style(stroke=("#9aa4b2", "#6e7681"), width=0.9),
    "net": Style(),
    "reach": Style(),
    **{name: Style(fill, stroke, 1.2) for name, (fill, stroke) in KIND_COLOURS.items()},
    **{f"wire{i}": Style(stroke=colours, width=1.3) for i, colours in enumerate(WIRES)},
    **{f"end{i}": Style(fill=colours) for i, colours in enumerate(WIRES)},
}
CSS = (
    ".reach{stroke:transparent;stroke-width:9}\n"
    ".net:hover path{stroke-width:3}\n"
    "a:hover text{text-decoration:underline}\n"
)

Link = Callable[[Block], str]


def draw_sheet(block: Block, sheet: Sheet, link: Link) -> Drawing:
    """Return the picture of a diagram, with its name above and a legend below."""
    legend, legend_width = _legend(block)
    width = max(sheet.width, legend_width) + 2 * BORDER
    height = TITLE + sheet.height + LEGEND + 2 * BORDER
    left = (width - sheet.width) / 2
    items = (
        rectangle("page", 0, 0, width, height),
        Label("ink", BORDER, BORDER, block.name, 14, bold=True),
        Label("faint", BORDER, BORDER + 16, block.doc, 9),
        *moved(_sheet_items(sheet, link), left, TITLE + BORDER),
        *moved(legend, BORDER, height - BORDER - 6),
    )
    return Drawing(width, height, items, STYLES, block.name, block.doc, CSS)


def _sheet_items(sheet: Sheet, link: Link) -> list[Item]:
    frames: list[Item] = []
    boxes: list[Item] = []
    sources = {sink: wire.net.source for wire in sheet.wires for sink in wire.net.sinks}
    for box in sheet.boxes:
        if isinstance(box.content, Port):
            boxes.append(_pill(box, box.content))
        elif box.inner is None:
            boxes.append(_block(box, box.content, link, sources))
        else:
            frames += _frame(box, box.content, box.inner, link)
    colours = _wire_colours(sheet.wires)
    wires = [_wire(wire, colour) for wire, colour in zip(sheet.wires, colours, strict=True)]
    return [*frames, *wires, *boxes]


def _frame(box: Box, block: Block, inner: Sheet, link: Link) -> list[Item]:
    """Return an opened diagram: a frame, a name, and what is inside."""
    name = Label("ink", box.x + 10, box.y + 12, block.name, 11, bold=True)
    return [
        rectangle("frame", box.x, box.y, box.width, box.height, 6),
        Group((name,), block_hint(block), link(block)),
        *moved(_sheet_items(inner, link), box.x, box.y + HEADER),
    ]


def _block(box: Box, block: Block, link: Link, sources: dict[End, End]) -> Group:
    x, y, right = box.x, box.y, box.x + box.width
    period = f"{1e3 * block.period:g} ms" if block.period else ""
    head = (
        rectangle(block.kind, x, y, box.width, box.height, 4),
        Label("ink", x + 7, y + 11, block.name, 10.5, bold=True),
        Label("faint", x + 7, y + 24, block.type, 8),
        Label("faint", right - 7, y + 24, period, 8, "end"),
    )
    rows = []
    for ports, heights, output in (
        (block.inputs, box.in_y, False),
        (block.outputs, box.out_y, True),
    ):
        for port, height in zip(ports, heights.values(), strict=True):
            end = (block.name, port.name)
            signal = _signal_name(*(end if output else sources.get(end, ("", ""))))
            rows.append(_row(port, signal, x, right, y + height, output=output))
    return Group((Group(head, block_hint(block), link(block)), *rows))


def _signal_name(block: str, port: str) -> str:
    """Return the name of the signal that an output gives: of a foot's block it is the foot's."""
    return of_foot(port, split_foot(block)[1])


def _row(port: Port, signal: str, left: float, right: float, y: float, *, output: bool) -> Group:
    size = "" if port.size is None else str(port.size)
    inner, outer = ("start", "end") if output else ("end", "start")
    near, far = (right, left + 7) if output else (left, right - 7)
    items: list[Item] = [
        Label("ink", near + (-7 if output else 7), y, port.name, 9.5, outer),
        Label("faint", far, y, size, 7.5, inner),
    ]
    if not port.connected:
        items.append(dot("hollow", near, y, 2.5))
    elif output and port.held:
        items.append(rectangle("faint", near - 2.5, y - 2.5, 5, 5))
    elif output:
        items.append(dot("faint", near, y, 2))
    return Group(tuple(items), port_hint(port), signal=signal)


def _pill(box: Box, port: Port) -> Group:
    lines = pill_lines(port)
    first = box.y + box.height / 2 - 5.5 * (len(lines) - 1)
    middle = box.x + box.width / 2
    return Group(
        (
            rectangle("frame", box.x, box.y, box.width, box.height, 9),
            *(Label("ink", middle, first + 11 * i, t, 9.5, "middle") for i, t in enumerate(lines)),
        ),
        port_hint(port),
    )


def _wire_colours(wires: list[Wire]) -> list[int]:
    """Return a colour for each wire that no wire close beside it has, where possible."""
    chosen: list[int] = []
    for i, wire in enumerate(wires):
        near = [_closeness(wire, other) for other in wires[:i]]
        cost = [0.0] * len(WIRES)
        for colour, closeness in zip(chosen, near, strict=True):
            cost[colour] += closeness + 1e-3
        chosen.append(cost.index(min(cost)))
    return chosen


def _closeness(wire: Wire, other: Wire) -> float:
    """Return for how long two wires run side by side."""
    return sum(
        _side_by_side(first, second)
        for line in wire.lines
        for first in pairwise(line)
        for line_ in other.lines
        for second in pairwise(line_)
    )


def _side_by_side(first: tuple[Point, Point], second: tuple[Point, Point]) -> float:
    for along, across in ((0, 1), (1, 0)):
        if first[0][across] == first[1][across] and second[0][across] == second[1][across]:
            (a, b), (c, d) = (sorted((p[along], q[along])) for p, q in (first, second))
            near = abs(first[0][across] - second[0][across]) < 20
            return max(min(b, d) - max(a, c), 0.0) if near else 0.0
    return 0.0


def _wire(wire: Wire, colour: int) -> Group:
    block, port = wire.net.source
    readers = ", ".join(dict.fromkeys(name or "outside" for name, _ in wire.net.sinks))
    hint = f"{port}: {block or 'outside'} → {readers}"
    lines: list[Item] = []
    for points in wire.lines:
        (x, y) = points[-1]
        tip = ((x - 7, y - 3), (x, y), (x - 7, y + 3))
        shortened = (*points[:-1], (x - 5, y))
        lines += [
            Line("reach", shortened, 4),
            Line(f"wire{colour}", shortened, 4),
            Line(f"end{colour}", tip, closed=True),
        ]
    return Group(tuple(lines), hint, style="net")


def _legend(block: Block) -> tuple[list[Item], float]:
    """Return the legend of the kinds and port marks, and its width."""
    kinds = [
        kind for kind in KIND_COLOURS if kind in {b.kind for b in block.walk() if not b.children}
    ]
    items: list[Item] = []
    x = 0.0
    for kind in kinds:
        items += [rectangle(kind, x, -5, 14, 10, 3), Label("faint", x + 19, 0, kind, 8.5)]
        x += 34 + 5 * len(kind)
    marks = (
        (dot("faint", 0, 0, 2), "follows its inputs at once"),
        (rectangle("faint", -2.5, -2.5, 5, 5), "held by a state: one period later"),
        (dot("hollow", 0, 0, 2.5), "not connected"),
    )
    for mark, text in marks:
        items += [*moved([mark], x + 4, 0), Label("faint", x + 12, 0, text, 8.5)]
        x += 30 + 4.4 * len(text)
    return items, x


def block_hint(block: Block) -> str:
    """Return what hovering over a block tells."""
    return "\n".join([f"{block.name} ({block.type})", *block_facts(block)])


def block_facts(block: Block) -> list[str]:
    """Return what there is to say about a block, one line each."""
    facts = [block.doc]
    if block.equations:
        facts.append(f"Paper: eq. {', '.join(map(str, block.equations))}")
    if block.states:
        rate = f" every {1e3 * block.period:g} ms" if block.period else ""
        facts.append(f"State: {' + '.join(map(str, block.states))} numbers{rate}")
    return list(filter(None, facts))


def port_hint(port: Port) -> str:
    """Return what hovering over a port tells."""
    size = "an object" if port.size is None else f"{port.size} numbers"
    signal = port.signal
    if signal is None or signal.size != port.size:
        return f"{port.name}: {size}"
    return "\n".join([f"{port.name}: {signal.doc}", *field_lines(signal)])


def field_lines(signal: Signal) -> list[str]:
    """Return one line per field of a signal: its entries, units and frame."""
    lines = []
    for field in signal.fields:
        entries = " ".join(filter(None, (field.name, *field.entries)))
        frame = f", in {field.frame}" if field.frame else ""
        units = ", ".join(dict.fromkeys(field.units))
        lines.append(f"{entries} ({units}{frame})")
    return lines
