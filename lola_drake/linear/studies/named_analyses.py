"""The named analyses: which part of the loop, where it is opened, and what to turn."""

from dataclasses import dataclass

from lola_drake.linear.errors import AnalysisError
from lola_drake.signals import FEET
from lola_drake.typed_yaml import suggestion


@dataclass(frozen=True)
class NamedAnalysis:
    """One named analysis.

    Attributes:
        doc: what it shows, in one line.
        at: operating point, unless another one is asked for.
        inputs, outputs: of the model whose poles and step response are shown.
        steps: height of the step at each input, in its unit.
        units: of each input, and of the output of the same number.
        opened: signals that are cut in that model.
        loops: signals at which loops are opened for margins.
        knob: scenario key that is turned for the root locus.
        values: of the knob.
    """

    doc: str
    at: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    steps: tuple[float, ...]
    units: tuple[tuple[str, str], ...]
    opened: tuple[str, ...]
    loops: tuple[str, ...]
    knob: str
    values: tuple[float, ...]


_DIRECTIONS = ("sin_gamma_x", "sin_gamma_y", "z")
_WRENCH = ("T_x", "T_y", "F_z")
_DELTAS = (0.008, 0.01, 0.012, 0.015, 0.02, 0.027, 0.035, 0.05)

NAMED_ANALYSES = {
    "contact": NamedAnalysis(
        doc="one foot on the ground: what the contact model U says, and what the plant does",
        at="left",
        inputs=tuple(f"task_command_l.w.{name}" for name in _DIRECTIONS),
        outputs=("measured_wrench.T_l.x", "measured_wrench.T_l.y", "measured_wrench.F_l.z"),
        steps=(1e-3, 1e-3, 1e-4),
        units=(("rad", "Nm"), ("rad", "Nm"), ("m", "N")),
        opened=(
            *(f"task_command_{foot}" for foot in FEET),
            *(f"task_modification_{foot}" for foot in FEET),
            "torso_orientation",
        ),
        loops=(),
        knob="ground.stiffness",
        values=(1e5, 2e5, 3e5, 5e5, 8e5),
    ),
    "servo": NamedAnalysis(
        doc="the joints' servos with the robot they move: command to joint angle",
        at="left",
        inputs=("joint_command.q.tkfl", "joint_command.q.tsfl", "joint_command.q.tkfr"),
        outputs=("plant.state.q.tkfl", "plant.state.q.tsfl", "plant.state.q.tkfr"),
        steps=(1e-3, 1e-3, 1e-3),
        units=(("rad", "rad"),) * 3,
        opened=("joint_command",),
        loops=(),
        knob="control.servos.position_gain",
        values=(35.0, 50.0, 70.0, 100.0, 140.0),
    ),
    "force_loop": NamedAnalysis(
        doc="force control of the left foot: desired to measured wrench",
        at="stand",
        inputs=tuple(f"desired_wrench.wrench_l.{name}" for name in _WRENCH),
        outputs=tuple(f"contact_wrench_l.wrench.{name}" for name in _WRENCH),
        steps=(1.0, 1.0, 5.0),
        units=(("Nm", "Nm"), ("Nm", "Nm"), ("N", "N")),
        opened=(),
        loops=("measured_wrench_l",),
        knob="control.force.time_constant",
        values=_DELTAS,
    ),
    "com_dynamics": NamedAnalysis(
        doc="the CoM's dynamics in the force control of the stance foot, gain g_a",
        at="left",
        inputs=tuple(f"desired_wrench.wrench_l.{name}" for name in _WRENCH),
        outputs=tuple(f"contact_wrench_l.wrench.{name}" for name in _WRENCH),
        steps=(1.0, 1.0, 5.0),
        units=(("Nm", "Nm"), ("Nm", "Nm"), ("N", "N")),
        opened=(),
        loops=("com_dynamics_rate_l",),
        knob="control.com_dynamics.gain",
        values=(0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0),
    ),
    "stabilizer": NamedAnalysis(
        doc="the stabiliser's loop, opened at the IMU: a torque on the torso to its inclination",
        at="stand",
        inputs=(
            "plant.applied_generalized_force.v.torso_wx",
            "plant.applied_generalized_force.v.torso_wy",
        ),
        outputs=("torso_orientation.phi.x", "torso_orientation.phi.y"),
        steps=(10.0, 10.0),
        units=(("Nm", "rad"),) * 2,
        opened=(),
        loops=("torso_orientation", "modified_wrench.T.x", "modified_wrench.T.y"),
        knob="control.stabilizer.damping",
        values=(50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1000.0),
    ),
    "full": NamedAnalysis(
        doc="everything closed: a force on the torso to its inclination and the feet's forces",
        at="stand",
        inputs=(
            "plant.applied_generalized_force.v.torso_vx",
            "plant.applied_generalized_force.v.torso_vy",
        ),
        outputs=(
            "torso_orientation.phi.y",
            "torso_orientation.phi.x",
            "contact_wrench_l.wrench.F_z",
        ),
        steps=(10.0, 10.0),
        units=(("N", "rad"),) * 2,
        opened=(),
        loops=("measured_wrench", "torso_orientation", "modified_wrench.F.z"),
        knob="control.force.time_constant",
        values=_DELTAS,
    ),
}


def named_analysis(name: str) -> NamedAnalysis:
    """Return a named analysis; AnalysisError if there is none of that name."""
    if name not in NAMED_ANALYSES:
        raise AnalysisError(f"no analysis {name!r}{suggestion(name, NAMED_ANALYSES)}")
    return NAMED_ANALYSES[name]
