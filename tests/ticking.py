"""A block as a system of Drake's, stepped tick by tick, for the tests of single blocks."""

import numpy as np

from lola_drake.block import Block
from lola_drake.block_system import BlockSystem
from lola_drake.signals import PERIOD, Signal


class Ticking:
    """A block in a context of its own; vectors that flow into it are zero until they are fixed."""

    def __init__(self, block: Block):
        self.block = block
        self.system = BlockSystem(block)
        self.context = self.system.CreateDefaultContext()
        self.ticks = 0
        for name, what in block.inputs.items():
            if isinstance(what, Signal):
                self.fix(name, np.zeros(what.size))

    def fix(self, name, value, where=None):
        """Set an input, or some of its entries."""
        port = self.system.GetInputPort(name)
        if where is not None:
            entries, value = value, port.Eval(self.context).copy()
            value[where] = entries
        port.FixValue(self.context, np.array(value, dtype=float))

    def output(self, name):
        return self.system.GetOutputPort(name).Eval(self.context).copy()

    def state(self, name):
        return self.context.get_discrete_state(self._part(name)).value().copy()

    def set_state(self, name, value):
        self.context.SetDiscreteState(self._part(name), np.array(value, dtype=float))

    def step(self, ticks=1):
        for _ in range(ticks):
            updates = self.system.EvalUniquePeriodicDiscreteUpdate(self.context)
            self.context.SetDiscreteState(updates)
            self.ticks += 1
            self.context.SetTime(PERIOD * self.ticks)

    def _part(self, name):
        return list(self.block.states).index(name)
