"""Heights of what stands in the columns of a drawing: the order by Graphviz, then levelled."""

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
import pygraphviz
from scipy.optimize import linprog

from lola_drake.diagram.tracks import CLOSE, Ends, always_on_top

LANE_GAP, BOX_GAP = 9.0, 26.0
"""Least distance between wires in parallel, and between large blocks."""

BLOCK = 40.0
"""A block is higher than this, a port of the diagram itself is not."""

ATTEMPTS = 8
"""How often to try to part wires that lie on each other."""


@dataclass(frozen=True)
class Trunk:
    """The vertical part of one wire in one channel.

    Attributes:
        channel: It lies right of the column of the same number.
        left, right: What it joins on either side: item and distance from the item's upper edge.
    """

    channel: int
    left: tuple[tuple[str, float], ...]
    right: tuple[tuple[str, float], ...]

    def ends(self, tops: dict[str, float]) -> Ends:
        """Return at which heights it is joined, once the items have their upper edges."""
        left, right = ([tops[name] + at for name, at in end] for end in (self.left, self.right))
        return left, right


def place_rows(
    heights: dict[str, float], columns: dict[str, int], trunks: list[Trunk]
) -> dict[str, float]:
    """Return the upper edge of every item, such that wires are short and cross little.

    Args:
        heights: Of every item; 0 is a wire that passes its column.
        columns: In which column each item stands.
        trunks: What is joined to what.
    """
    around = _ranked(heights, columns, trunks)
    ordered = sorted(heights, key=lambda name: (columns[name], around[name]))
    limits = []
    for above, below in pairwise(ordered):
        if columns[above] == columns[below]:
            gap = min(max(0.25 * min(heights[above], heights[below]), LANE_GAP), BOX_GAP)
            limits.append((above, below, -heights[above] - gap))
    for _ in range(ATTEMPTS):
        tops = _levelled(heights, limits, trunks, around)
        narrow = [
            _parted(a, b, tops)
            for a, b in combinations(trunks, 2)
            if a.channel == b.channel and always_on_top(a.ends(tops), b.ends(tops))
        ]
        if not narrow:
            break
        limits += narrow
    return tops


def _ranked(heights, columns, trunks) -> dict[str, float]:
    """Return the items' centres as Graphviz places them, counted downwards.

    Every column and every channel is a rank of its own; a trunk is a point in its channel.
    """
    ports: dict[str, set[float]] = {name: set() for name in heights}
    for trunk in trunks:
        for name, offset in (*trunk.left, *trunk.right):
            ports[name].add(offset)
    ids = {name: f"n{i}" for i, name in enumerate(heights)}
    lines = ["digraph { rankdir=LR; nodesep=0.15; node [shape=plain];"]
    for name, height in heights.items():
        lines.append(f"{ids[name]} [label=<{_table(height, sorted(ports[name]))}>];")
    for rank in range(2 * max(columns.values()) + 2):
        members = [ids[name] for name, column in columns.items() if 2 * column == rank]
        members += [f"t{i}" for i, trunk in enumerate(trunks) if 2 * trunk.channel + 1 == rank]
        lines.append(f'a{rank} [style=invis label=""];')
        lines.append(f"{{rank=same; {'; '.join([f'a{rank}', *members])}}}")
        if rank:
            lines.append(f"a{rank - 1} -> a{rank} [style=invis weight=0];")
    for i, trunk in enumerate(trunks):
        lines.append(f't{i} [shape=point width=0.01 label=""];')
        for name, offset in trunk.left:
            lines.append(f"{ids[name]}:p{offset:.0f}:e -> t{i} [weight={_weight(heights[name])}];")
        for name, offset in trunk.right:
            lines.append(f"t{i} -> {ids[name]}:p{offset:.0f}:w [weight={_weight(heights[name])}];")
    graph = pygraphviz.AGraph(string="\n".join([*lines, "}"]))
    graph.layout(prog="dot")
    return {name: -float(graph.get_node(i).attr["pos"].split(",")[1]) for name, i in ids.items()}


def _weight(height: float) -> int:
    """Wires in passing want to be straight more than those that end at a block."""
    return 2 if height else 20


def _table(height: float, offsets: list[float]) -> str:
    """Return an empty table of the given height, with a thin row for every port."""
    rows, at = [], 0.0
    for offset in offsets:
        rows += [_row(offset - 1 - at), _row(2.0, f'PORT="p{offset:.0f}"')]
        at = offset + 1
    rows.append(_row(height - at))
    inside = "".join(rows)
    return f'<TABLE BORDER="0" CELLBORDER="0" CELLSPACING="0" CELLPADDING="0">{inside}</TABLE>'


def _row(height: float, port: str = "") -> str:
    if height <= 0:
        return ""
    return f'<TR><TD {port} FIXEDSIZE="TRUE" WIDTH="40" HEIGHT="{height:g}"></TD></TR>'


Limit = tuple[str, str, float]
"""Two items: the first one's upper edge less the second one's is at most the number."""


def _levelled(heights, limits: list[Limit], trunks, around) -> dict[str, float]:
    """Return upper edges within the limits that make the trunks as short as can be.

    A linear programme. Its unknowns are the items' upper edges, the upper and lower ends of the
    trunks, and the distances from `around`, which decide only what the wires leave open.
    """
    y = {name: i for i, name in enumerate(heights)}
    n, m = len(y), len(trunks)
    stiff = np.array([_stiffness(trunk, heights) for trunk in trunks])
    cost = np.r_[np.zeros(n), -stiff, stiff, np.full(n, 1e-3)]
    terms = [((y[first], 1), (y[second], -1), bound) for first, second, bound in limits]
    for k, trunk in enumerate(trunks):
        for name, offset in (*trunk.left, *trunk.right):
            terms.append(((n + k, 1), (y[name], -1), offset))
            terms.append(((y[name], 1), (n + m + k, -1), -offset))
    least = min(around[name] - heights[name] / 2 for name in heights)
    for name, i in y.items():
        wish = around[name] - heights[name] / 2 - least
        for sign in (1, -1):
            terms.append(((i, sign), (2 * m + n + i, -1), sign * wish))
    rows, bounds = np.zeros((len(terms), len(cost))), np.zeros(len(terms))
    for row, ((i, a), (k, b), bound) in enumerate(terms):
        rows[row, i], rows[row, k], bounds[row] = a, b, bound
    found = linprog(cost, A_ub=rows, b_ub=bounds, bounds=(None, None)).x
    assert found is not None, "limits that no heights keep"
    found = found[:n]
    return {name: round(found[i] - found.min()) for name, i in y.items()}


def _parted(first: Trunk, second: Trunk, tops: dict[str, float]) -> Limit:
    """Return the limit that keeps two wires apart which would lie on each other in any order."""
    for a, b in ((first, second), (second, first)):
        for one, at in a.left:
            for other, beside in b.right:
                distance = tops[one] + at - tops[other] - beside
                if abs(distance) < CLOSE:
                    if distance <= 0:
                        return one, other, beside - at - CLOSE
                    return other, one, at - beside - CLOSE
    raise AssertionError("wires that are not on each other need not be parted")


def _stiffness(trunk: Trunk, heights: dict[str, float]) -> float:
    """Return how much a wire resists to bend: least where it branches, most far from blocks."""
    ends = [name for name, _ in (*trunk.left, *trunk.right)]
    if len(ends) > 2:
        return 1.0
    return 2.0 if all(heights[name] < BLOCK for name in ends) else 1.3
