"""One foot and its force law, stepped tick by tick, for the tests of the force laws."""

import numpy as np
from ticking import Ticking

from lola_drake.blocks.foot_force_control import FootForceControlParams
from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.controller import shared
from lola_drake.robot import PADS
from lola_drake.signals import CONTACT, GAIT_PHASE
from lola_drake.theory.contact_model import ServoCompliance, contact_matrix
from lola_drake.theory.foot_wrench import FootSensor
from lola_drake.theory.sensed_contact import pad_model

AREA_STIFFNESS = 1.2e5 / sum(pad.area for pad in PADS)
U = contact_matrix(PADS, AREA_STIFFNESS)
STIFF = ServoCompliance(np.zeros((3, 3)), relaxation=0.014)
SENSOR = FootSensor(p_TcpSensor=(-0.03, 0.01, 0.08), weight=20.0, p_TcpFoot=(0.02, 0.005, 0.04))


class Foot(Ticking):
    """The block of one foot, the left one unless it is said; by default all is at rest."""

    def __init__(self, law=HybridForceControl, foot="l", common=None, **params):
        constants = {
            **shared(common or FootForceControlParams()),
            "inverse_contact_matrix": np.linalg.inv(U),
            "compliance": STIFF.matrix,
            "relaxation": STIFF.relaxation,
            "sensor": SENSOR,
            "sole": pad_model(PADS, AREA_STIFFNESS),
        }
        self.params, self.side = law.Params(**params), "lr".index(foot)
        super().__init__(law(self.params, foot, **constants))

    def blend(self, value):
        self.fix("gait_phase", value, GAIT_PHASE.slice("blend").start + self.side)

    def plan(self, support):
        self.fix("gait_phase", support, GAIT_PHASE.slice("support").start + self.side)

    def touch(self, pads):
        self.fix("contact", pads, CONTACT.slice(("pads_l", "pads_r")[self.side]))

    def desire(self, wrench, rate=(0.0, 0.0, 0.0)):
        self.fix("desired_wrench", wrench, slice(3 * self.side, 3 * self.side + 3))
        self.fix("desired_wrench", rate, slice(6 + 3 * self.side, 9 + 3 * self.side))

    def press(self, force, torque=(0.0, 0.0)):
        """Let the ground carry the foot with a force and torques T_x, T_y at the TCP."""
        on_foot = force - SENSOR.weight
        (x, y, _), weight = SENSOR.p_TcpSensor, SENSOR.weight
        p_x, p_y, _ = SENSOR.p_TcpFoot
        t_x, t_y = torque
        measured = [0.0, 0.0, on_foot]
        measured += [t_x - y * on_foot - weight * p_y, t_y + x * on_foot + weight * p_x, 0.0]
        self.fix("measured_wrench", measured, slice(6 * self.side, 6 * self.side + 6))

    def modification(self):
        return self.output("task_modification")


def foot_angles(rotation: np.ndarray) -> tuple[float, float, float]:
    """Return sin gamma_x, sin gamma_y and gamma_z of a foot by its orientation R_TF."""
    return rotation[2, 1], -rotation[2, 0], np.arctan2(rotation[1, 0], rotation[0, 0])
