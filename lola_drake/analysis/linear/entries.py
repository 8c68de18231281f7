"""Names for the entries of signals and states, and which entries are switches."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import InputPort, OutputPort, PortDataType, System

from lola_drake import signals
from lola_drake.signals import JOINTS, Signal

_SIGNALS = {s.name: s for s in vars(signals).values() if isinstance(s, Signal)}
_SWITCH_UNITS = ("0/1", "-1/0/1")
_FORCE = ("T.x", "T.y", "T.z", "F.x", "F.y", "F.z")

_STATES = {
    "ComDynamics": signals.COM_DYNAMICS_RATE.entry_names(),
    "FootForceSensor": signals.MEASURED_WRENCH.entry_names(),
    "ForceDistribution": signals.DESIRED_WRENCH.entry_names()[:6],
    "HybridForceControl": signals.TASK_MODIFICATION.entry_names()[:3],
    "Imu": signals.TORSO_ORIENTATION.entry_names(),
    "InverseKinematics": tuple(f"q.{joint}" for joint in JOINTS),
    "JointServos": signals.JOINT_COMMAND.entry_names(),
}
"""What one sample of a block's state holds; a delay line holds several, the newest first."""


def signal_of(port: InputPort | OutputPort) -> Signal | None:
    """Return what `lola_drake.signals` says about a port, by its name."""
    name = port.get_name()
    signal = _SIGNALS.get(name) or _SIGNALS.get(name.removesuffix("_l").removesuffix("_r"))
    return signal if signal and signal.size == port.size() else None


def is_wrench_list(port: InputPort | OutputPort) -> bool:
    """Return whether a port carries the plant's reaction forces, a list of spatial forces."""
    return port.get_name() == "reaction_forces" and not is_plain_vector(port)


def is_plain_vector(port: InputPort | OutputPort) -> bool:
    """Return whether a port carries a vector."""
    return port.get_data_type() == PortDataType.kVectorValued


def is_vector(port: InputPort | OutputPort) -> bool:
    """Return whether a port carries something that can be read as a vector."""
    return is_plain_vector(port) or is_wrench_list(port)


def entry_names(system: System, port: InputPort | OutputPort) -> tuple[str, ...]:
    """Return one name per entry of a port's signal, such as `F_l.z`; unique within it."""
    if isinstance(system, MultibodyPlant):
        return _plant_entries(system, port)
    signal = signal_of(port)
    if signal:
        return signal.entry_names()
    return tuple(map(str, range(port.size())))


def switches(port: InputPort | OutputPort) -> np.ndarray:
    """Return which entries of a port's signal only switch; they do not move by a little."""
    signal = signal_of(port) if is_plain_vector(port) else None
    if signal is None:
        return np.zeros(port.size(), dtype=bool)
    return np.array([unit in _SWITCH_UNITS for unit in signal.entry_units()], dtype=bool)


def state_names(system: System, size: int) -> tuple[str, ...]:
    """Return one name per coordinate of a block's discrete state, unique within the block."""
    if isinstance(system, MultibodyPlant):
        names = (*_positions(system), *_velocities(system))
        return tuple(n.replace("_q", "_rot_") for n in names if not n.endswith("_qw"))
    sample = _STATES.get(type(system).__name__, ())
    if not sample or size % len(sample):
        return tuple(f"x{i}" for i in range(size))
    lines = size // len(sample)
    return tuple(
        f"{name}@{line + 1}" if lines > 1 else name for line in range(lines) for name in sample
    )


def _plant_entries(plant: MultibodyPlant, port: InputPort | OutputPort) -> tuple[str, ...]:
    name = port.get_name()
    if is_wrench_list(port):
        joints = sorted(plant.GetJointIndices(), key=int)
        return tuple(f"{plant.get_joint(j).name()}.{entry}" for j in joints for entry in _FORCE)
    positions, velocities = _positions(plant), _velocities(plant)
    actuators = plant.GetActuatorNames(add_model_instance_prefix=False)
    for layout in (
        positions + velocities,
        velocities,
        [f"{kind}.{joint}" for kind in "qv" for joint in actuators],
        actuators,
    ):
        if len(layout) == port.size() and ("state" in name) == (len(layout) > len(velocities)):
            return tuple(layout)
    return tuple(map(str, range(port.size())))


def _positions(plant: MultibodyPlant) -> list[str]:
    names = plant.GetPositionNames(add_model_instance_prefix=False, always_add_suffix=False)
    return [f"q.{name}" for name in names]


def _velocities(plant: MultibodyPlant) -> list[str]:
    names = plant.GetVelocityNames(add_model_instance_prefix=False, always_add_suffix=False)
    return [f"v.{name}" for name in names]
