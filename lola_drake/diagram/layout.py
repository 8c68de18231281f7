"""Where everything in a block diagram goes: columns of blocks, and rectangular wires between them.

Blocks stand in columns, each right of what it reads; a signal that passes a column has a lane
there. Graphviz orders blocks and lanes and gives them their heights; the wires then run through
the channels between the columns, one vertical track per signal, ordered so that they cross least.
A wire that runs against the reading direction is feedback. Lengths are in points.
"""

from dataclasses import dataclass, field

from lola_drake.diagram.block import Block, End, Net, Port
from lola_drake.diagram.placing import Trunk, place_rows
from lola_drake.diagram.tracks import assign_tracks

HEADER, ROW, TRACK, MARGIN, PAD = 33.5, 15.0, 7.0, 9.0, 10.0
CHARACTER = 5.3
"""Width of a character of a port's name; wide enough for any sans-serif font of 9 points."""

_STAGE = {"command": 0, "sensor": 0, "plant": 2, "logging": 3}

Point = tuple[float, float]


@dataclass
class Box:
    """A block, or a port of the diagram itself, with its place on the sheet.

    Attributes:
        content: What it shows.
        width, height: Its size.
        in_y, out_y: Heights of its ports from its upper edge.
        inner: What is drawn inside of it, if anything.
        column: In which it stands.
        x, y: Its upper left corner.
    """

    content: Block | Port
    width: float
    height: float
    in_y: dict[str, float]
    out_y: dict[str, float]
    inner: "Sheet | None" = None
    column: int = 0
    x: float = 0.0
    y: float = 0.0


@dataclass
class Wire:
    """A net's drawing: one polyline from its source to each of its sinks."""

    net: Net
    lines: list[list[Point]]


@dataclass
class Sheet:
    """The content of one diagram."""

    boxes: list[Box]
    wires: list[Wire] = field(default_factory=list)
    width: float = 0.0
    height: float = 0.0


@dataclass
class _Route:
    """A net on its way through the channels `first` to `last`; channel i is right of column i."""

    net: Net
    name: str
    source: Box
    sinks: list[Box]

    def __post_init__(self):
        reached = [self.source.column, *(sink.column - 1 for sink in self.sinks)]
        self.first, self.last = min(reached), max(reached)

    @property
    def lanes(self) -> range:
        """Return the columns which the net passes."""
        return range(self.first + 1, self.last + 1)

    def lane(self, column: int) -> str:
        return f"{self.name}@{column}"

    def trunk(self, channel: int) -> Trunk:
        """Return what the net joins in one channel."""
        left, right = [], []
        if self.source.column == channel:
            left.append((_key(self.source), self.source.out_y[self.net.source[1]]))
        if channel in self.lanes:
            left.append((self.lane(channel), 0.0))
        for box, (_, port) in zip(self.sinks, self.net.sinks, strict=True):
            if box.column == channel + 1:
                right.append((_key(box), box.in_y[port]))
        if channel + 1 in self.lanes:
            right.append((self.lane(channel + 1), 0.0))
        return Trunk(channel, tuple(left), tuple(right))


def make_box(block: Block, depth: int = 0, row: float = ROW) -> Box:
    """Return the block with its content laid out to the given depth; a port has a row's height."""
    if depth > 0 and block.children:
        sheet = make_sheet(block, depth, row)
        pills: dict[str, dict[str, float]] = {"in": {}, "out": {}}
        for box in sheet.boxes:
            if isinstance(box.content, Port):
                side = "in" if box.out_y else "out"
                pills[side][box.content.name] = HEADER + box.y + box.height / 2
        return Box(
            *(block, sheet.width, HEADER + sheet.height + PAD),
            *(pills["in"], pills["out"], sheet),
        )
    ports = (*block.inputs, *block.outputs)
    text = max([len(block.name) * 1.15, len(block.type), *(len(p.name) + 3 for p in ports)])
    heights = [HEADER + ROW / 2 + row * i for i in range(len(ports))]
    names = [port.name for port in ports]
    split = len(block.inputs)
    return Box(
        block,
        width=round(CHARACTER * text + 14),
        height=HEADER + row * len(ports) + 4.5,
        in_y=dict(zip(names[:split], heights[:split], strict=True)),
        out_y=dict(zip(names[split:], heights[split:], strict=True)),
    )


def make_sheet(block: Block, depth: int = 1, row: float = ROW) -> Sheet:
    """Return the layout of what is inside of a diagram; a port of a block has a row's height."""
    boxes = {child.name: make_box(child, depth - 1, row) for child in block.children}
    for name, column in _columns(block).items():
        boxes[name].column = column
    last = max((box.column for box in boxes.values()), default=0) + 1
    entries = {port.name: _pill(port, "out", 0) for port in block.inputs}
    exits = {port.name: _pill(port, "in", last) for port in block.outputs}

    def owner(end: End, pills: dict[str, Box]) -> Box:
        return boxes[end[0]] if end[0] else pills[end[1]]

    routes = [
        _Route(
            net,
            f"net{i}",
            owner(net.source, entries),
            [owner(sink, exits) for sink in net.sinks],
        )
        for i, net in enumerate(block.nets)
    ]
    sheet = Sheet([*entries.values(), *boxes.values(), *exits.values()])
    trunks = [route.trunk(c) for route in routes for c in range(route.first, route.last + 1)]
    lanes = {route.lane(column): column for route in routes for column in route.lanes}
    tops = place_rows(
        {_key(box): box.height for box in sheet.boxes} | dict.fromkeys(lanes, 0.0),
        {_key(box): box.column for box in sheet.boxes} | lanes,
        trunks,
    )
    _spread(sheet, routes, tops)
    return sheet


