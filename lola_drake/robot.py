"""LOLA: the model files, the names of its joints and frames, and the controller's kinematics."""

from collections.abc import Sequence
from functools import cached_property
from math import atan2

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable, ModelInstanceIndex

from lola_drake.paths import models_dir
from lola_drake.signals import FEET, JOINTS
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.contact_model import Pad
from lola_drake.theory.leg_masses import LegModel

PADS = (
    Pad(x=-0.095, y=0.09, length=0.08, width=0.04),
    Pad(x=-0.095, y=-0.09, length=0.08, width=0.04),
    Pad(x=0.095, y=0.09, length=0.08, width=0.04),
    Pad(x=0.095, y=-0.09, length=0.08, width=0.04),
)
"""The four pads of a foot relative to its TCP: rear left, rear right, front left, front right."""

FOOT_TASK = 6
"""Size of one foot's task: x, y, z, sin gamma_x, sin gamma_y, gamma_z."""

Rows = Sequence[Sequence[float]]
"""A matrix, row by row: an array, or plain numbers where speed matters."""

JOINT_INDEX = {name: i for i, name in enumerate(JOINTS)}


def add_lola(plant: MultibodyPlant) -> ModelInstanceIndex:
    """Parse LOLA into the plant (before Finalize) and return its model instance."""
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(models_dir() / "package.xml"))
    (instance,) = parser.AddModels(url="package://lola_models/lola/lola.urdf")
    return instance


class Kinematics:
    """The controller's own model of the robot, seen from the torso.

    The torso is taken as upright and at rest: positions and Jacobians are those of the task
    space, the feet relative to the CoM in the torso frame T. Call `update` first.
    """

    def __init__(self):
        self.plant = MultibodyPlant(time_step=0.0)
        add_lola(self.plant)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.mass = self.plant.CalcTotalMass(self.context)
        self._positions = np.zeros(self.plant.num_positions())
        self._positions[0] = 1.0
        self._world = self.plant.world_frame()
        self._tcp = [self.plant.GetFrameByName(f"tcp_{foot}") for foot in FEET]
        self._origin = np.zeros(3)
        self.w = np.zeros(2 * FOOT_TASK)
        self.jacobian = np.zeros((2 * FOOT_TASK, len(JOINTS)))
        # The task's rates out of those of the feet (angular, linear) and the momentum.
        self._to_task = np.zeros((2 * FOOT_TASK, 2 * FOOT_TASK + 3))
        self._rates = np.zeros((2 * FOOT_TASK + 3, self.plant.num_velocities()))
        for i in (0, FOOT_TASK):
            self._to_task[i : i + 3, i + 3 : i + 6] = np.eye(3)
            self._to_task[i : i + 3, -3:] = -np.eye(3) / self.mass

    def update(self, q: np.ndarray) -> None:
        """Compute w and its Jacobian (rates of w per joint rate) at the joint angles q (24)."""
        self._positions[7:] = q
        plant, context = self.plant, self.context
        plant.SetPositions(context, self._positions)
        # The torso's rows of the mass matrix are the momentum: of the moving joints, and, through
        # the lever arm of the CoM, of the moving torso.
        inertia = plant.CalcMassMatrix(context)
        c_x, c_y, c_z = (inertia.item(*entry) / self.mass for entry in ((2, 4), (0, 5), (1, 3)))
        self._com = (c_x, c_y)
        self._rates[-3:] = inertia[3:6]
        w = []
        for i, frame in zip((0, FOOT_TASK), self._tcp, strict=True):
            self._rates[i : i + 6] = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, frame, self._origin, self._world, self._world
            )
            pose = frame.CalcPoseInWorld(context).GetAsMatrix34().tolist()
            (_, _, _, x), (_, _, _, y), (_, _, _, z) = pose
            w += [x - c_x, y - c_y, z - c_z, *foot_angles(pose)]
            self._to_task[i + 3 : i + 6, i : i + 3] = foot_angle_rates(pose)
        self.w[:] = w
        self.jacobian = self._to_task.dot(self._rates[:, 6:])

    def pads(self, foot: int) -> tuple[np.ndarray, np.ndarray]:
        """Return where the pads' centres of one foot (0 left, 1 right) are after `update`.

        Returns:
            x and y relative to the TCP in T (m), shape (4, 2), in the order of `PADS`; and the
            rates of their heights over the CoM per joint rate, shape (4, 24).
        """
        tcp = self.w[FOOT_TASK * foot : FOOT_TASK * foot + 2]
        com_height_rates = self._rates[-1, 6:] / self.mass
        points, rates = [], []
        for frame, p_BPads in self._pad_points[foot]:
            p_WPads = self.plant.CalcPointsPositions(self.context, frame, p_BPads, self._world)
            jacobian = self.plant.CalcJacobianTranslationalVelocity(
                self.context, JacobianWrtVariable.kV, frame, p_BPads, self._world, self._world
            )
            points.append(p_WPads[:2].T - self._com - tcp)
            rates.append(jacobian[2::3, 6:] - com_height_rates)
        return np.concatenate(points), np.concatenate(rates)

    @cached_property
    def _pad_points(self) -> list[list[tuple[Frame, np.ndarray]]]:
        """Per foot, the bodies that carry the pads and the pads' centres in their frames."""
        context = self.plant.CreateDefaultContext()
        centres = np.array([[pad.x, pad.y, 0.0] for pad in PADS]).T
        return [
            [
                (frame, self.plant.CalcPointsPositions(context, tcp, p_TcpPads, frame))
                for frame, p_TcpPads in (
                    (self.plant.GetFrameByName(f"foot_{foot}"), centres[:, :2]),
                    (self.plant.GetFrameByName(f"zf{foot}"), centres[:, 2:]),
                )
            ]
            for foot, tcp in zip(FEET, self._tcp, strict=True)
        ]

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


def foot_angles(rotation: Rows) -> tuple[float, float, float]:
    """Return sin gamma_x, sin gamma_y (independent rotations about T's axes) and gamma_z.

    Args:
        rotation: R_TF, the foot's orientation in T, or its whole pose [R_TF p_TF].
    """
    (r00, *_), (r10, *_), (r20, r21, *_) = rotation
    return r21, -r20, atan2(r10, r00)


def foot_angle_rates(rotation: Rows) -> np.ndarray:
    """Return the matrix that takes the foot's angular velocity in T to the rates of its angles."""
    (r00, r01, *_), (r10, r11, *_), (r20, *_) = rotation
    lean = r20 / (r00 * r00 + r10 * r10)
    return np.array([[r11, -r01, 0.0], [-r10, r00, 0.0], [-lean * r00, -lean * r10, 1.0]])


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
