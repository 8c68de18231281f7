"""What only one of the named analyses has to say, as tables."""

from collections.abc import Sequence

import control
import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from lola_drake.controller import initial_stance, pads_matrix, servo_compliances
from lola_drake.linear.frequency import frequency_response
from lola_drake.linear.isolated import own_context
from lola_drake.linear.linearize import state_space
from lola_drake.linear.studies.workpoint import Workpoint
from lola_drake.linear.text_table import Table
from lola_drake.robot import PADS, Kinematics
from lola_drake.scenario import Scenario
from lola_drake.signals import JOINTS, PERIOD
from lola_drake.theory.contact_model import command_gradient, contact_matrix

CONTACT_FREQUENCIES = (1.0, 5.0, 10.0, 20.0)
"""At which the contact is compared with its model (Hz)."""

_DIRECTIONS = ("sin_gamma_x", "sin_gamma_y", "z")
_LEG_JOINTS = tuple(joint for joint in JOINTS if len(joint) == 4 and joint[0] == "t")[:14]


def extra_tables(name: str, workpoint: Workpoint) -> list[Table]:
    """Return the tables that belong to a named analysis alone."""
    makers = {"contact": contact_table, "servo": servo_table}
    return [makers[name](workpoint)] if name in makers else []


def signals_of_tables(name: str) -> tuple[str, ...]:
    """Return the signals that the tables of a named analysis need."""
    if name == "contact":
        return ("contact_wrench_l",)
    return ("plant.state",) if name == "servo" else ()


def contact_table(workpoint: Workpoint) -> Table:
    """Compare U with the stiffness of the plant's contact, and with what the controller meets.

    The contact itself is the wrench of the left foot over the motion of its TCP against the
    ground; what the controller meets is the wrench over the commanded motion, with servos, the
    robot's own motion and the sensor between them.
    """
    scenario = workpoint.scenario
    U = controllers_gradient(scenario)
    ground = contact_matrix(PADS, scenario.ground.stiffness / sum(pad.area for pad in PADS))
    contact, met = contact_responses(workpoint, CONTACT_FREQUENCIES)
    rows = [("U of the controller", "", *_three(np.diag(U)))]
    rows += [("U of the ground", "", *_three(np.diag(ground)))]
    for kind, values in (("contact in the plant", contact), ("met by the controller", met)):
        for frequency, matrix in zip(CONTACT_FREQUENCIES, values, strict=True):
            rows.append((kind, f"{frequency:g} Hz", *_three(np.diag(matrix))))
    return Table(
        "The left foot's contact: gain, and phase against a spring",
        ("", "", "T_x (Nm)", "T_y (Nm)", "F_z (N/m)"),
        tuple(rows),
    )


def controllers_gradient(scenario: Scenario) -> np.ndarray:
    """Return U that the controller takes for the left foot, by its command; shape (3, 3)."""
    kinematics, control = Kinematics(), scenario.control
    stance = initial_stance(scenario, kinematics)
    compliance, _ = servo_compliances(kinematics, stance.q, control.servos)
    met = compliance.within(control.force.time_constant)
    return command_gradient(pads_matrix(scenario), met)


def contact_responses(
    workpoint: Workpoint, frequencies: Sequence[float] | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the wrench of the left foot over its TCP's motion, and over the commanded motion.

    Both of shape (n, 3, 3); the command moves positions and rates together.
    """
    names = [f"task_command_l.{kind}.{name}" for kind in ("w", "w_dot") for name in _DIRECTIONS]
    model = state_space(
        workpoint.blocks,
        workpoint.select(names),
        workpoint.select(["contact_wrench_l"]),
        workpoint.select(["task_command_l", "task_command_r", "torso_orientation"]),
    )
    observed = _observing_tcp(workpoint, model)
    response = frequency_response(observed, np.array(frequencies)).values
    z = np.exp(2j * np.pi * np.array(frequencies) * model.dt)
    rate = ((z - 1) / model.dt)[:, None, None]
    together = response[:, :, :3] + rate * response[:, :, 3:]
    wrench, motion = together[:, :3], together[:, 3:]
    return wrench @ np.linalg.inv(motion), wrench


def _observing_tcp(workpoint: Workpoint, model: control.StateSpace) -> control.StateSpace:
    """Return the model with the TCP's sines and height in W as further outputs."""
    plant: MultibodyPlant = workpoint.situation.diagram.GetSubsystemByName("plant")
    jacobian = plant.CalcJacobianSpatialVelocity(
        own_context(plant, workpoint.situation.context),
        JacobianWrtVariable.kV,
        plant.GetFrameByName("tcp_l"),
        np.zeros(3),
        plant.world_frame(),
        plant.world_frame(),
    )
    positions = [i for i, name in enumerate(model.state_labels) if name.startswith("plant/q/")]
    tcp = np.zeros((3, model.nstates))
    tcp[:, positions] = jacobian[[0, 1, 5]]
    return control.StateSpace(
        model.A,
        model.B,
        np.vstack([model.C, tcp]),
        np.vstack([model.D, np.zeros((3, model.ninputs))]),
        model.dt,
        remove_useless_states=False,
    )


def servo_table(workpoint: Workpoint) -> Table:
    """Return the bandwidth of every leg joint: angle over commanded angle, the rate fed forward."""
    frequencies = np.geomspace(0.5, 200.0, 150)
    z = np.exp(2j * np.pi * frequencies * PERIOD)
    rate = (z - 1) / PERIOD
    opened, rows = workpoint.select(["joint_command"]), []
    for joint in _LEG_JOINTS:
        names = [f"joint_command.{kind}.{joint}" for kind in ("q", "q_dot")]
        model = state_space(
            workpoint.blocks,
            workpoint.select(names),
            workpoint.select([f"plant.state.q.{joint}"]),
            opened,
        )
        response = frequency_response(model, frequencies).values[:, 0]
        plain, fed = response[:, 0], response[:, 0] + rate * response[:, 1]
        peak = 20 * np.log10(np.abs(fed).max())
        rows.append(
            (joint, _bandwidth(frequencies, plain), _bandwidth(frequencies, fed), f"{peak:.1f}")
        )
    header = ("joint", "-3 dB, angle alone (Hz)", "with its rate (Hz)", "peak (dB)")
    return Table("Servos: from joint command to joint angle", header, tuple(rows))


def _bandwidth(frequencies: np.ndarray, response: np.ndarray) -> str:
    """Return the frequency from which on the gain is below -3 dB."""
    above = np.flatnonzero(np.abs(response) > np.sqrt(0.5))
    if not above.size:
        return "none"
    last = above[-1]
    return (
        f"> {frequencies[last]:.0f}" if last == len(frequencies) - 1 else f"{frequencies[last]:.1f}"
    )


def _three(values: np.ndarray) -> tuple[str, ...]:
    """Return the gains of three entries, and where they are not real their phase as a spring's."""
    texts = []
    for value in values:
        phase = np.degrees(np.angle(-value))
        texts.append(f"{abs(value):.0f}" + (f" at {phase:+.0f} deg" if np.iscomplex(value) else ""))
    return tuple(texts)
