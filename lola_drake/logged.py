"""What the record of a run holds: the signals between the blocks, and the truth of the plant."""

from lola_drake.signals import FEET, JOINTS, SIGNALS, Field, Signal, of_foot

_XYZ = ("x", "y", "z")
_POSE = (Field("p", _XYZ, "m", "W"), Field("rpy", ("roll", "pitch", "yaw"), "rad", "W"))

TORSO_POSE = Signal("torso_pose", "The torso in the plant.", _POSE)
COM_POSITION = Signal("com_position", "The CoM of the plant.", (Field("p", _XYZ, "m", "W"),))
FOOT_POSE = Signal("foot_pose", "One foot's TCP in the plant.", _POSE, per_foot=True)
JOINT_POSITION = Signal("joint_position", "In the plant.", (Field("q", JOINTS, "rad"),))
JOINT_VELOCITY = Signal("joint_velocity", "In the plant.", (Field("q_dot", JOINTS, "rad/s"),))

_TRUTH = (TORSO_POSE, COM_POSITION, FOOT_POSE, JOINT_POSITION, JOINT_VELOCITY)

LOGGED: dict[str, Signal] = {
    of_foot(signal.name, foot): signal
    for signal in (*SIGNALS.values(), *_TRUTH)
    if signal.logged
    for foot in (FEET if signal.per_foot else ("",))
}
"""Every signal of a record by its name there; those of one foot end in _l or _r."""
