"""Momentum of the robot, to hold against forces: Newton."""

import numpy as np
from pydrake.math import RigidTransform

from lola_drake.robot import Kinematics
from lola_drake.signals import MEASURED_WRENCH
from lola_drake.theory.constants import GRAVITY


def upper_momentum(plant, context) -> tuple[np.ndarray, np.ndarray]:
    """Return spatial momentum [L, p] about the origin above the sensors, and gravity's rate."""
    feet = {"foot_l", "zfl", "foot_r", "zfr"}
    momentum, gravity = np.zeros(6), np.zeros(6)
    for index in plant.GetBodyIndices(plant.GetModelInstanceByName("lola")):
        body = plant.get_body(index)
        if body.name() in feet:
            continue
        inertia = body.CalcSpatialInertiaInBodyFrame(context)
        pose, velocity = body.EvalPoseInWorld(context), body.EvalSpatialVelocityInWorld(context)
        in_world = inertia.ReExpress(pose.rotation())
        p_com = pose.translation() + in_world.get_com()
        v_com = velocity.translational() + np.cross(velocity.rotational(), in_world.get_com())
        central = in_world.Shift(in_world.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        p = in_world.get_mass() * v_com
        momentum += np.r_[central @ velocity.rotational() + np.cross(p_com, p), p]
        weight = np.array([0.0, 0.0, -GRAVITY * in_world.get_mass()])
        gravity += np.r_[np.cross(p_com, weight), weight]
    return momentum, gravity


def load(X_WSensor: RigidTransform, reading: np.ndarray, foot: str) -> np.ndarray:
    """Return torque about the origin and force in W of what a foot's sensor reads."""
    force = X_WSensor.rotation() @ reading[MEASURED_WRENCH.slice(f"F_{foot}")]
    torque = X_WSensor.rotation() @ reading[MEASURED_WRENCH.slice(f"T_{foot}")]
    return np.r_[torque + np.cross(X_WSensor.translation(), force), force]


def force_residual(result) -> np.ndarray:
    """Return m c'' minus gravity and the ground's forces (N) in every tick, shape (n - 2, 3).

    A force that is recorded has acted from the tick before on.
    """
    com, force = result.signals["com_position"], result.signals["ground_force"]
    acceleration = np.diff(com, 2, axis=0) / np.diff(result.times[:2]) ** 2
    ground = force.reshape(-1, 2, 3).sum(axis=1)
    return Kinematics().mass * (acceleration + [0, 0, GRAVITY]) - ground[2:]
