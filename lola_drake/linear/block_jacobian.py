"""One block's exact tick, linearised on its own: by AutoDiff where that is valid, else differences.

Blocks that are tied together by objects that are not vectors (contact results, geometry queries)
are linearised together, as one group.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from scipy.linalg import block_diag

from lola_drake.linear.errors import AnalysisError, drake_errors
from lola_drake.linear.isolated import (
    Instance,
    IsolatedBlocks,
    discrete_state,
    fix_port,
    join_groups,
    read_port,
    set_discrete_state,
)
from lola_drake.linear.plant_autodiff import autodiff_plant
from lola_drake.linear.signal_names import switches
from lola_drake.linear.tangent import Tangent, tangent_of
from lola_drake.linear.wiring import Source, Target

STEP = 6e-6
"""Relative step of central differences: the cube root of the machine's precision."""

CONTACT_STEP = 1e-7
"""The same for a multibody plant: its contact is curved so strongly that less is better."""

NOTICED = 1e-4
"""A change that the contact solver does not overlook: it returns a guess that is good enough."""

AUTODIFF, DIFFERENCES = "AutoDiff", "differences"


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
        method: `AUTODIFF` or `DIFFERENCES`.
    """

    group: tuple[str, ...]
    states: dict[str, Tangent]
    inputs: dict[Target, int]
    outputs: dict[Source, int]
    matrix: np.ndarray
    drift: np.ndarray
    method: str

    @property
    def dimension(self) -> int:
        """Return the number of the group's states."""
        return sum(tangent.dimension for tangent in self.states.values())


@dataclass(frozen=True)
class _Slot:
    """A state or an input: how to set it, its value, and in which directions it moves."""

    put: Callable[[np.ndarray], None]
    value: np.ndarray
    directions: np.ndarray


def block_jacobian(
    isolated: IsolatedBlocks,
    group: Iterable[str],
    inputs: Iterable[Target],
    outputs: Iterable[Source],
    *,
    autodiff: bool = True,
) -> BlockJacobian:
    """Return the Jacobian of a group of blocks.

    Args:
        isolated: the blocks.
        group: paths of those that belong together.
        inputs: which of their inputs to move.
        outputs: which of their outputs to read.
        autodiff: whether AutoDiff may be used where it is valid.
    """
    group = list(group)
    for path in group:
        isolated.check(path)
    group = _Group(
        {path: isolated.instances[path] for path in group},
        {target: isolated.inputs[target] for target in inputs},
        list(outputs),
        {target: value for target, value in isolated.inputs.items() if target.block in group},
    )
    names = ", ".join(path for path in group.blocks)
    with drake_errors(f"{names} cannot be evaluated"):
        following = group.tick()
    raw, method = _raw_jacobian(group, names, autodiff)
    return BlockJacobian(
        group=tuple(group.blocks),
        states=group.tangents,
        inputs={target: value.size for target, value in group.inputs.items()},
        outputs=dict(zip(group.outputs, map(len, group.read()), strict=True)),
        matrix=group.projection(following) @ raw,
        drift=group.drift(following),
        method=method,
    )


