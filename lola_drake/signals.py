"""The vectors that flow between the blocks: names, order, units and frames.

One `Signal` per wide port. A block reads a field by its slice, taken once at import
(`LOAD = GAIT_PHASE.slice("load")`); the logs and figures take names and units from here.
Frames: W world, T torso (moves with the torso, its axes level and turned with the heading when
the torso is upright), P plan (the world as the walking pattern believes it to be).
Feet are always ordered left, right.
"""

from dataclasses import dataclass

PERIOD = 0.001
"""The control period (s), as on LOLA (paper)."""


def on_tick(time: float) -> float:
    """Return the tick nearest to a time (s), exactly: sums of steps miss it by rounding errors."""
    return round(time / PERIOD) * PERIOD


FEET = ("l", "r")


def of_foot(name: str, foot: str) -> str:
    """Return the name of one foot's signal, field or block; of both for no foot."""
    return f"{name}_{foot}" if foot else name


def split_foot(name: str) -> tuple[str, str]:
    """Return a name without its foot, and the foot; it is empty where the name has none."""
    stem, _, foot = name.rpartition("_")
    return (stem, foot) if stem and foot in FEET else (name, "")


@dataclass(frozen=True)
class Field:
    """A run of entries that belong together inside a signal; one unit for all, or one for each."""

    name: str
    entries: tuple[str, ...]
    unit: str | tuple[str, ...]
    frame: str = ""

    @property
    def units(self) -> tuple[str, ...]:
        """Return one unit per entry."""
        return self.unit if isinstance(self.unit, tuple) else (self.unit,) * len(self.entries)


@dataclass(frozen=True)
class Signal:
    """A named vector made of fields.

    Attributes:
        name: of its ports; where each foot has one, `_l` or `_r` may follow.
        doc: what it is, in one line.
        fields: what it is made of.
        per_foot: whether each foot has one.
        logged: whether the record of a run has it.
    """

    name: str
    doc: str
    fields: tuple[Field, ...]
    per_foot: bool = False
    logged: bool = True

    @property
    def size(self) -> int:
        """Return the number of entries."""
        return sum(len(field.entries) for field in self.fields)

    def slice(self, name: str, count: int | None = None) -> slice:
        """Return where the field called `name`, or its first entries, lie; KeyError if nowhere."""
        start = 0
        for field in self.fields:
            if field.name == name:
                return slice(start, start + (count or len(field.entries)))
            start += len(field.entries)
        raise KeyError(f"{self.name} has no field {name!r}")

    def index(self, name: str) -> int:
        """Return the position of the one-entry field called `name`."""
        where = self.slice(name)
        if where.stop - where.start != 1:
            raise KeyError(f"{self.name}.{name} has {where.stop - where.start} entries, not one")
        return where.start

    def entry_names(self) -> tuple[str, ...]:
        """Return one name per entry, such as `w_l.x`."""
        return tuple(
            f"{field.name}.{entry}" if entry else field.name
            for field in self.fields
            for entry in field.entries
        )

    def entry_units(self) -> tuple[str, ...]:
        """Return one unit per entry."""
        return tuple(unit for field in self.fields for unit in field.units)

    def entry_frames(self) -> tuple[str, ...]:
        """Return one frame per entry (empty where no frame applies)."""
        return tuple(field.frame for field in self.fields for _ in field.entries)


_ONE = ("",)
_XY = ("x", "y")
_XYZ = ("x", "y", "z")
_FOOT = ("x", "y", "z", "sin_gamma_x", "sin_gamma_y", "gamma_z")
_FOOT_UNITS = ("m", "m", "m", "-", "-", "rad")
_FOOT_RATES = ("m/s", "m/s", "m/s", "1/s", "1/s", "rad/s")
_FORCE_CONTROLLED = ("T_x", "T_y", "F_z")
_FORCE_UNITS = ("Nm", "Nm", "N")
_FORCE_RATES = ("Nm/s", "Nm/s", "N/s")
_PADS = ("rear_left", "rear_right", "front_left", "front_right")
JOINTS = (
    "tbr", "tba",
    "thrr", "thar", "thfr", "tkfr", "tsar", "tsfr", "tzfr",
    "thrl", "thal", "thfl", "tkfl", "tsal", "tsfl", "tzfl",
    "tafr", "taar", "tefr", "tafl", "taal", "tefl",
    "tvp", "tvt",
)  # fmt: skip

