"""LOLA in MuJoCo, made from the URDF that Drake reads.

MuJoCo reads links, joints, damping, and limits of angle and torque from the URDF itself. What that
file says to Drake alone is added here: the free torso, the rotors' inertia as armature, the pads;
and what no URDF says: the servos and the ground. MuJoCo gives the place of a free body before its
quaternion (w, x, y, z), and the angular velocity in the body's own frame.

Without the package mujoco, importing this raises an AnalysisError that names the extra.
"""

import xml.etree.ElementTree as ElementTree
from copy import copy

import numpy as np

from lola_drake.benchmarks.bare_plant import SOLES, Motion
from lola_drake.blocks.joint_servos import JointServosParams
from lola_drake.linear.errors import AnalysisError
from lola_drake.paths import models_dir
from lola_drake.plant import has_fallen
from lola_drake.robot import PADS
from lola_drake.scenario import Ground
from lola_drake.signals import JOINTS, PERIOD

try:
    import mujoco
except ImportError:
    raise AnalysisError("MuJoCo needs a package: pip install 'lola_drake[bench]'") from None

PAD_THICKNESS = 0.01
"""Of the boxes (m); only their lower faces touch."""

IMPEDANCE = 0.5
"""Of the contacts, 0 to 1: with less, their springs are unstable at 1 ms; with more, impacts are
spread over more mass than the feet have."""

_DRAKE = "{http://drake.mit.edu}"
_CORNERS = 4


def mujoco_twin(
    servos: JointServosParams, ground: Ground, *, own_contact: bool = False
) -> mujoco.MjModel:
    """Return LOLA on a level floor in MuJoCo, with 24 servos in the order of `JOINTS`.

    A servo's control is the torque that it would give at angle and rate zero, see
    `servo_control`. Obstacles are left out.

    Args:
        servos: gains.
        ground: the floor's stiffness, dissipation and friction. The corners of the pads stand on
            springs that are together as stiff as Drake's ground under a whole foot.
        own_contact: leave stiffness, damping and friction cone as MuJoCo has them by default.
    """
    urdf = ElementTree.parse(models_dir() / "lola" / "lola.urdf").getroot()
    armature, pads = _armatures(urdf), _pad_places(urdf)
    for link in urdf.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(urdf, encoding="unicode"))
    # The force sensors are fixed joints: the soles must stay links of their own.
    spec.compiler.fusestatic = False
    spec.option.timestep = PERIOD
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.body("torso").add_freejoint()
    for name in JOINTS:
        spec.joint(name).armature = armature[name]
        _add_servo(spec, name, servos, armature[name])
    _add_floor(spec, pads, ground.friction)
    model = spec.compile()
    if not own_contact:
        _take_ground(model, ground)
    return model


def _armatures(urdf: ElementTree.Element) -> dict[str, float]:
    """Return what the joints feel of their rotors' inertia (kg m^2), by joint."""
    return {
        drive.find("joint").get("name"): (
            float(drive.find(f"actuator/{_DRAKE}gear_ratio").get("value")) ** 2
            * float(drive.find(f"actuator/{_DRAKE}rotor_inertia").get("value"))
        )
        for drive in urdf.iter("transmission")
    }


def _pad_places(urdf: ElementTree.Element) -> list[tuple[str, list[float]]]:
    """Return the link that carries every pad, and the middle of its lower face there (m).

    The pads' own links, which have no mass, are taken out.
    """
    places = []
    for joint in [joint for joint in urdf.findall("joint") if joint.get("name").startswith("pad_")]:
        place = [float(value) for value in joint.find("origin").get("xyz").split()]
        places.append((joint.find("parent").get("link"), place))
        urdf.remove(joint)
    for link in [link for link in urdf.findall("link") if link.get("name").startswith("pad_")]:
        urdf.remove(link)
    return places


def _add_servo(spec: mujoco.MjSpec, joint: str, servos: JointServosParams, armature: float) -> None:
    damping = servos.velocity_bandwidth * armature
    servo = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    servo.gainprm[0] = 1.0
    servo.biasprm[1:3] = -servos.position_gain * damping, -damping


def _add_floor(spec: mujoco.MjSpec, pads: list[tuple[str, list[float]]], friction: float) -> None:
    """Add the pads and a floor that meets them, and nothing else."""
    # Contacts are those of the pairs alone: nothing collides by its type.
    alone = {"contype": 0, "conaffinity": 0}
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0], **alone
    )
    half = [PADS[0].length / 2, PADS[0].width / 2, PAD_THICKNESS / 2]
    for number, (link, (x, y, z)) in enumerate(pads):
        name, place = f"pad_{number}", [x, y, z + half[2]]
        spec.body(link).add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=place, **alone
        )
        pair = spec.add_pair(geomname1="floor", geomname2=name, condim=3)
        pair.friction[:2] = friction


