"""The plant without its controller: the servo commands of a walk, played to it again."""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer

from lola_drake.controller import initial_stance
from lola_drake.plant import add_plant, pad_geometries, set_start
from lola_drake.pushes import connect_pushes
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario
from lola_drake.servos import DampingServos, ImplicitServos
from lola_drake.signals import FEET, JOINT_DESIRED_STATE, JOINT_FEEDFORWARD, JOINTS, PERIOD
from lola_drake.simulation import start

SOLES = tuple(link for foot in FEET for link in (f"foot_{foot}", f"zf{foot}"))
"""The links that touch the ground: of each foot the part with the rear pads, and the toe."""

_COMMANDS = (JOINT_DESIRED_STATE, JOINT_FEEDFORWARD)


def record_commands(scenario: Scenario, end: float, engine: str = "fused") -> np.ndarray:
    """Return what the servos get in every tick of the closed loop.

    Returns:
        q, q', feed-forward torque (rad, rad/s, Nm), shape (ticks, 72).
    """
    run = start(scenario, engine=engine)
    # One row more: rounding may let the simulation go one tick beyond the end.
    commands = np.empty((round(end / PERIOD) + 1, 3 * len(JOINTS)))
    for tick, command in enumerate(commands):
        command[:] = np.concatenate([run.signal(signal.name) for signal in _COMMANDS])
        run.advance((tick + 1) * PERIOD)
    return commands


class _Replay(LeafSystem):
    """Gives one row of a table per tick."""

    def __init__(self, rows: np.ndarray):
        super().__init__()
        self._rows = rows
        self.DeclareVectorOutputPort("row", rows.shape[1], self._calc, {self.time_ticket()})

    def _calc(self, context, output):
        output.set_value(self._rows[round(context.get_time() / PERIOD)])


def bare_plant(
    scenario: Scenario,
    commands: np.ndarray,
    servos: type[ImplicitServos | DampingServos] = ImplicitServos,
) -> Diagram:
    """Return the plant of a scenario with servos that get the commands of a table.

    Args:
        scenario: gives the ground, the servos and the start.
        commands: one row per tick, as from `record_commands`.
        servos: the kind of servos.
    """
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, scenario.terrain, scenario.model_errors)
    driven = servos(plant, scenario.real_servos())
    plant.Finalize()
    connect_pushes(builder, plant, scenario.pushes)
    stance = initial_stance(scenario, Kinematics())
    set_start(plant, scenario.start, scenario.terrain, stance.q, stance.p_PT)
    replay = builder.AddSystem(_Replay(commands))
    parts = builder.AddSystem(Demultiplexer([2 * len(JOINTS), len(JOINTS)]))
    builder.Connect(replay.get_output_port(), parts.get_input_port())
    driven.connect(builder, parts.get_output_port(0), parts.get_output_port(1))
    return builder.Build()


@dataclass(frozen=True, eq=False)
class Motion:
    """What the plant did in some ticks, one after the other.

    Attributes:
        q: Drake's positions: the torso's quaternion (w, x, y, z) and place (m) in W, and the joint
            angles (rad), shape (n, 31).
        v: Drake's velocities: angular (rad/s) and linear (m/s) of the torso in W, and the joint
            rates (rad/s), shape (n, 30).
        v_dot: their change from this tick to the next, per second, shape (n, 30).
        torque: of the drives, servos and all (Nm), shape (n, 24).
        sole_wrench: of the ground on each of `SOLES`: force (N), and torque (Nm) about the origin
            of W, both in W, shape (n, 4, 6).
    """

    q: np.ndarray
    v: np.ndarray
    v_dot: np.ndarray
    torque: np.ndarray
    sole_wrench: np.ndarray


def record_motion(simulator: Simulator, ticks: int) -> Motion:
    """Advance a simulation with a plant by some ticks, and return what the plant did."""
    diagram = simulator.get_system()
    plant = diagram.GetSubsystemByName("plant")
    context = plant.GetMyContextFromRoot(simulator.get_context())
    sole_of = _soles_by_geometry(plant)
    torques, contacts = (
        plant.get_net_actuation_output_port(),
        plant.get_contact_results_output_port(),
    )
    first = round(simulator.get_context().get_time() / PERIOD)
    states, torque, wrench = [], [], []
    for tick in range(first, first + ticks):
        states.append(plant.GetPositionsAndVelocities(context))
        torque.append(torques.Eval(context))
        wrench.append(_sole_wrenches(contacts.Eval(context), sole_of))
        simulator.AdvanceTo((tick + 1) * PERIOD)
    states.append(plant.GetPositionsAndVelocities(context))
    q, v = np.split(np.array(states), [plant.num_positions()], axis=1)
    return Motion(q[:-1], v[:-1], np.diff(v, axis=0) / PERIOD, np.array(torque), np.array(wrench))


def _soles_by_geometry(plant: MultibodyPlant) -> dict[int, int]:
    """Return which of `SOLES` a pad belongs to, by the value of its geometry's id."""
    # Two pads each, in the order of the switches: rear pads on the foot, front pads on the toe.
    return {pad: switch // 2 for pad, switch in pad_geometries(plant).items()}


def _sole_wrenches(results: ContactResults, sole_of: dict[int, int]) -> np.ndarray:
    """Return force and torque of the ground on each sole about the origin of W, shape (4, 6)."""
    wrenches = np.zeros((len(SOLES), 6))
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface, load = info.contact_surface(), info.F_Ac_W()
        # The reported force acts on geometry M; a pad may be either of the two.
        sole, sign = sole_of.get(surface.id_M().get_value()), 1.0
        if sole is None:
            sole, sign = sole_of[surface.id_N().get_value()], -1.0
        force = load.translational()
        torque = load.rotational() + np.cross(surface.centroid(), force)
        wrenches[sole] += sign * np.concatenate([force, torque])
    return wrenches
