"""LOLA in MuJoCo, made from the URDF that Drake reads.

MuJoCo reads links, joints, damping, and limits of angle and torque from the URDF itself. What that
file says to Drake alone is added here: the free torso, the rotors' inertia as armature, the pads;
and what no URDF says: the servos, the force sensors, the ground. MuJoCo gives the place of a free
body before its quaternion (w, x, y, z), and the angular velocity in the body's own frame.

A pad touches the ground with four small balls, in the Gauss points of its rectangle: their springs
carry a pressure that is linear over the pad exactly, as the field of springs of the paper does.

Without the package mujoco, importing this raises a LolaError that names the extra.
"""

import xml.etree.ElementTree as ElementTree
from math import sqrt

import numpy as np

from lola_drake.blocks.joint_servos import JointServosParams
from lola_drake.errors import LolaError
from lola_drake.ground import Ground
from lola_drake.model_errors import ModelErrors, robot_urdf
from lola_drake.plant import PAD_LINKS, board_pose
from lola_drake.robot import PADS
from lola_drake.signals import FEET, JOINTS, PERIOD

try:
    import mujoco
except ImportError:
    raise LolaError("MuJoCo needs a package: pip install 'lola_drake[bench]'") from None

RADIUS = 0.005
"""Of the balls under a pad (m)."""

_DRAKE = "{http://drake.mit.edu}"
_BALL = mujoco.mjtGeom.mjGEOM_SPHERE
_GAUSS = tuple((i / sqrt(12), k / sqrt(12)) for i in (-1, 1) for k in (-1, 1))
"""Where the balls are, in lengths and widths of a pad from its middle."""


def mujoco_model(
    servos: JointServosParams,
    ground: Ground,
    *,
    own_contact: bool = False,
    errors: ModelErrors = ModelErrors(),  # noqa: B008  # frozen
) -> mujoco.MjModel:
    """Return LOLA on its ground in MuJoCo, with 24 servos in the order of `JOINTS`.

    A servo's control is the torque that it would give at angle and rate zero, see
    `servo_control`. The sensors give force (N) and torque (Nm) that hold each sole, and then the
    force that holds each pad, in their links' frames.

    Args:
        servos: gains.
        ground: its stiffness, dissipation, friction and boards. The balls under a foot stand on
            springs that are together as stiff as Drake's ground under it.
        errors: of masses and inertias; balls are no pads, whose stiffness is all the same.
        own_contact: leave stiffness, damping and friction cone as MuJoCo has them by default.
    """
    urdf = ElementTree.fromstring(robot_urdf(errors))
    armature = _armatures(urdf)
    for link in urdf.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(urdf, encoding="unicode"))
    # Force sensors and pads are fixed joints: what they carry must stay links of their own.
    spec.compiler.fusestatic = False
    spec.option.timestep = PERIOD
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.body("torso").add_freejoint()
    for name in JOINTS:
        spec.joint(name).armature = armature[name]
        _add_servo(spec, name, servos, armature[name])
    for foot in FEET:
        _add_sensors(spec, f"foot_{foot}", "force", "torque")
    _add_ground(spec, ground)
    model = spec.compile()
    if not own_contact:
        _take_ground(model, ground)
    return model


def _armatures(urdf: ElementTree.Element) -> dict[str, float]:
    """Return what the joints feel of their rotors' inertia (kg m^2), by joint."""
    return {
        _told(drive, "joint", "name"): (
            float(_told(drive, f"actuator/{_DRAKE}gear_ratio", "value")) ** 2
            * float(_told(drive, f"actuator/{_DRAKE}rotor_inertia", "value"))
        )
        for drive in urdf.iter("transmission")
    }


def _told(element: ElementTree.Element, path: str, attribute: str) -> str:
    """Return an attribute of what lies in an element; KeyError where it is not there."""
    found = element.find(path)
    if found is None:
        raise KeyError(path)
    return found.attrib[attribute]


def _add_servo(spec: mujoco.MjSpec, joint: str, servos: JointServosParams, armature: float) -> None:
    damping = servos.velocity_bandwidth * armature
    servo = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    servo.gainprm[0] = 1.0
    servo.biasprm[1:3] = -servos.position_gain * damping, -damping


def _add_sensors(spec: mujoco.MjSpec, link: str, *kinds: str) -> None:
    spec.body(link).add_site(name=link)
    for kind in kinds:
        spec.add_sensor(
            name=f"{kind}_{link}",
            type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=link,
        )


