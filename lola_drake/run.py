"""A simulation under way, whichever engine runs it: its time, signals, gains and record."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field as DataclassField
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.primitives import ConstantVectorSource

from lola_drake.atomic_file import reason
from lola_drake.block import Block
from lola_drake.block_system import gain_of, set_gain
from lola_drake.errors import OutputError
from lola_drake.fused import FusedSystem
from lola_drake.logged import LOGGED
from lola_drake.plant import has_fallen, plant_truth
from lola_drake.record import ROWS, Recorder
from lola_drake.results import Result
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario
from lola_drake.servos import OVERLOADED
from lola_drake.signals import PERIOD, PLANT_STATE, on_tick, split_foot
from lola_drake.world import log_ports


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

    def __repr__(self):
        unit = self.field.metadata.get("unit") or "-"
        return f"<Gain {self.block}.{self.name} ({unit})>"


class _Snapshot(NamedTuple):
    """The moment before some ticks: the time (s), and the states of plant and fused system."""

    time: float
    states: list[np.ndarray]


class Run:
    """A scenario as it runs.

    Attributes:
        scenario: what is run.
        diagram: Drake's, of blocks or with the fused system.
        simulator, context: of the diagram.
        plant: in it.
        fused: the fused system in it; None where blocks run one by one.
        look_back: what stays in memory of a run that is written to the disk (s), for `recent`.
    """

    def __init__(
        self, scenario: Scenario, diagram: Diagram, limited: Callable[[], Diagram] | None = None
    ):
        """Start a diagram that `simulation` has built.

        Args:
            scenario: what is run.
            diagram: of it.
            limited: gives the same diagram with servos that keep their limits of torque, to go on
                with from where a drive would reach one.
        """
        self.scenario = scenario
        self._limited = limited
        self._earlier: list[tuple[np.ndarray, np.ndarray]] = []
        self._written = -PERIOD
        self.look_back = 0.0
        self._begin(diagram)
        self.simulator.Initialize()

    def __repr__(self):
        scenario, engine = self.scenario, "fused" if self.fused else "diagram"
        return f"<Run of {scenario.name} ({scenario.variant}): at {self.time:.3f} s, {engine}>"

    def _begin(self, diagram: Diagram) -> None:
        self.diagram = diagram
        self.simulator = Simulator(diagram)
        self.context = self.simulator.get_mutable_context()
        self.plant: MultibodyPlant = diagram.GetSubsystemByName("plant")
        is_fused = diagram.HasSubsystemNamed("fused")
        self.fused: FusedSystem | None = diagram.GetSubsystemByName("fused") if is_fused else None

    @property
    def time(self) -> float:
        """Return the simulated time (s)."""
        return self.context.get_time()

    @property
    def fallen(self) -> bool:
        """Return whether the robot has fallen.

        Raises:
            FloatingPointError: if the plant's state is no number any more.
        """
        positions = self.plant_state[: PLANT_STATE.slice("q").stop]
        if not np.isfinite(positions).all():
            raise FloatingPointError("the state of the plant is no number any more")
        return has_fallen(positions)

    def advance(self, until: float) -> None:
        """Simulate until the tick nearest to a time (s)."""
        limited = self._limited
        if limited is None:
            self.simulator.AdvanceTo(on_tick(until))
            return
        before = self._snapshot()
        self.simulator.AdvanceTo(on_tick(until))
        if self.state("drive_guard", OVERLOADED.name).item() > 0:
            self._go_on(before, limited())
            self.simulator.AdvanceTo(on_tick(until))

    def _moving_contexts(self) -> list[Context]:
        """Return the contexts of plant and fused system."""
        return [
            self.diagram.GetSubsystemByName(name).GetMyMutableContextFromRoot(self.context)
            for name in ("plant", "fused")
        ]

    def _snapshot(self) -> _Snapshot:
        contexts = self._moving_contexts()
        states = [context.get_discrete_state_vector().CopyToVector() for context in contexts]
        return _Snapshot(self.time, states)

    def _go_on(self, before: _Snapshot, limited: Diagram) -> None:
        """Go back to a moment, and from there on with servos that keep their limits."""
        times, data = self._recorded()
        kept = times < before.time - 0.5 * PERIOD
        self._earlier = [(times[kept], data[kept])]
        old = self.diagram, self.context
        self._begin(limited)
        self._limited = None
        self.context.SetTime(before.time)
        for context, state in zip(self._moving_contexts(), before.states, strict=True):
            context.SetDiscreteState(state)
        self._take_over(*old)
        self.simulator.Initialize()

    def _take_over(self, diagram: Diagram, context: Context) -> None:
        """Take over what was turned or pushed from outside in a run until now."""
        gains = diagram.GetSubsystemByName("fused").GetMyContextFromRoot(context)
        _, mine = self._moving_contexts()
        mine.get_mutable_numeric_parameter(0).SetFromVector(
            gains.get_numeric_parameter(0).CopyToVector()
        )
        source = diagram.GetSubsystemByName("walk_command")
        if isinstance(source, ConstantVectorSource):
            self.command(source.get_source_value(source.GetMyContextFromRoot(context)).value())
        plant = diagram.GetSubsystemByName("plant")
        pushed, inside = (
            plant.get_applied_spatial_force_input_port(),
            plant.GetMyContextFromRoot(context),
        )
        if pushed.HasValue(inside) and not self.scenario.pushes:
            self.plant.get_applied_spatial_force_input_port().FixValue(
                self.plant.GetMyMutableContextFromRoot(self.context), pushed.Eval(inside)
            )

    @cached_property
    def _robot(self) -> MultibodyPlant:
        """Return the robot alone, which says where its parts are."""
        return Kinematics().plant

    @cached_property
    def blocks(self) -> dict[str, Block]:
        """Return the blocks that are declared, by name."""
        if self.fused:
            return self.fused.layout.blocks
        return {n: s.block for n, s in self.systems.items() if hasattr(s, "block")}

    @cached_property
    def systems(self) -> dict[str, Any]:
        """Return the systems of sensors and controller, by name, where they run one by one."""
        controller = self.diagram.GetSubsystemByName("controller")
        return {s.get_name(): s for d in (self.diagram, controller) for s in d.GetSystems()}

    def signal(self, name: str) -> np.ndarray:
        """Return a signal between the blocks as it is in this tick."""
        if self.fused:
            row = self.fused.GetOutputPort("tick").Eval(
                self.fused.GetMyContextFromRoot(self.context)
            )
            return row[self.fused.layout.signals[name]]
        for system in self.systems.values():
            if system.HasOutputPort(name):
                return system.GetOutputPort(name).Eval(system.GetMyContextFromRoot(self.context))
        raise KeyError(name)

    @property
    def plant_state(self) -> np.ndarray:
        """Return the plant's positions and velocities, shape (61,)."""
        context = self.plant.GetMyContextFromRoot(self.context)
        return self.plant.get_state_output_port().Eval(context)

    def state(self, block: str, part: str) -> np.ndarray:
        """Return a part of a block's state."""
        if self.fused:
            state = self.fused.GetMyContextFromRoot(self.context).get_discrete_state_vector()
            return state.value()[self.fused.layout.state[block, part]]
        system = self.systems[block]
        context = system.GetMyContextFromRoot(self.context)
        return context.get_discrete_state(list(system.block.states).index(part)).value()

    def command(self, velocity: np.ndarray) -> None:
        """Ask for v_x, v_y (m/s) and a turn rate (rad/s) from now on.

        Only where the scenario has no commands of its own.
        """
        source = self.diagram.GetSubsystemByName("walk_command")
        context = source.GetMyMutableContextFromRoot(self.context)
        source.get_mutable_source_value(context).SetFromVector(velocity)

    def forget(self, kept: int) -> None:
        """Drop what was recorded but at least the last samples, so many."""
        log = self.diagram.GetSubsystemByName("log").FindMutableLog(self.context)
        first = log.num_samples() - kept
        if first > 0:
            self._earlier = [(log.sample_times()[first:].copy(), log.data().T[first:].copy())]
            log.Clear()

    def write(self, recorder: Recorder) -> None:
        """Move what was recorded to the disk, as soon as it fills whole seconds.

        Raises:
            OutputError: If there is no room for it.
        """
        if self.time < self._written + (ROWS + 1) * PERIOD:
            return
        times, data = self._recorded(self._written + 0.5 * PERIOD)
        # A sample of this moment may be taken once more, see `_go_on`.
        count = int(np.sum(times < self.time - 0.5 * PERIOD)) // ROWS * ROWS
        if not count:
            return
        self._append(recorder, times[:count], data[:count])
        self._written = float(times[count - 1])
        self.forget(max(len(times) - count, round(self.look_back / PERIOD)))

    def _append(self, recorder: Recorder, times: np.ndarray, data: np.ndarray) -> None:
        try:
            recorder.append(times, self._signals(data))
        except (OSError, RuntimeError) as error:
            raise OutputError(f"the record cannot be written, {reason(error)}") from None

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
        return gain_of(self.systems[block], self.context, gain.name)

    def set_gain(self, gain: Gain, value: float) -> None:
        """Turn a gain, in the blocks of both feet; it acts in the next tick."""
        for block in self._having(gain):
            if self.fused:
                context = self.fused.GetMyMutableContextFromRoot(self.context)
                index = self.fused.layout.gain_index(block, gain.name)
                context.get_mutable_numeric_parameter(0).SetAtIndex(index, value)
            else:
                set_gain(self.systems[block], self.context, gain.name, value)

    def _having(self, gain: Gain) -> Iterator[str]:
        return (
            name
            for name, block in self.blocks.items()
            if split_foot(name)[0] == gain.block and gain.name in block.gains
        )

    def finish(self) -> None:
        """Record this moment, too, which `advance` leaves to what comes after it."""
        self.simulator.AdvancePendingEvents()

    def recent(self, duration: float) -> Result:
        """Return the record of the last seconds; its time begins with 0."""
        times, data = self._recorded(self.time - duration)
        times = times - times[:1].sum()
        scenario = replace(self.scenario, duration=max(times.max(initial=0.0), PERIOD))
        fall_time = float(times[-1]) if self.fallen else None
        return Result(scenario, times, self._signals(data), not self.fallen, fall_time, 0.0)

    def result(
        self, wall_time: float, error: str | None = None, recorder: Recorder | None = None
    ) -> Result:
        """Return what was recorded until now.

        Args:
            wall_time: that it took (s).
            error: what ended the run, if anything did.
            recorder: has what is on the disk already, and gets the rest.
        """
        times, data = self._recorded(self._written + 0.5 * PERIOD)
        if error is not None:
            # The last samples may be what made it fail.
            broken = np.flatnonzero(~np.isfinite(data).all(axis=1))
            times, data = times[: min(broken, default=None)], data[: min(broken, default=None)]
        signals: Mapping[str, np.ndarray]
        if recorder is None:
            signals = self._signals(data)
        else:
            try:
                self._append(recorder, times, data)
            except OutputError as full:
                error = error or str(full)
            times, signals = recorder.finished()
        fell = error is None and self.fallen
        at_end = len(times) > 0 and times[-1] >= self.scenario.duration - 0.5 * PERIOD
        return Result(
            scenario=self.scenario,
            times=times,
            signals=signals,
            completed=not (fell or error) and at_end,
            fall_time=float(times[-1]) if fell else None,
            wall_time=wall_time,
            error=error,
            engine="fused" if self.fused else "diagram",
        )

    def _recorded(self, since: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (s) and rows of the log from a time until now."""
        log = self.diagram.GetSubsystemByName("log").FindLog(self.context)
        parts = [*self._earlier, (log.sample_times(), log.data().T)]
        parts = [(t[first:], d[first:]) for t, d in parts for first in [np.searchsorted(t, since)]]
        times, rows = zip(*parts, strict=True)
        return np.concatenate(times), np.concatenate(rows)

    def _signals(self, data: np.ndarray) -> dict[str, np.ndarray]:
        """Return what rows of the log say, by the names of the signals."""
        signals = {name: data[:, at].copy() for name, at in self._columns().items()}
        return signals | plant_truth(self._robot, signals.pop(PLANT_STATE.name))

    def _columns(self) -> dict[str, slice]:
        """Return where each signal is in the log."""
        if self.fused:
            layout = self.fused.layout
            first = layout.visible.start
            return {
                name: slice(at.start - first, at.stop - first)
                for name, at in layout.signals.items()
                if name in LOGGED or name == PLANT_STATE.name
            }
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
