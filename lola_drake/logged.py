"""What the record of a run holds: the signals between the blocks, and the truth of the plant."""

from lola_drake import signals
from lola_drake.signals import FEET, JOINTS, Field, Signal

_XYZ = ("x", "y", "z")
_POSE = (Field("p", _XYZ, "m", "W"), Field("rpy", ("roll", "pitch", "yaw"), "rad", "W"))

TORSO_POSE = Signal("torso_pose", "The torso in the plant.", _POSE)
COM_POSITION = Signal("com_position", "The CoM of the plant.", (Field("p", _XYZ, "m", "W"),))
FOOT_POSE = Signal("foot_pose", "One foot's TCP in the plant.", _POSE)
JOINT_POSITION = Signal("joint_position", "In the plant.", (Field("q", JOINTS, "rad"),))
JOINT_VELOCITY = Signal("joint_velocity", "In the plant.", (Field("q_dot", JOINTS, "rad/s"),))

_ONCE = (
    signals.WALK_COMMAND,
    signals.TASK_REFERENCE,
    signals.GAIT_PHASE,
    signals.IDEAL_WRENCH,
    signals.PLANNED_MOTION,
    signals.TORSO_ORIENTATION,
    signals.MODIFIED_WRENCH,
    signals.DESIRED_WRENCH,
    signals.MEASURED_WRENCH,
    signals.CONTACT,
    signals.GROUND_FORCE,
    signals.JOINT_COMMAND,
    TORSO_POSE,
    COM_POSITION,
    JOINT_POSITION,
    JOINT_VELOCITY,
    signals.JOINT_TORQUE,
)
_PER_FOOT = (
    signals.CONTACT_WRENCH,
    signals.COM_DYNAMICS_RATE,
    signals.TASK_MODIFICATION,
    signals.TASK_COMMAND,
    FOOT_POSE,
)

LOGGED: dict[str, Signal] = {signal.name: signal for signal in _ONCE} | {
    f"{signal.name}_{foot}": signal for signal in _PER_FOOT for foot in FEET
}
"""Every signal of a record by its name there; those of one foot end in _l or _r."""