def _key(box: Box) -> str:
    if isinstance(box.content, Block):
        return box.content.name
    return f"{'in' if box.out_y else 'out'}:{box.content.name}"


def _pill(port: Port, side: str, column: int) -> Box:
    lines = pill_lines(port)
    width = round(CHARACTER * max(map(len, lines)) + 16)
    height = 6.0 + 12.0 * len(lines)
    ends = {port.name: height / 2}
    return Box(
        port,
        width,
        height,
        in_y=ends if side == "in" else {},
        out_y=ends if side == "out" else {},
        column=column,
    )


def pill_lines(port: Port) -> list[str]:
    """Return the port's name and size in two lines of about equal length, if it is long."""
    size = "" if port.size is None else f" {port.size}"
    breaks = [i + 1 for i, letter in enumerate(port.name) if letter == "_"]
    if len(port.name) < 10 or not breaks:
        return [port.name + size]
    at = min(breaks, key=lambda i: abs(2 * i - len(port.name + size)))
    return [port.name[:at], port.name[at:] + size]


def _columns(block: Block) -> dict[str, int]:
    """Return the column of every block; the inputs have column 0 for themselves.

    A block stands right of all it reads, except of what comes later in a signal's way from
    sensor to joint, or was added to the diagram later: that is feedback.
    """
    order = sorted(enumerate(block.children), key=lambda c: (_STAGE.get(c[1].kind, 1), c[0]))
    columns: dict[str, int] = {}
    for _, child in order:
        read = {net.source[0] for net in block.nets if child.name in dict(net.sinks)}
        columns[child.name] = 1 + max(
            (columns[name] for name in read if name in columns), default=0
        )
    return columns


def _spread(sheet: Sheet, routes: list[_Route], tops: dict[str, float]) -> None:
    """Give every box its place on the sheet, and every net its lines."""
    for box in sheet.boxes:
        box.y = tops[_key(box)]
    bottoms = [box.y + box.height for box in sheet.boxes]
    sheet.height = max([*bottoms, *tops.values()], default=0.0)
    track_x: dict[tuple[str, int], float] = {}
    x = 0.0
    for column in range(max(box.column for box in sheet.boxes) + 1):
        members = [box for box in sheet.boxes if box.column == column]
        width = max((box.width for box in members), default=0.0)
        for box in members:
            # Inputs keep to the left edge, outputs to the right one.
            side = 0.5 if isinstance(box.content, Block) else float(bool(box.in_y))
            box.x = x + side * (width - box.width)
        x += width
        passing = [route for route in routes if route.first <= column <= route.last]
        x += _lay_tracks(passing, column, x, tops, track_x)
    sheet.width = x
    sheet.wires = [Wire(route.net, _lines(route, tops, track_x)) for route in routes]


def _lay_tracks(routes, channel, x, tops, track_x) -> float:
    """Fill in where the vertical parts of one channel run; return the channel's width."""
    ends = [route.trunk(channel).ends(tops) for route in routes]
    turning = [i for i, (left, right) in enumerate(ends) if len({*left, *right}) > 1]
    tracks = assign_tracks([ends[i] for i in turning])
    for i, route in enumerate(routes):
        track = tracks[turning.index(i)] if i in turning else 0
        track_x[route.name, channel] = x + MARGIN + TRACK * track
    if not routes:
        return 0.0
    return 2 * MARGIN + TRACK * max(tracks, default=0)


def _lines(route: _Route, tops: dict[str, float], track_x: dict) -> list[list[Point]]:
    start = (
        route.source.x + route.source.width,
        route.source.y + route.source.out_y[route.net.source[1]],
    )
    lines = []
    for sink, (_, port) in zip(route.sinks, route.net.sinks, strict=True):
        channel, goal = route.source.column, sink.column - 1
        line = [start, (track_x[route.name, channel], start[1])]
        while channel != goal:
            following = channel + (1 if goal > channel else -1)
            y = tops[route.lane(max(channel, following))]
            line += [(track_x[route.name, c], y) for c in (channel, following)]
            channel = following
        end = (sink.x, sink.y + sink.in_y[port])
        lines.append(_straightened([*line, (track_x[route.name, channel], end[1]), end]))
    return lines


def _straightened(line: list[Point]) -> list[Point]:
    """Return the same line without points on which it does not turn."""
    kept = line[:1]
    for before, point, after in zip(line, line[1:], line[2:], strict=False):
        if not (before[0] == point[0] == after[0] or before[1] == point[1] == after[1]):
            kept.append(point)
    return [*kept, line[-1]]
