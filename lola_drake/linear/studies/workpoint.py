"""A linearised scenario whose parameters can be turned: only what depends on them is done anew."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from lola_drake.linear.interconnection import LinearBlocks
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.linear.studies.operating_points import Situation, quiet, situation
from lola_drake.linear.wiring import Selection, Wiring
from lola_drake.scenario import Scenario, override
from lola_drake.signals import FEET
from lola_drake.simulation import build_simulation

_BLOCKS = {
    "control.stabilizer.": ("imu_stabilizer",),
    "control.distribution.": ("force_distribution",),
    "control.force.": tuple(f"force_control_{foot}" for foot in FEET),
    "control.com_dynamics.": tuple(f"com_dynamics_{foot}" for foot in FEET),
    "control.inverse_kinematics.": ("inverse_kinematics",),
    "control.servos.delay_ticks": ("joint_servos",),
    "sensors.imu.": ("imu",),
    "sensors.foot_force.": ("foot_force_sensor",),
}
"""Which blocks a parameter belongs to, where it has no part in the equilibrium."""


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
        return [self.blocks.select(name) for name in names]

    def varied(self, changes: Mapping[str, object]) -> "Workpoint":
        """Return the workpoint of the scenario with some parameters changed.

        Args:
            changes: dotted keys of the scenario and their new values.
        """
        scenario = override(self.scenario, changes)
        names = [_blocks_of(key) for key in changes]
        if None in names or self.situation.residual is None:
            return make_workpoint(scenario, self.at, self.inputs, self.outputs)
        changed = build_simulation(quiet(scenario))
        blocks = self.blocks.with_blocks(changed, [name for group in names for name in group])
        return replace(self, scenario=scenario, blocks=blocks)


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


def _blocks_of(key: str) -> tuple[str, ...] | None:
    return next((names for start, names in _BLOCKS.items() if key.startswith(start)), None)
