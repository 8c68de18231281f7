"""The closed loop: plant, sensors, controller and logs, and `simulate()`."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Multiplexer,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import PiecewisePolynomial

from lola_drake.atomic_file import reason
from lola_drake.blocks.contact_switches import ContactSwitches
from lola_drake.blocks.foot_force_sensor import FootForceSensor
from lola_drake.blocks.imu import Imu
from lola_drake.blocks.joint_servos import set_servo_gains
from lola_drake.controller import WalkingController
from lola_drake.interruption import interruption
from lola_drake.logged import LOGGED
from lola_drake.plant import add_plant, has_fallen, pad_geometries, plant_truth, set_start
from lola_drake.results import Result
from lola_drake.scenario import Scenario, ScenarioError, Walk, as_scenario
from lola_drake.signals import PERIOD, on_tick
from lola_drake.theory.constants import GRAVITY


def build_simulation(scenario: Scenario | str | Path) -> Diagram:
    """Return the closed loop of a scenario as a Drake Diagram, in its start pose.

    The scenario may also be the name of one that comes with the package, or the path of a file.
    """
    scenario = as_scenario(scenario)
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, scenario.ground)
    plant.Finalize()
    set_servo_gains(plant, scenario.control.servos)
    with _posture(scenario):
        controller = WalkingController(scenario, planned_steps(scenario.walk))
    builder.AddNamedSystem("controller", controller)
    stance = controller.stance
    set_start(plant, scenario.start, scenario.ground, stance.q, stance.p_PT)

    sensors = scenario.sensors
    imu_params, force_params, contact_params = (
        params.ideal() if sensors.ideal else params
        for params in (sensors.imu, sensors.foot_force, sensors.contact)
    )
    state = plant.get_state_output_port()
    imu = builder.AddNamedSystem("imu", Imu(imu_params, state.size(), PERIOD, scenario.seed))
    half_weight = 0.5 * plant.CalcTotalMass(plant.CreateDefaultContext()) * GRAVITY
    force_sensor = builder.AddNamedSystem(
        "foot_force_sensor",
        FootForceSensor(
            force_params,
            tuple(int(plant.GetJointByName(f"fts_{foot}").index()) for foot in "lr"),
            np.tile([0.0, 0.0, half_weight, 0.0, 0.0, 0.0], 2),
            PERIOD,
            scenario.seed,
        ),
    )
    switches = builder.AddNamedSystem(
        "contact_switches",
        ContactSwitches(contact_params, pad_geometries(plant, scene_graph), PERIOD),
    )
    command = builder.AddNamedSystem("walk_command", _command_source(scenario.walk))

    connect = builder.Connect
    connect(state, imu.GetInputPort("plant_state"))
    connect(plant.get_reaction_forces_output_port(), force_sensor.GetInputPort("reaction_forces"))
    connect(plant.get_contact_results_output_port(), switches.GetInputPort("contact_results"))
    for system, name in (
        (imu, "torso_orientation"),
        (force_sensor, "measured_wrench"),
        (switches, "contact"),
    ):
        connect(system.GetOutputPort(name), controller.GetInputPort(name))
    connect(command.get_output_port(), controller.GetInputPort("walk_command"))
    connect(
        controller.GetOutputPort("joint_desired_state"),
        plant.get_desired_state_input_port(plant.GetModelInstanceByName("lola")),
    )
    connect(controller.GetOutputPort("joint_feedforward"), plant.get_actuation_input_port())
    _add_log(builder, controller, plant, command, imu, force_sensor, switches)
    diagram = builder.Build()
    diagram.set_name("lola")
    return diagram


def planned_steps(walk: Walk) -> np.ndarray | None:
    """Return (forward, left, turn) of every planned step, shape (n, 3); None without a plan."""
    if not walk.steps:
        return None
    return np.array(
        [
            (group.length, group.sideways, np.deg2rad(group.turn_deg))
            for group in walk.steps
            for _ in range(group.count)
        ]
    )


def _command_source(walk: Walk):
    if not walk.command:
        return ConstantVectorSource([0.0, 0.0, 0.0])
    times = [0.0, *(command.time for command in walk.command)]
    values = [(0.0, 0.0, 0.0), *((c.v_x, c.v_y, c.turn_rate) for c in walk.command)]
    if times[1] == 0.0:
        times, values = times[1:], values[1:]
    # The hold needs a last break, where the last command goes on.
    times, values = [*times, times[-1] + 1.0], [*values, values[-1]]
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.transpose(values)))


def _add_log(builder, controller, plant, command, *sensors) -> None:
    """Log every signal in one wide sink; its layout is that of `_log_ports`."""
    ports = _log_ports(controller, plant, command, *sensors)
    multiplexer = builder.AddNamedSystem(
        "log_multiplexer", Multiplexer([port.size() for port in ports.values()])
    )
    for i, port in enumerate(ports.values()):
        builder.Connect(port, multiplexer.get_input_port(i))
    total = multiplexer.get_output_port().size()
    log = builder.AddNamedSystem("log", VectorLogSink(total, publish_period=PERIOD))
    builder.Connect(multiplexer.get_output_port(), log.get_input_port())


def _log_ports(controller, plant, command, *sensors) -> dict:
    """Return the logged ports by their names in the record, and the plant's state."""
    ports = {
        port.get_name(): port
        for system in (controller, *sensors)
        for port in (system.get_output_port(i) for i in range(system.num_output_ports()))
    }
    ports["walk_command"] = command.get_output_port()
    ports = {name: port for name, port in ports.items() if name in LOGGED}
    # The plant first: then all of Python runs in one go, while it is warm in the caches.
    return {
        "plant_state": plant.get_state_output_port(),
        "joint_torque": plant.get_net_actuation_output_port(),
    } | ports


