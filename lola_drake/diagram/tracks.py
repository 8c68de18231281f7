"""The vertical parts of the wires in one channel: which runs left of which."""

Ends = tuple[list[float], list[float]]
"""The heights at which a wire enters a channel from the left, and leaves it to the right."""

CLOSE, ON_TOP = 5.0, 100
"""Wires nearer than this seem to lie on each other; how bad that is, counted in crossings."""


def assign_tracks(ends: list[Ends]) -> list[int]:
    """Return the track of each vertical wire in one channel, counted from the left.

    Wires that do not overlap may share a track; the order is one in which few wires cross.
    """
    order = _cheapest_order([[_cost(a, b) for b in ends] for a in ends])
    tracks = [0] * len(ends)
    for k, wire in enumerate(order):
        before = [tracks[other] for other in order[:k] if _overlap(ends[other], ends[wire])]
        tracks[wire] = max(before, default=-1) + 1
    return tracks


def always_on_top(first: Ends, second: Ends) -> bool:
    """Return whether the two wires lie on each other whichever runs left."""
    return bool(_on_top(first, second) and _on_top(second, first))


def _cheapest_order(cost: list[list[int]]) -> list[int]:
    """Return an order in which no single item is better placed elsewhere.

    Args:
        cost: Of having one item somewhere before another.
    """
    order, improved = list(range(len(cost))), True
    while improved:
        improved = False
        for item in range(len(cost)):
            others = [other for other in order if other != item]
            totals = [
                sum(cost[other][item] for other in others[:place])
                + sum(cost[item][other] for other in others[place:])
                for place in range(len(order))
            ]
            best = min(totals)
            if best < totals[order.index(item)]:
                others.insert(totals.index(best), item)
                order, improved = others, True
    return order


def _cost(first: Ends, second: Ends) -> int:
    """Return how badly two wires meet when the first runs left of the second."""
    crossings = sum(_low(second) < y < _high(second) for y in first[1])
    crossings += sum(_low(first) < y < _high(first) for y in second[0])
    return crossings + ON_TOP * _on_top(first, second)


def _on_top(first: Ends, second: Ends) -> int:
    """Return how many of their stubs lie on each other when the first runs left of the second."""
    return sum(abs(a - b) < CLOSE for a in first[1] for b in second[0])


def _overlap(first: Ends, second: Ends, gap: float = 6.0) -> bool:
    return _low(first) - gap < _high(second) and _low(second) - gap < _high(first)


def _low(ends: Ends) -> float:
    return min(ends[0] + ends[1])


def _high(ends: Ends) -> float:
    return max(ends[0] + ends[1])
