"""LOLA: the model files, the names of its joints and frames, and the controller's kinematics."""

from functools import cached_property

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from lola_drake.model_errors import ModelErrors, robot_urdf
from lola_drake.paths import models_dir
from lola_drake.signals import FEET, JOINTS
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.contact_model import Pad
from lola_drake.theory.kinematics import (
    KinematicTree,
    body_poses,
    com_motion,
    feet_motion,
    pads_motion,
)
from lola_drake.theory.leg_masses import LegModel

PADS = (
    Pad(x=-0.095, y=0.09, length=0.08, width=0.04),
    Pad(x=-0.095, y=-0.09, length=0.08, width=0.04),
    Pad(x=0.095, y=0.09, length=0.08, width=0.04),
    Pad(x=0.095, y=-0.09, length=0.08, width=0.04),
)
"""The four pads of a foot relative to its TCP: rear left, rear right, front left, front right."""

_PAD_LINKS = ("foot_", "foot_", "zf", "zf")
"""The links that carry the pads: the rear ones the foot, the front ones the toe."""

JOINT_INDEX = {name: i for i, name in enumerate(JOINTS)}


def add_lola(
    plant: MultibodyPlant,
    errors: ModelErrors = ModelErrors(),  # noqa: B008  # frozen
) -> ModelInstanceIndex:
    """Parse LOLA into the plant (before Finalize) and return its model instance."""
    parser = Parser(plant)
    parser.package_map().AddPackageXml(models_dir() / "package.xml")
    (instance,) = parser.AddModelsFromString(robot_urdf(errors), "urdf")
    return instance


