"""The nonlinear loop, tick by tick: from any context, with something added to a signal.

This is what a linear model is a model of. Each tick is the diagram's one discrete update; nothing
is published, so logs stay empty.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import Context, System

from lola_drake.linear.errors import AnalysisError, drake_errors
from lola_drake.linear.isolated import fix_port, own_context, read_port
from lola_drake.linear.wiring import Selection, Source, Wiring


class TickLoop:
    """A copy of a context that advances by whole ticks.

    Attributes:
        context: the copy, at the time of the next tick.
        period: of the ticks (s).
    """

    def __init__(self, system: System, context: Context):
        """Start from a context, which stays as it is."""
        self._system, self._wiring = system, Wiring(system)
        with drake_errors("the system cannot tick"):
            self.context = context.Clone()
            timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
        if timing is None:
            raise AnalysisError("the system has no single periodic discrete update")
        self.period, self._start, self._done = timing.period_sec(), context.get_time(), 0
        self._given: dict[Source, np.ndarray] = {}
        self._contexts = {
            path: own_context(block, self.context) for path, block in self._wiring.blocks.items()
        }

    def advance(self) -> None:
        """Make one tick."""
        following = self._system.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(following)
        self._done += 1
        self.context.SetTime(self._start + self._done * self.period)

    def run(
        self,
        outputs: Sequence[str],
        count: int,
        signal: str | None = None,
        added: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return signals over a number of ticks, shape (count, entries).

        Args:
            outputs: names of signals, as in `linearize`; what their readers see.
            count: number of ticks.
            signal: to which something is added on the way to its readers.
            added: what is added in each tick, shape (count, entries of the signal).
        """
        chosen = [self._wiring.select(name) for name in outputs]
        disturbed = self._wiring.select(signal) if signal else None
        added = np.zeros((count, 0)) if added is None else added
        record = np.empty((count, sum(len(selection.labels) for selection in chosen)))
        with drake_errors("the system cannot tick"):
            for k in range(count):
                if disturbed:
                    self._disturb(disturbed, added[k])
                row = [self._read(s, disturbed, added[k] if disturbed else None) for s in chosen]
                record[k] = np.concatenate(row)
                self.advance()
        return record

    def _disturb(self, selection: Selection, added: np.ndarray) -> None:
        """Give the readers of a signal what its source says in this tick, and something more."""
        value = self._source(selection)
        value[selection.entries] += added
        for target in self._wiring.targets(selection.source):
            port = self._wiring.blocks[target.block].get_input_port(target.port)
            fix_port(port, self._contexts[target.block], value)

    def _read(self, selection: Selection, disturbed: Selection | None, added) -> np.ndarray:
        value = self._source(selection)
        if disturbed and selection.source == disturbed.source:
            value[disturbed.entries] += added
        return value[selection.entries]

    def _source(self, selection: Selection) -> np.ndarray:
        """Return what the source of a signal says; zero where there is none."""
        source, port = selection.source, self._wiring.port(selection.source)
        if not source.is_input:
            return read_port(port, self._contexts[source.block])
        if source not in self._given:
            target = self._wiring.targets(source)[0]
            inner = self._wiring.blocks[target.block].get_input_port(target.port)
            own = self._contexts[target.block]
            has_value = inner.HasValue(own)
            self._given[source] = read_port(inner, own) if has_value else np.zeros(inner.size())
        return self._given[source].copy()