class _Group:
    """Blocks cut out together: what moves them, and what one tick makes of it."""

    def __init__(
        self,
        blocks: dict[str, Instance],
        inputs: dict[Target, np.ndarray],
        outputs: list[Source],
        fixed: dict[Target, np.ndarray],
    ):
        self.blocks, self.inputs, self.outputs, self.fixed = blocks, inputs, outputs, fixed
        self.states = {path: discrete_state(block.context) for path, block in blocks.items()}
        self.tangents = {
            path: tangent_of(blocks[path].system, state.size)
            for path, state in self.states.items()
            if state.size
        }

    def tick(self, blocks: dict[str, Instance] | None = None) -> np.ndarray:
        """Return next states and outputs as one vector, of these blocks or converted ones."""
        blocks = blocks or self.blocks
        states = (
            join_groups(blocks[path].system.EvalUniquePeriodicDiscreteUpdate(blocks[path].context))
            for path in self.tangents
        )
        return np.concatenate([*states, *self.read(blocks), np.zeros(0)])

    def read(self, blocks: dict[str, Instance] | None = None) -> list[np.ndarray]:
        """Return the present outputs."""
        blocks = blocks or self.blocks
        return [
            read_port(blocks[path].system.get_output_port(index), blocks[path].context)
            for path, index, _ in self.outputs
        ]

    def slots(self, blocks: dict[str, Instance] | None = None) -> list[_Slot]:
        """Return what moves, in the order of the Jacobian's columns."""
        blocks = blocks or self.blocks
        slots = [
            _Slot(
                partial(set_discrete_state, blocks[path].context),
                self.states[path],
                tangent.lift(self.states[path]),
            )
            for path, tangent in self.tangents.items()
        ]
        for target, value in self.inputs.items():
            port = blocks[target.block].system.get_input_port(target.index)
            still = switches(self.blocks[target.block].system.get_input_port(target.index))
            directions = np.diag(1.0 - still) if still.any() else np.eye(value.size)
            put = partial(fix_port, port, blocks[target.block].context)
            slots.append(_Slot(put, value, directions))
        return slots

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
            motions.append(
                tangent.difference(following[first : first + tangent.size], self.states[path])
            )
            first += tangent.size
        return np.concatenate(motions)

    @property
    def has_solver(self) -> bool:
        """Return whether a contact solver is among the blocks."""
        return any(isinstance(block.system, MultibodyPlant) for block in self.blocks.values())

    @property
    def step(self) -> float:
        """Return the relative step of central differences that suits these blocks."""
        return CONTACT_STEP if self.has_solver else STEP


def _raw_jacobian(group: _Group, names: str, autodiff: bool) -> tuple[np.ndarray, str]:
    """Return the derivative of `tick` by all slots, and how it was found."""
    if autodiff:
        try:
            with drake_errors(names):
                converted = _converted(group)
                if converted:
                    return _by_autodiff(group, converted), AUTODIFF
        except AnalysisError:
            # That a block can be converted is no promise that all of it differentiates.
            pass
    with drake_errors(f"{names} cannot be evaluated"):
        return _by_differences(group), DIFFERENCES


def _by_differences(group: _Group) -> np.ndarray:
    columns, base = [], group.tick()
    for slot in group.slots():
        for direction in slot.directions.T:
            step = group.step * max(1.0, abs(slot.value @ direction))
            slot.put(slot.value + step * direction)
            ahead = group.tick()
            while group.has_solver and step < 1 and np.abs(ahead - base).max() < NOTICED:
                step *= 10
                slot.put(slot.value + step * direction)
                ahead = group.tick()
            slot.put(slot.value - step * direction)
            columns.append((ahead - group.tick()) / (2 * step))
        slot.put(slot.value)
    return np.column_stack(columns) if columns else np.zeros((base.size, 0))


def _by_autodiff(group: _Group, converted: dict[str, Instance]) -> np.ndarray:
    for target, value in group.fixed.items():
        constant = InitializeAutoDiff(value[:, None], np.zeros((value.size, 0)))[:, 0]
        block = converted[target.block]
        fix_port(block.system.get_input_port(target.index), block.context, constant)
    slots = group.slots(converted)
    total = sum(slot.directions.shape[1] for slot in slots)
    first = 0
    for slot in slots:
        gradient = np.zeros((slot.value.size, total))
        gradient[:, first : first + slot.directions.shape[1]] = slot.directions
        slot.put(InitializeAutoDiff(slot.value[:, None], gradient)[:, 0])
        first += slot.directions.shape[1]
    # A row that depends on nothing has no derivatives of its own.
    result = group.tick(converted) + AutoDiffXd(0.0, np.zeros(total))
    return ExtractGradient(result[:, None])


def _converted(group: _Group) -> dict[str, Instance] | None:
    """Return the group over AutoDiffXd; None if it is not a single block that can be converted."""
    geometry = [b for b in group.blocks.values() if isinstance(b.system, SceneGraph)]
    others = {path: b for path, b in group.blocks.items() if b not in geometry}
    if len(others) != 1 or len(geometry) > 1:
        return None
    ((path, block),) = others.items()
    if isinstance(block.system, MultibodyPlant):
        return {path: autodiff_plant(block, *(geometry or [None]))}
    system = block.system.ToAutoDiffXdMaybe()
    if system is None:
        return None
    context = system.CreateDefaultContext()
    context.SetTimeStateAndParametersFrom(block.context)
    return {path: Instance(system, context)}
