"""One block's exact tick, linearised on its own by central differences.

Blocks that are tied together by objects that are not vectors (contact results, geometry queries)
are linearised together, as one group.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from scipy.linalg import block_diag

from lola_drake.linear.errors import AnalysisError, drake_errors
from lola_drake.linear.isolated import (
    IsolatedBlocks,
    discrete_state,
    fix_port,
    join_groups,
    read_port,
    set_discrete_state,
)
from lola_drake.linear.kinks import (
    FAR,
    OVERLOOKED,
    Column,
    has_kink,
    is_flat,
    is_quantised,
    solver_has_kink,
)
from lola_drake.linear.signal_names import state_names, switches
from lola_drake.linear.soundness import check_events, check_memory, check_timing
from lola_drake.linear.tangent import Tangent, tangent_of
from lola_drake.linear.wiring import Source, Target

STEP = 6e-6
"""Relative step of central differences: the cube root of the machine's precision."""

CONTACT_STEP = 1e-7
"""The same for a multibody plant: its contact is curved so strongly that less is better."""


@dataclass(frozen=True)
class BlockJacobian:
    """What a group of blocks does in one tick with small motions.

    Attributes:
        group: paths of the blocks.
        states: the blocks whose states make up the group's state, with their coordinates.
        inputs: the moved inputs, with their sizes.
        outputs: the read outputs, with their sizes.
        matrix: derivative of [next states, outputs] by [states, inputs].
        drift: next state less present state, in coordinates of small motions.
        kinks: names of the states and inputs at which the two sides have different slopes; the
            matrix has the mean of both.
    """

    group: tuple[str, ...]
    states: dict[str, Tangent]
    inputs: dict[Target, int]
    outputs: dict[Source, int]
    matrix: np.ndarray
    drift: np.ndarray
    kinks: tuple[str, ...]

    @property
    def dimension(self) -> int:
        """Return the number of the group's states."""
        return sum(tangent.dimension for tangent in self.states.values())


@dataclass(frozen=True)
class _Slot:
    """A state or an input: its name, how to set it, its value, in which directions it moves."""

    name: str
    entries: tuple[str, ...]
    put: Callable[[np.ndarray], None]
    value: np.ndarray
    directions: np.ndarray


class _Flat(NamedTuple):
    """A direction in which nothing moves."""

    name: str
    slot: _Slot
    direction: np.ndarray
    column: Column


def block_jacobian(
    isolated: IsolatedBlocks,
    group: Iterable[str],
    inputs: Iterable[Target],
    outputs: Iterable[Source],
    *,
    checked: bool = True,
) -> BlockJacobian:
    """Return the Jacobian of a group of blocks.

    Args:
        isolated: the blocks.
        group: paths of those that belong together.
        inputs: which of their inputs to move.
        outputs: which of their outputs to read.
        checked: whether to see if a tick is such a function, and look for kinks; Newton's method
            need not ask at every step.

    Raises:
        AnalysisError: if one tick of theirs is no function of states and inputs alone.
    """
    cut = _Group(isolated, list(group), list(inputs), list(outputs))
    blocks, names = cut.blocks, ", ".join(cut.blocks)
    for path, block in blocks.items():
        check_timing(path, block)
    with drake_errors(f"{names} cannot be evaluated"):
        following = cut.tick()
        if not np.isfinite(following).all():
            raise AnalysisError(
                f"{names} cannot be linearised: it gives numbers that are not finite"
            )
        if checked:
            check_memory(names, [block.root for block in blocks.values()], cut.moved, cut.tick)
            for path, block in blocks.items():
                check_events(path, block)
        raw, kinks = _differences(cut, following, checked)
    return BlockJacobian(
        group=tuple(blocks),
        states=cut.tangents,
        inputs={target: value.size for target, value in cut.inputs.items()},
        outputs=dict(zip(cut.outputs, map(len, cut.read()), strict=True)),
        matrix=cut.projection(following) @ raw,
        drift=cut.drift(following),
        kinks=tuple(kinks),
    )