def _add_ground(spec: mujoco.MjSpec, ground: Ground) -> None:
    """Add floor and boards, the pads that meet them, and nothing else."""
    # Contacts are those of the pairs alone: nothing collides by its type.
    alone = {"contype": 0, "conaffinity": 0, "mass": 0.0}
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0], **alone
    )
    friction = {"floor": ground.friction}
    for board in ground.boards:
        pose = board_pose(board)
        friction[board.name] = board.relative_friction * ground.friction
        spec.worldbody.add_geom(
            name=board.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=0.5 * np.array(board.extent),
            pos=pose.translation(),
            quat=pose.rotation().ToQuaternion().wxyz(),
            **alone,
        )
    for link in PAD_LINKS:
        _add_sensors(spec, link, "force")
        for i, (x, y) in enumerate(_GAUSS):
            name, place = f"{link}_{i}", [x * PADS[0].length, y * PADS[0].width, RADIUS]
            spec.body(link).add_geom(name=name, type=_BALL, size=[RADIUS, 0, 0], pos=place, **alone)
            for thing, coefficient in friction.items():
                pair = spec.add_pair(geomname1=thing, geomname2=name, condim=3)
                pair.friction[:2] = coefficient


def _take_ground(model: mujoco.MjModel, ground: Ground) -> None:
    """Make the balls under a foot together as stiff, damped and rough as the ground under it.

    MuJoCo's force is m (a_ref - a) with a mass m of our choice, and a_ref = -k r - b v. Of a spring
    and a damper at the end of a step, K (r + PERIOD v') + B v' with v' = v + PERIOD a, that is
    m = PERIOD (B + PERIOD K), k = K / m, b = (B + PERIOD K) / m = 1 / PERIOD. Friction is such a
    damper, too, within its cone. Both are those of Hunt and Crossley, and of a friction that is
    full at `friction_speed`, under half the weight; MuJoCo has one ratio of both for all boards.
    """
    balls, weight = len(_GAUSS) * len(PADS), -model.body_mass.sum() * model.opt.gravity[2]
    load, on_floor = 0.5 * weight / balls, ground.stiffness / balls
    relative = {model.geom(board.name).id: board.relative_stiffness for board in ground.boards}
    under = np.where(model.geom_type[model.pair_geom1] == _BALL, model.pair_geom2, model.pair_geom1)
    stiffness = on_floor * np.array([relative.get(thing, 1.0) for thing in under])
    mass = PERIOD * (ground.dissipation * load + PERIOD * stiffness)
    sliding_mass = PERIOD * ground.friction * load / ground.friction_speed
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    floor_mass = PERIOD * (ground.dissipation * load + PERIOD * on_floor)
    model.opt.impratio = sliding_mass / floor_mass
    ball = np.where(model.geom_type[model.pair_geom1] == _BALL, model.pair_geom1, model.pair_geom2)
    # By its impedance MuJoCo takes a mass over that of the body, and divides k and b by it.
    share = mass * model.body_invweight0[model.geom_bodyid[ball], 0]
    impedance = share / (1 + share)
    model.pair_solimp[:, :2] = impedance[:, None]
    model.pair_solref[:, 0] = -impedance * stiffness / mass
    model.pair_solref[:, 1] = model.pair_solreffriction[:, 1] = -impedance / PERIOD
    model.pair_solreffriction[:, 0] = 0.0


def servo_control(model: mujoco.MjModel, commands: np.ndarray) -> np.ndarray:
    """Return the controls that make MuJoCo's servos do what Drake's do.

    Args:
        model: from `mujoco_model`.
        commands: q, q', feed-forward torque (rad, rad/s, Nm), shape (n, 72).

    Returns:
        Torques (Nm), shape (n, 24).
    """
    q, q_dot, feedforward = np.split(commands, 3, axis=-1)
    stiffness, damping = -model.actuator_biasprm[:, 1:3].T
    return stiffness * q + damping * q_dot + feedforward


def to_qpos(q: np.ndarray) -> np.ndarray:
    """Return MuJoCo's positions for Drake's, shape (..., 31)."""
    return np.concatenate([q[..., 4:7], q[..., :4], q[..., 7:]], axis=-1)


def to_qvel(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return MuJoCo's velocities for Drake's, or accelerations for accelerations.

    Args:
        q: Drake's positions, shape (31,).
        v: Drake's velocities, or accelerations, shape (30,).
    """
    return np.concatenate([v[3:6], _rotation(q[:4]).T @ v[:3], v[6:]])


def to_drake(qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """Return Drake's positions and velocities for MuJoCo's, shape (61,)."""
    turning = _rotation(qpos[3:7]) @ qvel[3:6]
    return np.concatenate([qpos[3:7], qpos[:3], qpos[7:], turning, qvel[:3], qvel[6:]])


def _rotation(quaternion: np.ndarray) -> np.ndarray:
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, quaternion)
    return rotation.reshape(3, 3)