Attend = Callable[[Diagram, Context], float | None]


def simulate(
    scenario: Scenario | str | Path,
    progress: Callable[[float], None] | None = None,
    chunk: float = 0.02,
    attend: Attend | None = None,
) -> Result:
    """Run a scenario to its end, a fall, or Ctrl-C, and return everything that was recorded.

    An error of the solver, of a block or of `attend` ends the run, too; `Result.error` says which.

    Args:
        scenario: what to run: a scenario, its name, or the path of its file.
        progress: called with the simulated time (s) every `chunk` seconds.
        chunk: how often a fall, an interruption and the progress are looked at (s).
        attend: called with the diagram and its context, which it may change; returns by how much
            to go on until the next call (s), 0 to wait, or None to end the run.
    """
    scenario = as_scenario(scenario)
    diagram = build_simulation(scenario)
    simulator = Simulator(diagram)
    plant = diagram.GetSubsystemByName("plant")
    context = simulator.get_mutable_context()
    plant_context = plant.GetMyContextFromRoot(context)
    fell, started = False, time.perf_counter()
    with interruption() as interrupted, _kept() as errors:
        simulator.Initialize()
        while not (fell or interrupted.is_set()):
            now = context.get_time()
            step = chunk if attend is None else attend(diagram, context)
            if step is None or now >= scenario.duration - 0.5 * PERIOD:
                break
            simulator.AdvanceTo(on_tick(min(now + step, scenario.duration)))
            fell = _fallen(plant, plant_context)
            if progress is not None:
                progress(context.get_time())
        # The log's sample of the last moment, which AdvanceTo leaves to what comes after it.
        simulator.AdvancePendingEvents()
    error = errors[0] if errors else None
    return _result(scenario, diagram, context, fell, time.perf_counter() - started, error)


def _fallen(plant, plant_context) -> bool:
    """Return whether the robot has fallen; an error if its state is no number any more."""
    positions = plant.GetPositions(plant_context)
    if not np.isfinite(positions).all():
        raise FloatingPointError("the state of the plant is no number any more")
    return has_fallen(positions)


@contextmanager
def _kept() -> Iterator[list[str]]:
    """Let an error of the solver, a block or who attends end a run, but not lose its record.

    A failed assertion of Drake's is a SystemExit. The whole of the error is for the log.
    """
    errors: list[str] = []
    try:
        yield errors
    except (Exception, SystemExit) as error:
        logging.getLogger("lola_drake").debug("a run failed", exc_info=True)
        errors.append(f"{type(error).__name__}: {reason(error)}")


@contextmanager
def _posture(scenario: Scenario) -> Iterator[None]:
    """Say which keys ask for a posture that the robot cannot take."""
    try:
        yield
    except ValueError as error:
        keys = "pattern.com_height, step_width and zmp_forward"
        raise ScenarioError(f"{scenario.name}: {reason(error)}; see {keys}") from None


def _result(scenario, diagram, context, fell: bool, wall_time: float, error: str | None) -> Result:
    log = diagram.GetSubsystemByName("log").FindLog(context)
    times, data = log.sample_times().copy(), log.data().T
    if error is not None:
        # The last samples may be what made it fail.
        broken = np.flatnonzero(~np.isfinite(data).all(axis=1))
        times, data = times[: min(broken, default=None)], data[: min(broken, default=None)]
    controller, plant = (diagram.GetSubsystemByName(name) for name in ("controller", "plant"))
    sensors = [
        diagram.GetSubsystemByName(name)
        for name in ("imu", "foot_force_sensor", "contact_switches")
    ]
    command = diagram.GetSubsystemByName("walk_command")
    signals, first = {}, 0
    for name, port in _log_ports(controller, plant, command, *sensors).items():
        signals[name] = data[:, first : first + port.size()].copy()
        first += port.size()
    signals |= plant_truth(plant, signals.pop("plant_state"))
    return Result(
        scenario=scenario,
        times=times,
        signals=signals,
        completed=not (fell or error) and times[-1] >= scenario.duration - 0.5 * PERIOD,
        fall_time=float(times[-1]) if fell else None,
        wall_time=wall_time,
        error=error,
    )
