"""The Jacobians of all blocks at one operating point, and their interconnection."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import System
from scipy.linalg import block_diag

from lola_drake.linear.block_jacobian import BlockJacobian, block_jacobian
from lola_drake.linear.coordinates import Coordinates
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import IsolatedBlocks
from lola_drake.linear.wiring import Selection, Source, Target, Wiring


@dataclass(frozen=True)
class StateSelection:
    """One state, as an output.

    Attributes:
        index: its position among all states.
        labels: its name.
    """

    index: int
    labels: tuple[str, ...]

    @property
    def labels_with_units(self) -> list[str]:
        """Return the labels; no unit of a state is known."""
        return list(self.labels)


@dataclass(frozen=True)
class Matrices:
    """A linear system x+ = A x + B u, y = C x + D u."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


@dataclass(frozen=True)
class LinearBlocks:
    """Every moving block's Jacobian.

    Attributes:
        isolated: all blocks, at the operating point.
        jacobians: of the groups of blocks that move.
        held: paths of the blocks that are held.
        period: of all blocks (s), None if none has state.
    """

    isolated: IsolatedBlocks
    jacobians: tuple[BlockJacobian, ...]
    held: tuple[str, ...]
    period: float | None

    @property
    def wiring(self) -> Wiring:
        """Return all blocks and their connections."""
        return self.isolated.wiring

    @property
    def coordinates(self) -> Coordinates:
        """Return the order of all states."""
        return Coordinates(self.wiring, {p: t for j in self.jacobians for p, t in j.states.items()})

    @property
    def state_names(self) -> list[str]:
        """Return the names of all states, in the form `block/entry`."""
        return self.coordinates.names

    @property
    def drift(self) -> np.ndarray:
        """Return by how much every state moves in this tick (SI units)."""
        return np.concatenate([np.zeros(0), *(jacobian.drift for jacobian in self.jacobians)])

    @property
    def relative_drift(self) -> np.ndarray:
        """Return the drift, relative to what is a lot for each state."""
        return self.drift / self.coordinates.scales

    @property
    def kinks(self) -> tuple[str, ...]:
        """Return the states and inputs at which the two sides have different slopes."""
        return tuple(kink for jacobian in self.jacobians for kink in jacobian.kinks)

    def check_equilibrium(self, allowed: float) -> None:
        """Raise AnalysisError if a state moves in this tick by more than a part of its scale."""
        relative = np.abs(self.relative_drift)
        if relative.max(initial=0.0) > allowed:
            worst = int(relative.argmax())
            raise AnalysisError(
                f"not an equilibrium: {self.state_names[worst]} drifts by "
                f"{self.drift[worst]:.1e} in one tick"
            )

    def select(self, name: str) -> Selection | StateSelection:
        """Return what a name means as an output: entries of a signal, or else a state."""
        try:
            return self.wiring.select(name)
        except AnalysisError:
            label = name.replace(".", "/")
            ends = [i for i, n in enumerate(self.state_names) if f"/{n}".endswith(f"/{label}")]
            if len(ends) != 1:
                raise
            return StateSelection(ends[0], (label,))

    def with_blocks(self, changed: System, names: Iterable[str]) -> "LinearBlocks":
        """Return the same, with some blocks as they are in a system with other parameters.

        Args:
            changed: has the same blocks in the same places.
            names: of the blocks to take from it, the last parts of their paths.
        """
        names = set(names)
        paths = {path for path in self.wiring.blocks if path.split(".")[-1] in names}
        isolated = self.isolated.with_blocks(changed, paths)
        jacobians = tuple(
            block_jacobian(isolated, j.group, j.inputs, j.outputs) if paths & set(j.group) else j
            for j in self.jacobians
        )
        return replace(self, isolated=isolated, jacobians=jacobians)

    def interconnect(
        self,
        inputs: Sequence[Selection],
        outputs: Sequence[Selection | StateSelection],
        opened: Sequence[Selection] = (),
    ) -> Matrices:
        """Return the system of all blocks together.

        Args:
            inputs: entries of signals to which something is added on the way to their readers.
            outputs: entries of signals as their readers see them, or states.
            opened: entries of signals that are cut: readers get nothing of them but an input
                there, and an output there is what the source gives.
        """
        blocks, layout = self._stacked(), _Layout(self.jacobians)
        feed = self._feed(layout, opened)
        inject = self._injection(layout, inputs)
        # Signals as their sources give them: y = C x + D (feed y + inject w).
        loop = np.linalg.inv(np.eye(len(blocks.D)) - blocks.D @ feed)
        C, D = loop @ blocks.C, loop @ blocks.D @ inject
        A, B = blocks.A + blocks.B @ feed @ C, blocks.B @ (feed @ D + inject)
        pick_x, pick_y, through = self._reading(layout, inputs, outputs, opened)
        return Matrices(A, B, pick_x + pick_y @ C, pick_y @ D + through)

    def _stacked(self) -> Matrices:
        """Return all blocks beside each other, not yet connected."""
        parts = [(np.zeros((0, 0)),) * 4]
        for jacobian in self.jacobians:
            n = jacobian.dimension
            m = jacobian.matrix
            parts.append((m[:n, :n], m[:n, n:], m[n:, :n], m[n:, n:]))
        return Matrices(*(block_diag(*matrices) for matrices in zip(*parts, strict=True)))

    def _feed(self, layout: "_Layout", opened: Sequence[Selection]) -> np.ndarray:
        """Return which output reaches which input, shape (inputs, outputs)."""
        feed = np.zeros((layout.n_inputs, layout.n_outputs))
        for target, where in layout.inputs.items():
            source = self.wiring.feeds[target]
            if source in layout.outputs:
                feed[where, layout.outputs[source]] = 1.0
        for selection in opened:
            feed[:, self._output(layout, selection)] = 0.0
        return feed

    def _injection(self, layout: "_Layout", inputs: Sequence[Selection]) -> np.ndarray:
        """Return where the inputs enter, shape (inputs of blocks, inputs)."""
        columns = []
        for selection in inputs:
            targets = [t for t in self.wiring.targets(selection.source) if t in layout.inputs]
            if not targets:
                raise AnalysisError(f"nothing that moves reads {selection.labels[0]}")
            for entry in selection.entries:
                column = np.zeros(layout.n_inputs)
                column[[layout.inputs[target][entry] for target in targets]] = 1.0
                columns.append(column)
        return np.column_stack([np.zeros((layout.n_inputs, 0)), *columns])

    def _reading(
        self,
        layout: "_Layout",
        inputs: Sequence[Selection],
        outputs: Sequence[Selection | StateSelection],
        opened: Sequence[Selection],
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what takes states, sources' outputs and inputs to the wanted outputs."""
        added = [(s.source, entry) for s in inputs for entry in s.entries]
        cut = {(s.source, entry) for s in opened for entry in s.entries}
        n = sum(len(selection.labels) for selection in outputs)
        pick_x, pick_y = np.zeros((n, layout.n_states)), np.zeros((n, layout.n_outputs))
        through = np.zeros((n, len(added)))
        row = 0
        for selection in outputs:
            if isinstance(selection, StateSelection):
                pick_x[row, selection.index] = 1.0
                row += 1
                continue
            for entry, column in zip(
                selection.entries, self._output(layout, selection), strict=True
            ):
                pick_y[row, column] = 1.0
                signal = (selection.source, entry)
                if signal not in cut:
                    through[row] = [other == signal for other in added]
                row += 1
        return pick_x, pick_y, through

    def _output(self, layout: "_Layout", selection: Selection) -> np.ndarray:
        """Return the positions of selected entries among the outputs of all blocks."""
        if selection.source not in layout.outputs:
            owner = selection.source.block
            why = f"{owner} is held" if owner in self.held else "it comes from outside"
            raise AnalysisError(f"{selection.labels[0]} does not move: {why}")
        return layout.outputs[selection.source][selection.entries]


class _Layout:
    """Where the states, inputs and outputs of each block lie when all are stacked."""

    def __init__(self, jacobians: Iterable[BlockJacobian]):
        self.inputs: dict[Target, np.ndarray] = {}
        self.outputs: dict[Source, np.ndarray] = {}
        self.n_states = self.n_inputs = self.n_outputs = 0
        for jacobian in jacobians:
            self.n_states += jacobian.dimension
            for target, size in jacobian.inputs.items():
                self.inputs[target] = np.arange(self.n_inputs, self.n_inputs + size)
                self.n_inputs += size
            for source, size in jacobian.outputs.items():
                self.outputs[source] = np.arange(self.n_outputs, self.n_outputs + size)
                self.n_outputs += size
