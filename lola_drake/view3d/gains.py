"""The gains that can be turned while the robot walks: numeric parameters of a Context."""

from dataclasses import dataclass

from pydrake.systems.framework import Context, Diagram, System


@dataclass(frozen=True)
class Gain:
    """One gain, in one or several blocks of the controller.

    Attributes:
        key: Its name in a scenario.
        label: As in the paper, with the unit; short, since the panel is narrow.
        blocks: Where it is in force, in one variant of the controller or another.
        index: Its place in the blocks' numeric parameter.
        low, high, step: Of its slider.
    """

    key: str
    label: str
    blocks: tuple[str, ...]
    index: int
    low: float
    high: float
    step: float


_FORCE = ("force_control_l", "force_control_r", "configuration_force_control")
_DYNAMICS = ("com_dynamics_l", "com_dynamics_r")
_STABILIZER = ("imu_stabilizer",)

GAINS = (
    Gain("control.force.time_constant", "δ (s)", _FORCE, 0, 0.005, 0.08, 0.001),
    Gain("control.force.position_gain", "K_x (1/s)", _FORCE, 1, 0.0, 50.0, 0.5),
    Gain("control.com_dynamics.gain", "g_a (-)", _DYNAMICS, 0, 0.0, 1.0, 0.05),
    Gain("control.com_dynamics.decay_gain", "K_a,x (1/s)", _DYNAMICS, 1, 0.0, 100.0, 1.0),
    Gain("control.stabilizer.stiffness", "P (Nm/rad)", _STABILIZER, 0, 0, 4000, 20.0),
    Gain("control.stabilizer.damping", "D (Nms/rad)", _STABILIZER, 1, 0, 800, 5.0),
    Gain("control.stabilizer.torque_limit", "limit (Nm)", _STABILIZER, 2, 1, 300, 1.0),
    Gain("control.stabilizer.height_stiffness", "P_z (N/m)", _STABILIZER, 3, 0, 9000, 50.0),
)
"""The gains that matter, in the order of their sliders."""


def gains_of(diagram: Diagram) -> list[Gain]:
    """Return the gains that the controller of a simulation has."""
    return [gain for gain in GAINS if _blocks(diagram, gain)]


def get_gain(diagram: Diagram, context: Context, gain: Gain) -> float:
    """Return a gain as it is in the context of a simulation."""
    block = _blocks(diagram, gain)[0].GetMyContextFromRoot(context)
    return float(block.get_numeric_parameter(0).value()[gain.index])


def set_gain(diagram: Diagram, context: Context, gain: Gain, value: float) -> None:
    """Change a gain in the context of a simulation, in all its blocks; it acts at once."""
    for system in _blocks(diagram, gain):
        block = system.GetMyMutableContextFromRoot(context)
        block.get_mutable_numeric_parameter(0).SetAtIndex(gain.index, value)


def _blocks(diagram: Diagram, gain: Gain) -> list[System]:
    controller = diagram.GetSubsystemByName("controller")
    present = [name for name in gain.blocks if controller.HasSubsystemNamed(name)]
    return [controller.GetSubsystemByName(name) for name in present]
