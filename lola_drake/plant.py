"""The plant: LOLA on its ground, in discrete time with hydroelastic contact."""

import logging

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddContactMaterial,
    Box,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import JointIndex
from pydrake.systems.framework import DiagramBuilder

from lola_drake.ground import Ground
from lola_drake.model_errors import ModelErrors
from lola_drake.obstacles import Obstacle
from lola_drake.robot import PADS, add_lola
from lola_drake.signals import FEET, PERIOD, of_foot
from lola_drake.walk import StartPose

# Drake warns that half spaces do not support deformable bodies; there are none.
logging.getLogger("drake").addFilter(lambda record: "deformable" not in record.getMessage())

SLAB = 0.1
"""Thickness of the compliant floor (m); with the modulus it gives the stiffness per area."""

PAD_FRICTION = 0.8
"""Of the pads in the robot's model file; what they rub on has such that both together have the
ground's."""

FALLEN = (0.55, np.deg2rad(45.0))
"""Height of the torso (m) below which, and inclination (rad) above which, the robot has fallen."""

MESH_SHARE = (3 - 3**0.5) / 2
"""Part of a pad's area that its mesh has: two triangles on its ends, whose centres are the Gauss
points of its length. The ground is as much stiffer per area."""

PAD_LINKS = tuple(
    of_foot(f"pad_{place}", foot)
    for foot in FEET
    for place in ("rear_left", "rear_right", "front_left", "front_right")
)
"""The links of the pads, in the order of the contact switches (0 to 7)."""


def add_plant(
    builder: DiagramBuilder,
    ground: Ground,
    errors: ModelErrors = ModelErrors(),  # noqa: B008  # frozen
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add LOLA on its ground to a diagram; the plant is not finalized yet."""
    config = MultibodyPlantConfig(
        time_step=PERIOD,
        contact_model="hydroelastic",
        discrete_contact_approximation="lagged",
        use_sampled_output_ports=False,
        stiction_tolerance=ground.friction_speed,
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    add_lola(plant, errors)
    add_ground(plant, ground)
    return plant, scene_graph


def add_ground(plant: MultibodyPlant, ground: Ground) -> None:
    """Add the floor and what lies on it.

    All has the stiffness per area c_A,z = E/d of the ground, but for what is softer or harder.
    """
    area_stiffness = ground.stiffness / (MESH_SHARE * sum(pad.area for pad in PADS))
    floor = _material(ground, ground.friction)
    AddCompliantHydroelasticPropertiesForHalfSpace(SLAB, area_stiffness * SLAB, floor)
    world = plant.world_body()
    plant.RegisterCollisionGeometry(world, RigidTransform(), HalfSpace(), "floor", floor)
    for board in ground.boards:
        size, pose = np.array(board.extent), board_pose(board)
        # A box is softest in its middle: its pressure rises to the modulus over half its height.
        modulus = board.relative_stiffness * area_stiffness * size.min() / 2
        properties = _material(ground, board.relative_friction * ground.friction)
        AddCompliantHydroelasticProperties(size.max(), modulus, properties)
        plant.RegisterCollisionGeometry(world, pose, Box(*size), board.name, properties)
        plant.RegisterVisualGeometry(world, pose, Box(*size), board.name, [*board.colour, 1.0])


def board_pose(board: Obstacle) -> RigidTransform:
    """Return where the middle of a board's box is in W."""
    angles = np.deg2rad([board.roll_deg, board.pitch_deg, board.heading_deg])
    top = np.array([*board.position, board.height])
    middle = top - 0.5 * board.extent[2] * np.array(board.normal)
    return RigidTransform(RollPitchYaw(angles), middle)


def _material(ground: Ground, friction: float) -> ProximityProperties:
    """Return the properties of something on which the pads have a friction coefficient.

    Drake takes the harmonic mean of that of both bodies.
    """
    own = friction * (PAD_FRICTION / (2 * PAD_FRICTION - friction))
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=ground.dissipation,
        friction=CoulombFriction(own, own),
        properties=properties,
    )
    return properties


