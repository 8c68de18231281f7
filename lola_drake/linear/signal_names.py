"""Names for the entries of signals and states, and which entries are switches."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import InputPort, OutputPort, PortDataType, System

from lola_drake import signals
from lola_drake.block import Block
from lola_drake.signals import Signal

_SWITCH_UNITS = ("0/1", "-1/0/1")
_FORCE = ("T.x", "T.y", "T.z", "F.x", "F.y", "F.z")

_FORCE_UNITS, _FORCE_SCALE = ("N", "Nm", "Nm, N"), 100.0


def signal_of(port: InputPort | OutputPort) -> Signal | None:
    """Return what a port carries: as its block declares it, or else by its name alone."""
    block, name = getattr(port.get_system(), "block", None), port.get_name()
    declared = {**block.inputs, **block.outputs} if block else {}
    signal = declared.get(name, signals.signal_of(name))
    if not isinstance(signal, Signal):
        return None
    return signal if signal.size == port.size() else None


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
        plant_names = (*_positions(system), *_velocities(system))
        return tuple(n.replace("_q", "_rot_") for n in plant_names if not n.endswith("_qw"))
    names = [name for name, _ in _state_entries(system, size)]
    seen: dict[str, int] = {}
    for name in names:
        seen[name] = seen.get(name, 0) + 1
    # A delay line holds several samples, the newest first.
    count = dict.fromkeys(names, 0)
    numbered = []
    for name in names:
        count[name] += 1
        numbered.append(f"{name}@{count[name]}" if seen[name] > 1 else name)
    return tuple(numbered)


def state_scales(system: System, size: int) -> np.ndarray:
    """Return what is a lot for each coordinate: 100 N and Nm, 1 of everything else."""
    if isinstance(system, MultibodyPlant):
        return np.ones(size)
    units = [unit for _, unit in _state_entries(system, size)]
    return np.array([_FORCE_SCALE if unit in _FORCE_UNITS else 1.0 for unit in units])


def _state_entries(system: System, size: int) -> list[tuple[str, str]]:
    """Return name and unit of every entry of a block's state, as the block declares them."""
    block: Block | None = getattr(system, "block", None)
    unnamed = [(f"x{i}", "") for i in range(size)]
    if block is None:
        return unnamed
    entries = [
        entry
        for name, state in block.states.items()
        for _ in range(len(block.initial[name]) // state.signal.size)
        for entry in zip(state.signal.entry_names(), state.signal.entry_units(), strict=True)
    ]
    return entries if len(entries) == size else unnamed


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
