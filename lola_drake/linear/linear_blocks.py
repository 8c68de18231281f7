"""All blocks of a system, linearised at one operating point."""

from collections.abc import Iterable

from pydrake.systems.framework import Context, System

from lola_drake.linear.block_jacobian import block_jacobian
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.interconnection import LinearBlocks
from lola_drake.linear.isolated import IsolatedBlocks, isolate
from lola_drake.linear.wiring import Selection, Source, Wiring
from lola_drake.typed_yaml import suggestion


def linear_blocks(
    system: System,
    context: Context,
    inputs: Iterable[Selection],
    outputs: Iterable[Selection],
    *,
    hold: Iterable[str] = (),
    checked: bool = True,
) -> LinearBlocks:
    """Return the Jacobians of all blocks that have state, and of those between them.

    Args:
        system: a Diagram or a single block.
        context: of it, or of a diagram around it; it stays as it is.
        inputs: signals at which something will be added.
        outputs: signals that will be read.
        hold: paths of blocks to hold besides those that always are.
        checked: as in `block_jacobian`.

    Raises:
        AnalysisError: if one of these is no block, or a block cannot be linearised.
    """
    wiring, hold = Wiring(system), {hold} if isinstance(hold, str) else set(hold)
    for unknown in sorted(hold - set(wiring.blocks)):
        raise AnalysisError(f"no block {unknown!r} to hold{suggestion(unknown, wiring.blocks)}")
    added = {selection.source for selection in inputs}
    read = {selection.source for selection in outputs}
    isolated = isolate(wiring, context, added)
    held = {
        path
        for path, block in wiring.blocks.items()
        if path in hold or is_held(block, any(source.block == path for source in read))
    }
    moving = _moving(isolated, held, read)
    jacobians = []
    for group in _groups(wiring, moving, isolated):
        targets = [
            target
            for target, source in wiring.feeds.items()
            if target.block in group
            and target in isolated.inputs
            and (source in added or (source.block in moving and not source.is_input))
        ]
        readers = {wiring.feeds[t] for t in isolated.inputs if t.block in moving}
        sources = sorted(s for s in readers | read if s.block in group and not s.is_input)
        jacobians.append(block_jacobian(isolated, group, targets, sources, checked=checked))
    return LinearBlocks(isolated, tuple(jacobians), tuple(sorted(held)), _period(isolated, moving))


def is_held(system: System, is_read: bool = False) -> bool:
    """Return whether a block stays as it is: it declares that it does, or that it only switches.

    A block that switches is let go where a signal of its is read: another one may move.
    """
    block = getattr(system, "block", None)
    return block is not None and (block.held or (block.switching and not is_read))


def _moving(isolated: IsolatedBlocks, held: set[str], read: set[Source]) -> set[str]:
    """Return the blocks that matter: with state or read, and what feeds those."""
    wiring = isolated.wiring
    found = {source.block for source in read if not source.is_input}
    found |= {
        path
        for path, instance in isolated.instances.items()
        if instance.context.num_discrete_state_groups()
        or instance.context.num_continuous_states()
        or instance.context.num_abstract_states()
    }
    found -= held
    waiting = list(found)
    while waiting:
        reader = waiting.pop()
        feeding = {
            source.block
            for target, source in wiring.feeds.items()
            if target.block == reader and not source.is_input
        }
        waiting += feeding - found - held
        found |= feeding - held
    return found


def _groups(wiring: Wiring, moving: set[str], isolated: IsolatedBlocks) -> list[list[str]]:
    """Return the moving blocks, those together that exchange more than vectors."""
    group_of = {path: {path} for path in wiring.blocks if path in moving}
    for target, source in wiring.feeds.items():
        tied = {target.block, source.block} <= moving and not source.is_input
        if tied and target not in isolated.inputs:
            joined = group_of[target.block] | group_of[source.block]
            group_of.update(dict.fromkeys(joined, joined))
    order = list(group_of)
    unique = {id(group): group for group in group_of.values()}
    return [sorted(group, key=order.index) for group in unique.values()]


def _period(isolated: IsolatedBlocks, moving: set[str]) -> float | None:
    """Return the period of all blocks; AnalysisError if they do not all tick together."""
    timings = {
        path: timing for path in sorted(moving) if (timing := isolated.timing(path)) is not None
    }
    for what, values in (
        ("periods", {path: period for path, (period, _) in timings.items()}),
        ("offsets", {path: offset for path, (_, offset) in timings.items()}),
    ):
        if len(set(values.values())) > 1:
            which = ", ".join(f"{path} {1e3 * value:g} ms" for path, value in values.items())
            raise AnalysisError(
                f"blocks of different {what} cannot be linearised together: {which}"
            )
    return next((period for period, _ in timings.values()), None)
