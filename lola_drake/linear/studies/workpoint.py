"""A linearised scenario whose parameters can be turned: only what depends on them is done anew."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from lola_drake.linear.interconnection import LinearBlocks
from lola_drake.linear.linear_blocks import is_held, linear_blocks
from lola_drake.linear.studies.operating_points import Situation, quiet, situation
from lola_drake.linear.wiring import Selection, Wiring
from lola_drake.scenario import Scenario, override
from lola_drake.world import build_simulation


@dataclass(frozen=True)
class Workpoint:
    """A scenario at an operating point, block by block.

    Attributes:
        scenario: its parameters.
        at: the operating point, as in `operating_points.situation`.
        situation: that point.
        blocks: linearised there.
        inputs, outputs: the signals that can be used.
    """

    scenario: Scenario
    at: str
    situation: Situation
    blocks: LinearBlocks
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def select(self, names: Iterable[str]) -> list[Selection]:
        """Return the entries of signals by their names."""
        return [self.blocks.wiring.select(name) for name in names]

    def varied(self, changes: Mapping[str, object]) -> "Workpoint":
        """Return the workpoint of the scenario with some parameters changed.

        Args:
            changes: dotted keys of the scenario and their new values.
        """
        scenario = override(self.scenario, changes)
        owners = [self._owners(key) for key in changes]
        if not all(owners) or self.situation.residual is None:
            return make_workpoint(scenario, self.at, self.inputs, self.outputs)
        changed = build_simulation(quiet(scenario))
        blocks = self.blocks.with_blocks(changed, [name for names in owners for name in names])
        return replace(self, scenario=scenario, blocks=blocks)

    def _owners(self, key: str) -> list[str]:
        """Return the blocks that a parameter belongs to; none if more than they depend on it."""
        parent, _, name = key.rpartition(".")
        params: Any = self.scenario
        for part in parent.split(".") if parent else ():
            params = getattr(params, part, None)
        return [
            system.get_name()
            for system in Wiring(self.situation.diagram).blocks.values()
            if (block := getattr(system, "block", None))
            and type(block.params) is type(params)
            and not is_held(system)
            and name not in block.acts_outside
        ]


def make_workpoint(
    scenario: Scenario,
    at: str,
    inputs: Iterable[str] = (),
    outputs: Iterable[str] = (),
    point: Situation | None = None,
) -> Workpoint:
    """Linearise all blocks of a scenario at an operating point.

    Args:
        scenario: its parameters.
        at: the operating point, as in `operating_points.situation`.
        inputs: names of signals to which something will be added.
        outputs: names of signals that will be read.
        point: the operating point itself, if it has been found already.
    """
    point = point or situation(scenario, at)
    wiring = Wiring(point.diagram)
    inputs, outputs = tuple(inputs), tuple(outputs)
    added, read = ([wiring.select(name) for name in names] for names in (inputs, outputs))
    blocks = linear_blocks(point.diagram, point.context, added, read)
    return Workpoint(scenario, at, point, blocks, inputs, outputs)
