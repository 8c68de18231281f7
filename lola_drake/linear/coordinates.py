"""All states of a system as coordinates of small motions, in one order."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context

from lola_drake.linear.isolated import discrete_state, own_context, set_discrete_state
from lola_drake.linear.signal_names import state_names, state_scales
from lola_drake.linear.tangent import Tangent, tangent_of
from lola_drake.linear.wiring import Wiring


@dataclass(frozen=True)
class Coordinates:
    """The states of some blocks, one after the other.

    Attributes:
        wiring: all blocks.
        tangents: the coordinates of each block whose state counts, by its path.
    """

    wiring: Wiring
    tangents: dict[str, Tangent]

    @property
    def names(self) -> list[str]:
        """Return the names of all states, in the form `block/entry`."""
        return [
            f"{path}/{name}".replace(".", "/")
            for path, tangent in self.tangents.items()
            for name in state_names(self.wiring.blocks[path], tangent.dimension)
        ]

    @property
    def scales(self) -> np.ndarray:
        """Return what is a lot for every state, see `signal_names.state_scales`."""
        scales = [
            state_scales(self.wiring.blocks[path], tangent.dimension)
            for path, tangent in self.tangents.items()
        ]
        return np.concatenate([np.zeros(0), *scales])

    def move(self, context: Context, motion: np.ndarray) -> None:
        """Move the states of a context of the whole system."""
        first = 0
        for path, tangent in self.tangents.items():
            own = own_context(self.wiring.blocks[path], context)
            part = motion[first : first + tangent.dimension]
            set_discrete_state(own, tangent.move(discrete_state(own), part))
            first += tangent.dimension

    def difference(self, context: Context, base: Context) -> np.ndarray:
        """Return the motion that leads from the states of `base` to those of `context`."""
        motions = [np.zeros(0)]
        for path, tangent in self.tangents.items():
            block = self.wiring.blocks[path]
            after, before = (discrete_state(own_context(block, c)) for c in (context, base))
            motions.append(tangent.difference(after, before))
        return np.concatenate(motions)


def coordinates(wiring: Wiring, context: Context, paths: list[str]) -> Coordinates:
    """Return the coordinates of those of some blocks that have discrete state."""
    tangents = {}
    for path in paths:
        block = wiring.blocks[path]
        size = discrete_state(own_context(block, context)).size
        if size:
            tangents[path] = tangent_of(block, size)
    return Coordinates(wiring, tangents)