def set_start(
    plant: MultibodyPlant, start: StartPose, ground: Ground, q: np.ndarray, p_PT: np.ndarray
) -> None:
    """Let the plant's default context begin at a place of the scenario.

    Args:
        plant: finalized.
        start: where the robot stands.
        ground: what it stands on.
        q: joint angles (rad), shape (24,).
        p_PT: the torso in the plan's frame, which lies between the feet (m), shape (3,).
    """
    heading = RigidTransform(
        RollPitchYaw(0.0, 0.0, np.deg2rad(start.heading_deg)),
        [start.x, start.y, ground.height_at(start.x, start.y)],
    )
    torso = plant.GetBodyByName("torso")
    plant.SetDefaultFloatingBaseBodyPose(torso, heading @ RigidTransform(p_PT))
    positions = plant.GetDefaultPositions()
    positions[7:] = q
    plant.SetDefaultPositions(positions)


def pad_joints(plant: MultibodyPlant) -> tuple[int, ...]:
    """Return the index of the weld joint of every pad, in the order of the switches (0 to 7)."""
    return tuple(int(plant.GetJointByName(name).index()) for name in PAD_LINKS)


def sole_joints(plant: MultibodyPlant) -> tuple[int, ...]:
    """Return the index of the weld joint of the left and the right force sensor."""
    return tuple(int(plant.GetJointByName(f"fts_{foot}").index()) for foot in FEET)


def pad_geometries(plant: MultibodyPlant) -> dict[int, int]:
    """Return which switch (0 to 7) belongs to which collision geometry, by the value of its id."""
    pads = {}
    for switch, joint in enumerate(pad_joints(plant)):
        body = plant.get_joint(JointIndex(joint)).child_body()
        (geometry,) = plant.GetCollisionGeometriesForBody(body)
        pads[geometry.get_value()] = switch
    return pads


def has_fallen(positions: np.ndarray) -> bool:
    """Return whether the torso is too low or too inclined to come back."""
    height, inclination = FALLEN
    w, x, y, z = positions[:4]
    upright = 1 - 2 * (x * x + y * y)
    return bool(positions[6] < height or upright < np.cos(inclination))


def plant_truth(plant: MultibodyPlant, states: np.ndarray) -> dict[str, np.ndarray]:
    """Return where the robot really was: poses in W, joint angles and rates, from plant states."""
    context = plant.CreateDefaultContext()
    frames = {
        "torso_pose": plant.GetFrameByName("torso"),
        "foot_pose_l": plant.GetFrameByName("tcp_l"),
        "foot_pose_r": plant.GetFrameByName("tcp_r"),
    }
    robot = [plant.GetModelInstanceByName("lola")]
    poses = {name: np.empty((len(states), 3, 4)) for name in frames}
    com = np.empty((len(states), 3))
    for k, q in enumerate(states[:, : plant.num_positions()]):
        plant.SetPositions(context, q)
        com[k] = plant.CalcCenterOfMassPositionInWorld(context, robot)
        for name, frame in frames.items():
            poses[name][k] = frame.CalcPoseInWorld(context).GetAsMatrix34()
    joints = slice(7, plant.num_positions())
    rates = slice(plant.num_positions() + 6, plant.num_multibody_states())
    return {name: _position_rpy(pose) for name, pose in poses.items()} | {
        "com_position": com,
        "joint_position": states[:, joints],
        "joint_velocity": states[:, rates],
    }


def _position_rpy(poses: np.ndarray) -> np.ndarray:
    """Return x, y, z (m), roll, pitch, yaw (rad) of poses [R p] of shape (n, 3, 4)."""
    roll = np.arctan2(poses[:, 2, 1], poses[:, 2, 2])
    pitch = np.arctan2(-poses[:, 2, 0], np.hypot(poses[:, 0, 0], poses[:, 1, 0]))
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    return np.column_stack([poses[:, :, 3], roll, pitch, yaw])