def _take_ground(model: mujoco.MjModel, ground: Ground) -> None:
    """Make the corners of the pads together as stiff and damped as the ground under a foot is.

    MuJoCo takes stiffness and damping per mass, of which it has an estimate for every body, and
    counts them (1 - impedance) times. Damping is that of Hunt and Crossley under half the weight.
    """
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    damping = ground.dissipation * 0.5 * model.body_mass.sum() * -model.opt.gravity[2]
    springs = _CORNERS * len(PADS)
    for pair, pad in enumerate(model.pair_geom2):
        scale = (1 - IMPEDANCE) * model.body_invweight0[model.geom_bodyid[pad], 0] / springs
        model.pair_solref[pair] = -scale * ground.stiffness, -scale * damping
    model.pair_solimp[:, :2] = IMPEDANCE
    # Along the floor there is no spring, only what holds a foot in its place.
    model.pair_solreffriction[:] = 2 * PERIOD, 1.0


def servo_control(model: mujoco.MjModel, commands: np.ndarray) -> np.ndarray:
    """Return the controls that make MuJoCo's servos do what Drake's do.

    Args:
        model: from `mujoco_twin`.
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
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, q[:4])
    return np.concatenate([v[3:6], rotation.reshape(3, 3).T @ v[:3], v[6:]])


def inverse_dynamics(model: mujoco.MjModel, motion: Motion) -> np.ndarray:
    """Return what the drives must do for a motion under given loads on the soles.

    The joints' damping counts at the end of a step, as in Drake.

    Returns:
        Force (N) on the torso in W, torque (Nm) in its own frame, both zero if the motion is
        possible at all, and the torques of the joints (Nm), shape (n, 30).
    """
    model = copy(model)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_INVDISCRETE
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    soles = [model.body(name).id for name in SOLES]
    needed = np.empty((len(motion.q), model.nv))
    for k, (q, v, v_dot) in enumerate(zip(motion.q, motion.v, motion.v_dot, strict=True)):
        data.qpos, data.qvel, data.qacc = to_qpos(q), to_qvel(q, v), to_qvel(q, v_dot)
        mujoco.mj_inverse(model, data)
        needed[k] = data.qfrc_inverse
        for sole, wrench in zip(soles, motion.sole_wrench[k], strict=True):
            load = np.zeros(model.nv)
            mujoco.mj_applyFT(model, data, wrench[:3], wrench[3:], np.zeros(3), sole, load)
            needed[k] -= load
    return needed


class Twin:
    """The robot in MuJoCo with servos that get the commands of a table, one row per tick."""

    def __init__(self, model: mujoco.MjModel, q: np.ndarray, commands: np.ndarray):
        """Put the robot somewhere, at rest.

        Args:
            model: from `mujoco_twin`.
            q: Drake's positions, shape (31,).
            commands: as for `bare_plant`.
        """
        self.model, self.ticks = model, 0
        self._data, self._controls = mujoco.MjData(model), servo_control(model, commands)
        self._data.qpos = to_qpos(q)
        self._torso = model.body("torso").id

    def AdvanceTo(self, time: float) -> None:
        """Simulate until then (s); named as that of Drake's Simulator is, to take turns with it."""
        while self.ticks < round(time / PERIOD):
            self._data.ctrl = self._controls[self.ticks]
            mujoco.mj_step(self.model, self._data)
            self.ticks += 1

    def has_fallen(self) -> bool:
        """Return whether the torso is too low or too inclined to come back."""
        return has_fallen(np.concatenate([self._data.qpos[3:7], self._data.qpos[:3]]))

    def com_height(self) -> float:
        """Return the height of the CoM over the floor (m) at the begin of the last tick."""
        return self._data.subtree_com[self._torso, 2]

    def joint_torques(self) -> np.ndarray:
        """Return the torques of the drives in the last tick (Nm), shape (24,)."""
        return self._data.qfrc_actuator[6:].copy()

    def vertical_forces(self) -> np.ndarray:
        """Return the floor's force on each of `SOLES` in the last tick (N), shape (4,)."""
        forces, load = np.zeros(len(SOLES)), np.zeros(6)
        for i, contact in enumerate(self._data.contact):
            # The floor is level, so a contact's normal is the vertical.
            mujoco.mj_contactForce(self.model, self._data, i, load)
            sole = self.model.body(self.model.geom_bodyid[contact.geom[1]]).name
            forces[SOLES.index(sole)] += load[0]
        return forces