PLANT_STATE = Signal(
    "plant_state",
    "Positions and velocities of the plant, as Drake orders them.",
    (
        Field("quaternion", ("w", "x", "y", "z"), "-", "W"),
        Field("position", _XYZ, "m", "W"),
        Field("q", JOINTS, "rad"),
        Field("angular_velocity", _XYZ, "rad/s", "W"),
        Field("velocity", _XYZ, "m/s", "W"),
        Field("q_dot", JOINTS, "rad/s"),
    ),
    logged=False,
)
WALK_COMMAND = Signal(
    "walk_command",
    "What the user asks for; all zero means stop.",
    (
        Field("velocity", _XY, "m/s", "heading"),
        Field("turn_rate", _ONE, "rad/s", "heading"),
    ),
)
TASK_REFERENCE = Signal(
    "task_reference",
    "w_id and its rate: each foot's TCP relative to the CoM, and the toes.",
    (
        Field("w_l", _FOOT, _FOOT_UNITS, "T"),
        Field("w_r", _FOOT, _FOOT_UNITS, "T"),
        Field("toes", ("l", "r"), "rad"),
        Field("w_dot_l", _FOOT, _FOOT_RATES, "T"),
        Field("w_dot_r", _FOOT, _FOOT_RATES, "T"),
        Field("toe_rates", ("l", "r"), "rad/s"),
    ),
)
GAIT_PHASE = Signal(
    "gait_phase",
    "Where in the gait the plan is, and how the feet share the load.",
    (
        Field("support", ("l", "r"), "0/1"),
        Field("load", ("l", "r"), "-"),
        Field("blend", ("l", "r"), "-"),
        Field("step_index", _ONE, "-"),
        Field("time_in_step", _ONE, "s"),
    ),
)
IDEAL_WRENCH = Signal(
    "ideal_wrench",
    "Lambda_id: ideal force, and ideal torque about the CoM.",
    (Field("F", _XYZ, "N", "T"), Field("T", _XYZ, "Nm", "T")),
)
PLANNED_MOTION = Signal(
    "planned_motion",
    "The plan seen from the ground, for logs, figures and metrics.",
    (
        Field("com", _XYZ, "m", "P"),
        Field("com_velocity", _XYZ, "m/s", "P"),
        Field("zmp", _XY, "m", "P"),
        Field("heading", _ONE, "rad", "P"),
        Field("foot_l", (*_XYZ, "yaw"), ("m", "m", "m", "rad"), "P"),
        Field("foot_r", (*_XYZ, "yaw"), ("m", "m", "m", "rad"), "P"),
    ),
)
TORSO_ORIENTATION = Signal(
    "torso_orientation",
    "Inclination of the torso and its rate, as the IMU reports them.",
    (Field("phi", _XY, "rad", "W"), Field("phi_dot", _XY, "rad/s", "heading")),
)
MODIFIED_WRENCH = Signal(
    "modified_wrench",
    "Lambda_mod: Lambda_id changed so that the torso stays upright.",
    (Field("F", _XYZ, "N", "T"), Field("T", _XYZ, "Nm", "T")),
)
DESIRED_WRENCH = Signal(
    "desired_wrench",
    "lambda_f,d and its rate at each foot's TCP.",
    (
        Field("wrench_l", _FORCE_CONTROLLED, _FORCE_UNITS, "T"),
        Field("wrench_r", _FORCE_CONTROLLED, _FORCE_UNITS, "T"),
        Field("rate_l", _FORCE_CONTROLLED, _FORCE_RATES, "T"),
        Field("rate_r", _FORCE_CONTROLLED, _FORCE_RATES, "T"),
    ),
)
MEASURED_WRENCH = Signal(
    "measured_wrench",
    "lambda_f,m: what each foot's force/torque sensor reports, in its own frame.",
    (
        Field("F_l", _XYZ, "N", "sensor"),
        Field("T_l", _XYZ, "Nm", "sensor"),
        Field("F_r", _XYZ, "N", "sensor"),
        Field("T_r", _XYZ, "Nm", "sensor"),
    ),
)
CONTACT_WRENCH = Signal(
    "contact_wrench",
    "lambda_f (eq. 13): the measured wrench taken to the TCP in T.",
    (Field("wrench", _FORCE_CONTROLLED, _FORCE_UNITS, "T"),),
    per_foot=True,
)
CONTACT = Signal(
    "contact",
    "The four contact switches of each foot.",
    (Field("pads_l", _PADS, "0/1"), Field("pads_r", _PADS, "0/1")),
)
GROUND_FORCE = Signal(
    "ground_force",
    "The ground's true force on each foot; for logs, not for control.",
    (Field("F_l", _XYZ, "N", "W"), Field("F_r", _XYZ, "N", "W")),
)
COM_DYNAMICS_RATE = Signal(
    "com_dynamics_rate",
    "Delta w_dot_a,f (eq. 20).",
    (Field("rate", ("sin_gamma_x", "sin_gamma_y", "z"), ("1/s", "1/s", "m/s"), "T"),),
    per_foot=True,
)
TASK_MODIFICATION = Signal(
    "task_modification",
    "Delta w of one foot's force-controlled directions.",
    (Field("delta_w", ("sin_gamma_x", "sin_gamma_y", "z"), ("-", "-", "m"), "T"),),
    per_foot=True,
)
TASK_COMMAND = Signal(
    "task_command",
    "w_mod and its rate of one foot (eq. 10, 11).",
    (Field("w", _FOOT, _FOOT_UNITS, "T"), Field("w_dot", _FOOT, _FOOT_RATES, "T")),
    per_foot=True,
)
JOINT_COMMAND = Signal(
    "joint_command",
    "What the central controller sends to the joint controllers.",
    (Field("q", JOINTS, "rad"), Field("q_dot", JOINTS, "rad/s"), Field("torque", JOINTS, "Nm")),
)
JOINT_ANGLES = Signal(
    "joint_angles",
    "The commanded joint angles.",
    (Field("q", JOINTS, "rad"),),
    logged=False,
)
JOINT_TORQUE = Signal("joint_torque", "At the joints.", (Field("torque", JOINTS, "Nm"),))
JOINT_DESIRED_STATE = Signal(
    "joint_desired_state",
    "What the servos follow.",
    (Field("q", JOINTS, "rad"), Field("q_dot", JOINTS, "rad/s")),
    logged=False,
)
JOINT_FEEDFORWARD = Signal(
    "joint_feedforward",
    "What the servos add to their own torque.",
    (Field("torque", JOINTS, "Nm"),),
    logged=False,
)

SIGNALS = {signal.name: signal for signal in list(vars().values()) if isinstance(signal, Signal)}
"""Every signal by its name."""


def signal_of(name: str) -> Signal | None:
    """Return the signal of a name, of one foot or of both; None if there is none."""
    return SIGNALS.get(name) or SIGNALS.get(split_foot(name)[0])