class Kinematics:
    """The controller's own model of the robot, seen from the torso.

    The torso is taken as upright and at rest: positions and Jacobians are those of the task
    space, the feet relative to the CoM in the torso frame T. Call `update` first.

    Attributes:
        plant, context: Drake's model; the context has the joint angles of the last `update`.
        mass: of the robot (kg).
        tree: the same model as plain data, for laws.
        w, jacobian: the feet's task, shape (12,), and its rates per joint rate, shape (12, 24).
    """

    def __init__(self):
        self.plant = MultibodyPlant(time_step=0.0)
        add_lola(self.plant)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.mass = self.plant.CalcTotalMass(self.context)
        self._world = self.plant.world_frame()
        self.tree = kinematic_tree(self.plant)
        self.update(np.zeros(len(JOINTS)))

    def update(self, q: np.ndarray) -> None:
        """Compute w and its Jacobian at the joint angles q (rad), shape (24,)."""
        self.plant.SetPositions(self.context, np.r_[1.0, np.zeros(6), q])
        R, p, axes = body_poses(q, self.tree)
        com, com_rates = com_motion(R, p, axes, self.tree)
        self._motion = R, p, axes, com, com_rates
        self.w, self.jacobian = feet_motion(*self._motion, self.tree)

    def pads(self, foot: int) -> tuple[np.ndarray, np.ndarray]:
        """Return where the pads of one foot (0 left, 1 right) are, see `pads_motion`."""
        return pads_motion(foot, *self._motion, self.tree)

    def centroidal_inertia(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the CoM in T (m), shape (3,), and the inertia about it (kg m^2), shape (3, 3)."""
        self.update(q)
        bodies = self.plant.GetBodyIndices(self.plant.GetModelInstanceByName("lola"))
        inertia = self.plant.CalcSpatialInertia(self.context, self._world, bodies)
        com = inertia.get_com()
        return com, inertia.Shift(com).CalcRotationalInertia().CopyToFullMatrix3()

    @cached_property
    def position_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper hardware limits of the joints (rad)."""
        return self.plant.GetPositionLowerLimits()[7:], self.plant.GetPositionUpperLimits()[7:]

    @cached_property
    def velocity_limits(self) -> np.ndarray:
        """Return the joints' greatest speeds (rad/s)."""
        return self.plant.GetVelocityUpperLimits()[6:]

    @cached_property
    def effort_limits(self) -> np.ndarray:
        """Return the joints' greatest torques (Nm)."""
        return self.plant.GetEffortUpperLimits()


def kinematic_tree(plant: MultibodyPlant) -> KinematicTree:
    """Return the tree of joints of LOLA's model as plain data."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.r_[1.0, np.zeros(plant.num_positions() - 1)])
    joints = [plant.GetJointByName(name) for name in JOINTS]
    joints.sort(key=lambda joint: joint.position_start())
    mover = {plant.GetBodyByName("torso").index(): 0}
    mover |= {joint.child_body().index(): k + 1 for k, joint in enumerate(joints)}
    carrier = {
        joint.child_body().index(): joint.parent_body().index()
        for joint in map(plant.get_joint, plant.GetJointIndices())
    }

    def body_of(index) -> int:
        while index not in mover:
            index = carrier[index]
        return mover[index]

    def pose(frame):
        return frame.CalcPoseInWorld(context)

    parent = np.array([body_of(joint.parent_body().index()) for joint in joints])
    origin = np.zeros((len(joints) + 1, 3))
    origin[1:] = [pose(joint.frame_on_child()).translation() for joint in joints]
    axis = np.array([pose(j.frame_on_child()).rotation() @ j.revolute_axis() for j in joints])
    mass, moment = np.zeros(len(origin)), np.zeros(origin.shape)
    for index in plant.GetBodyIndices(plant.GetModelInstanceByName("lola")):
        body, b = plant.get_body(index), body_of(index)
        p_WCom = pose(body.body_frame()) @ body.CalcCenterOfMassInBodyFrame(context)
        mass[b] += body.get_mass(context)
        moment[b] += body.get_mass(context) * (p_WCom - origin[b])
    moves = np.zeros((len(joints), len(origin)), dtype=int)
    for b in range(1, len(origin)):
        ancestor = b
        while ancestor:
            moves[ancestor - 1, b] = 1
            ancestor = parent[ancestor - 1]
    tcps = [plant.GetFrameByName(f"tcp_{foot}") for foot in FEET]
    tcp_body = np.array([body_of(tcp.body().index()) for tcp in tcps])
    pad_body = np.array(
        [
            [body_of(plant.GetBodyByName(f"{link}{foot}").index()) for link in _PAD_LINKS]
            for foot in FEET
        ]
    )
    centres = np.array([[pad.x, pad.y, 0.0] for pad in PADS])
    p_WPad = np.array([[pose(tcp) @ centre for centre in centres] for tcp in tcps])
    return KinematicTree(
        order=np.argsort(moves.sum(axis=0)[1:], kind="stable"),
        parent=parent,
        offset=origin[1:] - origin[parent],
        axis=axis,
        mass=mass,
        moment=moment,
        tcp_body=tcp_body,
        p_BTcp=np.array([pose(tcp).translation() for tcp in tcps]) - origin[tcp_body],
        R_BTcp=np.array([pose(tcp).rotation().matrix() for tcp in tcps]),
        moves=moves,
        pad_body=pad_body,
        p_BPad=p_WPad - origin[pad_body],
    )


def posture(hip: float, knee: float, *, elbow: float = 0.4, shoulder: float = 0.0) -> np.ndarray:
    """Return symmetric joint angles with bent legs and level feet (24, rad).

    Args:
        hip: flexion of the thigh forward (rad).
        knee: flexion of the knee (rad).
        elbow: flexion of the elbow (rad).
        shoulder: flexion of the upper arm backward (rad).
    """
    q = np.zeros(len(JOINTS))
    for name, angle in (("thf", -hip), ("tkf", knee), ("tsf", hip - knee)):
        q[JOINT_INDEX[name + "r"]], q[JOINT_INDEX[name + "l"]] = angle, -angle
    for name, angle in (("taf", shoulder), ("tef", -elbow)):
        q[JOINT_INDEX[name + "r"]], q[JOINT_INDEX[name + "l"]] = angle, -angle
    q[JOINT_INDEX["taar"]] = q[JOINT_INDEX["taal"]] = np.deg2rad(-10.0)
    return q


def solve_posture(kinematics: Kinematics, w: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return joint angles whose feet are at w (12), near q; ValueError if out of reach."""
    q = q.copy()
    for _ in range(100):
        kinematics.update(q)
        error = w - kinematics.w
        if np.abs(error).max() < 1e-10:
            return q
        jacobian = kinematics.jacobian
        q += jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-9 * np.eye(len(w)), error)
    raise ValueError(f"no posture reaches the feet within {np.abs(error).max():.1e}")