class _Group:
    """Blocks cut out together: what moves them, and what one tick makes of it."""

    def __init__(
        self,
        isolated: IsolatedBlocks,
        paths: list[str],
        inputs: list[Target],
        outputs: list[Source],
    ):
        self.wiring, self.outputs = isolated.wiring, outputs
        self.blocks = blocks = {path: isolated.instances[path] for path in paths}
        self.inputs = {target: isolated.inputs[target] for target in inputs}
        self.states = {path: discrete_state(block.context) for path, block in blocks.items()}
        self.tangents = {
            path: tangent_of(blocks[path].system, state.size)
            for path, state in self.states.items()
            if state.size
        }
        self.slots = [*map(self._state, self.tangents), *map(self._input, inputs)]
        # A contact solver curves strongly, and overlooks what is small.
        self.has_solver = any(isinstance(b.system, MultibodyPlant) for b in blocks.values())

    def tick(self) -> np.ndarray:
        """Return next states and outputs as one vector."""
        states = (
            join_groups(block.system.EvalUniquePeriodicDiscreteUpdate(block.context))
            for block in map(self.blocks.__getitem__, self.tangents)
        )
        return np.concatenate([*states, *self.read(), np.zeros(0)])

    def read(self) -> list[np.ndarray]:
        """Return the present outputs."""
        return [
            read_port(self.blocks[path].system.get_output_port(index), self.blocks[path].context)
            for path, index, _ in self.outputs
        ]

    def moved(self, step: float) -> None:
        """Move all that moves at once by a relative step; 0 puts it back."""
        for slot in self.slots:
            slot.put(slot.value + step * slot.directions.sum(axis=1))

    def overlooks(self, following: np.ndarray) -> bool:
        """Return whether a contact solver found its guess, the present velocities, good enough."""
        first = 0
        for path, tangent in self.tangents.items():
            plant = self.blocks[path].system
            if isinstance(plant, MultibodyPlant):
                rates = slice(plant.num_positions(), tangent.size)
                present = discrete_state(self.blocks[path].context)
                return np.array_equal(
                    following[first : first + tangent.size][rates], present[rates]
                )
            first += tangent.size
        return False

    def projection(self, following: np.ndarray) -> np.ndarray:
        """Return what takes changes of `tick` to coordinates of small motions."""
        matrices, first = [], 0
        for tangent in self.tangents.values():
            matrices.append(tangent.project(following[first : first + tangent.size]))
            first += tangent.size
        return block_diag(*matrices, np.eye(following.size - first))

    def drift(self, following: np.ndarray) -> np.ndarray:
        """Return the motion of the states in this tick."""
        motions, first = [np.zeros(0)], 0
        for path, tangent in self.tangents.items():
            after = following[first : first + tangent.size]
            motions.append(tangent.difference(after, self.states[path]))
            first += tangent.size
        return np.concatenate(motions)

    def _state(self, path: str) -> _Slot:
        block, tangent = self.blocks[path], self.tangents[path]
        names = state_names(block.system, tangent.dimension)
        put = partial(set_discrete_state, block.context)
        return _Slot(path, names, put, self.states[path], tangent.lift(self.states[path]))

    def _input(self, target: Target) -> _Slot:
        block, value = self.blocks[target.block], self.inputs[target]
        port = block.system.get_input_port(target.port)
        still = switches(port)
        directions = np.diag(1.0 - still) if still.any() else np.eye(value.size)
        name = f"{target.block}.{port.get_name()}"
        entries = self.wiring.entry_names(self.wiring.feeds[target])
        return _Slot(name, entries, partial(fix_port, port, block.context), value, directions)


def _differences(group: _Group, base: np.ndarray, checked: bool) -> tuple[np.ndarray, list[str]]:
    """Return the derivative of `tick` by all slots, and the names of kinks and quantisers.

    Without looking for these, there are none.
    """
    columns, kinks, flat = [np.zeros((base.size, 0))], [], []
    for slot in group.slots:
        for entry, direction in zip(slot.entries, slot.directions.T, strict=True):
            at = partial(_moved, group, slot, direction)
            column = _column(group, at, base, max(1.0, abs(slot.value @ direction)))
            columns.append((column.ahead - column.behind)[:, None] / (2 * column.step))
            if not checked:
                continue
            if is_flat(column):
                flat.append(_Flat(f"{slot.name}.{entry}", slot, direction, column))
            elif solver_has_kink(column, at) if group.has_solver else has_kink(column, at):
                kinks.append(f"{slot.name}.{entry}")
        slot.put(slot.value)
    return np.hstack(columns), kinks + _quantised(group, flat, base)


def _moved(group: _Group, slot: _Slot, direction: np.ndarray, step: float) -> np.ndarray:
    slot.put(slot.value + step * direction)
    return group.tick()


def _column(
    group: _Group, at: Callable[[float], np.ndarray], base: np.ndarray, size: float
) -> Column:
    """Return where steps of a suitable length to both sides lead."""
    step = size * (CONTACT_STEP if group.has_solver else STEP)
    ahead = at(step)
    while (
        step < 1 and np.abs(ahead - base).max(initial=0.0) < OVERLOOKED and group.overlooks(ahead)
    ):
        step *= 10
        ahead = at(step)
    return Column(step, ahead, base, at(-step))


def _quantised(group: _Group, flat: list[_Flat], base: np.ndarray) -> list[str]:
    """Return the names of those among flat directions in which blocks are quantised."""
    if group.has_solver or not _moves_far_off(group, flat, base):
        return []
    found = []
    for name, slot, direction, column in flat:
        if is_quantised(column, partial(_moved, group, slot, direction)):
            found.append(name)
        slot.put(slot.value)
    return found


def _moves_far_off(group: _Group, flat: list[_Flat], base: np.ndarray) -> bool:
    """Return whether anything moves when all flat directions are far off at once."""
    try:
        for step in (sign * far for far in FAR for sign in (1, -1)):
            for slot in group.slots:
                directions = [d for _, other, d, _ in flat if other is slot]
                slot.put(slot.value + step * np.sum(directions, axis=0))
            if not np.array_equal(group.tick(), base):
                return True
    except (Exception, SystemExit):
        return True  # one after the other may do
    finally:
        group.moved(0.0)
    return False
