"""Units of the entries of signals, as far as they are known."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint
from pydrake.systems.framework import InputPort, OutputPort, System

from lola_drake.linear.signal_names import is_wrench_list, signal_of

_OF_JOINTS = {
    "prismatic": (("m",), ("m/s",)),
    "revolute": (("rad",), ("rad/s",)),
    "quaternion_floating": (("",) * 4 + ("m",) * 3, ("rad/s",) * 3 + ("m/s",) * 3),
    "rpy_floating": (("rad",) * 3 + ("m",) * 3, ("rad/s",) * 3 + ("m/s",) * 3),
}
"""Units of position and velocity by the name of a joint's type."""

_FORCES = {"m/s": "N", "rad/s": "Nm"}
_DIMENSIONLESS = ("-", "0/1", "-1/0/1")


def entry_units(system: System, port: InputPort | OutputPort, size: int) -> tuple[str, ...]:
    """Return one unit per entry of a port's signal; empty where there is none or none is known.

    Args:
        system: the block that the port belongs to.
        port: the port.
        size: of the signal.
    """
    units = _plant_units(system, port) if isinstance(system, MultibodyPlant) else None
    signal = None if is_wrench_list(port) else signal_of(port)
    if signal:
        units = tuple("" if u in _DIMENSIONLESS else u for u in signal.entry_units())
    return units if units and len(units) == size else ("",) * size


def _plant_units(plant: MultibodyPlant, port: InputPort | OutputPort) -> tuple[str, ...] | None:
    name = port.get_name()
    joints = [plant.get_joint(j) for j in plant.GetJointIndices()]
    if is_wrench_list(port):
        return ("Nm", "Nm", "Nm", "N", "N", "N") * len(joints)
    q, v = [""] * plant.num_positions(), [""] * plant.num_velocities()
    for joint in joints:
        positions, velocities = _units_of(joint)
        q[joint.position_start() : joint.position_start() + joint.num_positions()] = positions
        v[joint.velocity_start() : joint.velocity_start() + joint.num_velocities()] = velocities
    driven = [plant.get_joint_actuator(a).joint() for a in plant.GetJointActuatorIndices()]
    if "desired_state" in name:
        return tuple(_units_of(j)[k][0] for k in (0, 1) for j in driven)
    if "state" in name:
        return (*q, *v)
    if "generalized_force" in name:
        return tuple(_FORCES.get(unit, "") for unit in v)
    if "actuation" in name:
        return tuple(_FORCES.get(_units_of(joint)[1][0], "") for joint in driven)
    return None


def _units_of(joint: Joint) -> tuple[tuple[str, ...], tuple[str, ...]]:
    unknown = ("",) * joint.num_positions(), ("",) * joint.num_velocities()
    return _OF_JOINTS.get(joint.type_name(), unknown)