def leg_model(kinematics: Kinematics) -> LegModel:
    """Return the robot's lumped masses, taken from the full model in its zero pose."""
    plant, context = kinematics.plant, kinematics.context
    plant.SetPositions(context, np.r_[1.0, np.zeros(plant.num_positions() - 1)])
    groups = {
        "thigh": ["hfl"],
        "shank": ["kfl"],
        "foot": ["sal", "sfl", "foot_l", "zfl"],
    }
    inertias = {
        name: plant.CalcSpatialInertia(
            context, plant.world_frame(), [plant.GetBodyByName(b).index() for b in bodies]
        )
        for name, bodies in groups.items()
    }
    limbs = {body for bodies in groups.values() for body in bodies}
    limbs |= {body.removesuffix("l") + "r" for body in limbs}
    rest = [
        i
        for i in plant.GetBodyIndices(plant.GetModelInstanceByName("lola"))
        if plant.get_body(i).name() not in limbs
    ]
    body = plant.CalcSpatialInertia(context, plant.world_frame(), rest)

    def origin(link: str) -> np.ndarray:
        return plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(link)).translation()

    hip, knee, ankle = origin("hfl"), origin("kfl"), origin("sal")
    tcp = plant.GetFrameByName("tcp_l").CalcPoseInWorld(context).translation()
    transverse = {
        name: inertia.Shift(inertia.get_com()).CalcRotationalInertia().get_moments()[1]
        for name, inertia in inertias.items()
    }
    return LegModel(
        body_mass=body.get_mass(),
        p_TBody=body.get_com(),
        p_THip=hip,
        thigh_mass=inertias["thigh"].get_mass(),
        shank_mass=inertias["shank"].get_mass(),
        foot_mass=inertias["foot"].get_mass(),
        thigh_length=hip[2] - knee[2],
        shank_length=knee[2] - ankle[2],
        thigh_com=hip[2] - inertias["thigh"].get_com()[2],
        shank_com=knee[2] - inertias["shank"].get_com()[2],
        thigh_inertia=transverse["thigh"],
        shank_inertia=transverse["shank"],
        p_TcpAnkle=ankle - tcp,
        p_TcpFoot=inertias["foot"].get_com() - tcp,
    )


def foot_sensor_geometry(kinematics: Kinematics) -> tuple[list[float], float, list[float]]:
    """Return what lies below a foot's force sensor, in the foot frame with the TCP as origin.

    Returns:
        Position of the sensor (m), the weight below it (N), and that weight's CoM (m).
    """
    plant, context = kinematics.plant, kinematics.context
    plant.SetPositions(context, np.r_[1.0, np.zeros(plant.num_positions() - 1)])
    bodies = [plant.GetBodyByName(name) for name in ("foot_l", "zfl")]
    inertia = plant.CalcSpatialInertia(
        context, plant.world_frame(), [body.index() for body in bodies]
    )
    tcp = plant.GetFrameByName("tcp_l").CalcPoseInWorld(context).translation()
    sensor = bodies[0].EvalPoseInWorld(context).translation()
    weight = inertia.get_mass() * GRAVITY
    return (sensor - tcp).tolist(), weight, (inertia.get_com() - tcp).tolist()
