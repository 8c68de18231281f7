"""A simulation under way, whichever engine runs it: its time, signals, gains and record."""

from collections.abc import Iterator
from dataclasses import Field as DataclassField
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, System

from lola_drake.block import Block
from lola_drake.block_system import gain_of, set_gain
from lola_drake.fused import FusedSystem
from lola_drake.logged import LOGGED
from lola_drake.plant import has_fallen, plant_truth
from lola_drake.results import Result
from lola_drake.scenario import Scenario
from lola_drake.signals import PERIOD, on_tick, split_foot


class Gain(NamedTuple):
    """A gain that may be turned while it runs, of one block or of those of both feet.

    Attributes:
        block: name of the block, without its foot.
        name: of the parameter.
        field: its declaration, with symbol, unit and slider.
    """

    block: str
    name: str
    field: DataclassField


class Run:
    """A scenario as it runs.

    Attributes:
        scenario: what is run.
        diagram: Drake's, of blocks or with the fused system.
        simulator, context: of the diagram.
        plant: in it.
    """

    def __init__(self, scenario: Scenario, diagram: Diagram):
        """Start a diagram that `simulation` has built."""
        self.scenario, self.diagram = scenario, diagram
        self.simulator = Simulator(diagram)
        self.context = self.simulator.get_mutable_context()
        self.plant: MultibodyPlant = diagram.GetSubsystemByName("plant")
        self.simulator.Initialize()

    @property
    def time(self) -> float:
        """Return the simulated time (s)."""
        return self.context.get_time()

    @property
    def fallen(self) -> bool:
        """Return whether the robot has fallen."""
        return has_fallen(self.plant.GetPositions(self.plant.GetMyContextFromRoot(self.context)))

    def advance(self, until: float) -> None:
        """Simulate until the tick nearest to a time (s)."""
        self.simulator.AdvanceTo(on_tick(until))

    @cached_property
    def fused(self) -> FusedSystem | None:
        """Return the fused system; None where blocks run one by one."""
        if self.diagram.HasSubsystemNamed("fused"):
            return self.diagram.GetSubsystemByName("fused")
        return None

    @cached_property
    def blocks(self) -> dict[str, Block]:
        """Return the blocks that are declared, by name."""
        if self.fused:
            return self.fused.layout.blocks
        return {n: s.block for n, s in self._systems.items() if hasattr(s, "block")}

    @cached_property
    def _systems(self) -> dict[str, System]:
        controller = self.diagram.GetSubsystemByName("controller")
        return {s.get_name(): s for d in (self.diagram, controller) for s in d.GetSystems()}

    def signal(self, name: str) -> np.ndarray:
        """Return a signal between the blocks as it is in this tick."""
        if self.fused:
            row = self.fused.GetOutputPort("tick").Eval(
                self.fused.GetMyContextFromRoot(self.context)
            )
            return row[self.fused.layout.signals[name]]
        for system in self._systems.values():
            if system.HasOutputPort(name):
                return system.GetOutputPort(name).Eval(system.GetMyContextFromRoot(self.context))
        raise KeyError(name)

    def gains(self) -> Iterator[Gain]:
        """Yield the gains of all blocks, those of both feet once."""
        seen = set()
        for name, block in self.blocks.items():
            for gain, field in block.gains.items():
                found = Gain(split_foot(name)[0], gain, field)
                if found[:2] not in seen:
                    seen.add(found[:2])
                    yield found

    def gain(self, gain: Gain) -> float:
        """Return a gain as it is now."""
        block = next(self._having(gain))
        if self.fused:
            parameter = self.fused.GetMyContextFromRoot(self.context).get_numeric_parameter(0)
            return float(parameter[self.fused.layout.gain_index(block, gain.name)])
        return gain_of(self._systems[block], self.context, gain.name)

    def set_gain(self, gain: Gain, value: float) -> None:
        """Turn a gain, in the blocks of both feet; it acts in the next tick."""
        for block in self._having(gain):
            if self.fused:
                context = self.fused.GetMyMutableContextFromRoot(self.context)
                index = self.fused.layout.gain_index(block, gain.name)
                context.get_mutable_numeric_parameter(0).SetAtIndex(index, value)
            else:
                set_gain(self._systems[block], self.context, gain.name, value)

    def _having(self, gain: Gain) -> Iterator[str]:
        return (
            name
            for name, block in self.blocks.items()
            if split_foot(name)[0] == gain.block and gain.name in block.gains
        )

    def result(self, wall_time: float) -> Result:
        """Return what was recorded until now, with the time it took (s)."""
        # The log's sample of this moment, which AdvanceTo leaves to what comes after it.
        self.simulator.AdvancePendingEvents()
        log = self.diagram.GetSubsystemByName("log").FindLog(self.context)
        times, data = log.sample_times().copy(), log.data().T
        signals = {name: data[:, at].copy() for name, at in self._columns().items()}
        signals |= plant_truth(self.plant, signals.pop("plant_state"))
        fell = self.fallen
        return Result(
            scenario=self.scenario,
            times=times,
            signals=signals,
            completed=not fell and times[-1] >= self.scenario.duration - 0.5 * PERIOD,
            fall_time=float(times[-1]) if fell else None,
            wall_time=wall_time,
        )

    def _columns(self) -> dict[str, slice]:
        """Return where each signal is in the log."""
        if self.fused:
            layout = self.fused.layout
            first, total = layout.visible.start, layout.visible.stop - layout.visible.start
            columns = {
                name: slice(at.start - first, at.stop - first)
                for name, at in layout.signals.items()
                if name in LOGGED or name == "plant_state"
            }
            return columns | {"joint_torque": slice(total, total + LOGGED["joint_torque"].size)}
        from lola_drake.simulation import log_ports

        named = ("imu", "foot_force_sensor", "contact_switches")
        parts = [
            self.diagram.GetSubsystemByName(n) for n in ("controller", "plant", "walk_command")
        ]
        sensors = [self.diagram.GetSubsystemByName(name) for name in named]
        columns, first = {}, 0
        for name, port in log_ports(*parts, *sensors):
            columns[name] = slice(first, first + port.size())
            first += port.size()
        return columns
