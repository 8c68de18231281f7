"""The contact model without small angles against the plant: a turned foot pressed on a slope."""

import numpy as np
import pytest
from one_foot import foot_angles
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from scipy.optimize import brentq

from lola_drake.plant import add_ground
from lola_drake.robot import JOINT_INDEX, PADS, Kinematics, add_lola, posture, solve_posture
from lola_drake.scenario import Ground, Obstacle
from lola_drake.theory.contact_model import contact_matrix
from lola_drake.theory.sensed_contact import foot_axes, inclined, turned

STIFFNESS = 2e5
U = contact_matrix(PADS, STIFFNESS / sum(pad.area for pad in PADS))
SLOPE = Obstacle(name="slope", size=(2.0, 2.0), height=0.4, pitch_deg=10.0)
YAW = np.radians(20.0)
DOWNHILL = np.array([np.cos(np.radians(10.0)), 0.0, -np.sin(np.radians(10.0))])


def flat_on(normal, yaw):
    """Return sin gamma_x, sin gamma_y, gamma_z of a foot that lies flat on a plane."""
    n = np.array(normal)
    heading = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    x_axis = heading - [0.0, 0.0, (n @ heading) / n[2]]
    x_axis /= np.linalg.norm(x_axis)
    return np.array(foot_angles(np.column_stack([x_axis, np.cross(n, x_axis), n])))


class Pressed:
    """LOLA with its left foot alone on the slope, in continuous time.

    The torso is upright, so that T's axes are those of the world.
    """

    def __init__(self):
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=0.0, contact_model="hydroelastic")
        self.plant, _ = AddMultibodyPlant(config, builder)
        add_lola(self.plant)
        add_ground(self.plant, Ground(stiffness=STIFFNESS, dissipation=0.0, obstacles=(SLOPE,)))
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.kinematics = Kinematics()

    def place(self, angles, depth):
        """Let the foot have these angles, its TCP this deep below the slope's surface."""
        q = posture(0.4, 0.8)
        self.kinematics.update(q)
        w = self.kinematics.w.copy()
        w[3:6], w[8] = angles, w[8] + 0.15
        q = solve_posture(self.kinematics, w, q)
        q[JOINT_INDEX["tzfl"]] = 0.0  # Solving turned the toe a little, with its pads.
        self.plant.SetPositions(self.context, np.r_[1.0, np.zeros(6), q])
        p = self.tcp()
        height = SLOPE.height_at(p[0], p[1]) - depth - p[2]
        self.plant.SetPositions(self.context, np.r_[1.0, np.zeros(5), height, q])

    def tcp(self):
        return self.plant.GetFrameByName("tcp_l").CalcPoseInWorld(self.context).translation()

    def wrench(self, speed):
        """Return the ground's force and torque at the TCP of a foot that slides downhill."""
        velocity = np.zeros(self.plant.num_velocities())
        velocity[3:6] = speed * DOWNHILL
        self.plant.SetVelocities(self.context, velocity)
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        force, torque = np.zeros(3), np.zeros(3)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            wrench = info.F_Ac_W()
            sign = np.sign(wrench.translational()[2])
            arm = info.contact_surface().centroid() - self.tcp()
            force += sign * wrench.translational()
            torque += sign * (wrench.rotational() + np.cross(arm, wrench.translational()))
        return force, torque

    def held(self):
        """Return T_x, T_y, F_z of a foot that friction holds: the ground's force is vertical.

        The plant's friction grows with the speed at which a foot creeps; the foot creeps as fast
        as it takes.
        """
        speed = brentq(lambda v: self.wrench(v)[0][0], 0.0, 1e-2, xtol=1e-9)
        force, torque = self.wrench(speed)
        assert np.abs(force[:2]).max() < 0.02 * force[2]
        return np.array([torque[0], torque[1], force[2]])


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.006, 0.0), (0.0, -0.006), (-0.004, 0.005)])
def test_the_wrench_of_a_turned_foot_on_a_slope_is_that_of_eq_6(tilt):
    """Of its own axes, within 2 %; by small angles about T's axes the torques err by a third."""
    pressed, flat = Pressed(), flat_on(SLOPE.normal, YAW)
    angles = flat + [*tilt, 0.0]
    pressed.place(angles, depth=0.003)
    wrench = pressed.held()
    x = np.array([*tilt, -0.003])
    alpha = inclined(foot_axes(*angles), (0.0, 0.0))
    assert alpha == pytest.approx(angles[:2])
    expected = np.array([*np.sqrt(1 - np.square(alpha)), 1.0]) * (U @ x)
    # Torques against those of a CoP 0.05 m away.
    scale = np.array([0.05, 0.05, 1.0]) * wrench[2]
    assert (np.array(turned(wrench, YAW)) - expected) / scale == pytest.approx(0.0, abs=0.02)
    if any(tilt):
        small = U @ x
        error = np.linalg.norm((wrench - small)[:2]) / np.linalg.norm(expected[:2])
        assert error == pytest.approx(2 * np.sin(YAW / 2), abs=0.05)
