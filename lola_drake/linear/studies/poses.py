"""Poses in which the robot stands still: on both feet or on one, with a frozen plan.

The walking pattern's signals are replaced by constants, in the context alone: its readers' inputs
are fixed there.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, Diagram

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import (
    discrete_state,
    fix_port,
    own_context,
    set_discrete_state,
)
from lola_drake.linear.wiring import Source, Wiring
from lola_drake.robot import Kinematics, posture, solve_posture
from lola_drake.scenario import Scenario
from lola_drake.signals import (
    CONTACT,
    FEET,
    GAIT_PHASE,
    IDEAL_WRENCH,
    JOINT_ANGLES,
    JOINTS,
    MEASURED_WRENCH,
    TASK_REFERENCE,
)
from lola_drake.theory.constants import GRAVITY


@dataclass(frozen=True)
class Pose:
    """A way to stand still.

    Attributes:
        load: the left foot's share of the weight; a foot without load hangs in the air.
        stride: by how much the left foot is ahead of the right one (m).
        width: distance of the feet sideways (m); None for the pattern's.
        height: of the CoM above the ground (m); None for the pattern's.
        lift: of a foot without load (m).
    """

    load: float = 0.5
    stride: float = 0.0
    width: float | None = None
    height: float | None = None
    lift: float = 0.03

    def __post_init__(self):
        if not 0 <= self.load <= 1:
            raise AnalysisError(f"a pose's load is between 0 and 1, not {self.load:g}")


def place(diagram: Diagram, context: Context, scenario: Scenario, pose: Pose) -> None:
    """Put the robot near a pose, and fix what the controller is told to it."""
    wiring = Wiring(diagram)
    kinematics = Kinematics()
    weight = kinematics.mass * GRAVITY
    feet = _feet(scenario, pose)
    shares = np.array([pose.load, 1 - pose.load])
    w = feet - [*_com(scenario, pose, feet), 0.0, 0.0, 0.0]
    w[:, 2] -= shares * weight / scenario.pattern.ground_stiffness
    try:
        q = solve_posture(kinematics, w.ravel(), posture(hip=0.4, knee=0.8))
    except ValueError as error:
        raise AnalysisError(f"the pose cannot be taken: {error}") from None
    _fix_plan(wiring, context, _plan(w, shares, weight))
    _put_posture(wiring, context, q, w, kinematics, scenario, shares)
    _put_forces(wiring, context, shares, weight)


def _feet(scenario: Scenario, pose: Pose) -> np.ndarray:
    """Return both feet on the ground as tasks x, y, z, sines, gamma_z; shape (2, 6)."""
    width = pose.width if pose.width is not None else scenario.pattern.step_width
    feet = np.zeros((2, 6))
    feet[:, 0] = 0.5 * pose.stride, -0.5 * pose.stride
    feet[:, 1] = 0.5 * width, -0.5 * width
    feet[:, 2] = pose.lift * (pose.load == 0.0), pose.lift * (pose.load == 1.0)
    return feet


def _com(scenario: Scenario, pose: Pose, feet: np.ndarray) -> np.ndarray:
    """Return where the CoM is over the load (m), shape (3,)."""
    pattern = scenario.pattern
    offsets = np.array([[pattern.zmp_forward, side * pattern.zmp_inward] for side in (-1, 1)])
    x, y = np.array([pose.load, 1 - pose.load]) @ (feet[:, :2] + offsets)
    return np.array([x, y, pose.height if pose.height is not None else pattern.com_height])


def _plan(w: np.ndarray, shares: np.ndarray, weight: float) -> dict[str, np.ndarray]:
    """Return what the walking pattern says to the others in the pose."""
    reference = np.zeros(TASK_REFERENCE.size)
    for foot, task in zip(FEET, w, strict=True):
        reference[TASK_REFERENCE.slice(f"w_{foot}")] = task
    phase = np.zeros(GAIT_PHASE.size)
    phase[GAIT_PHASE.slice("load")] = shares
    phase[GAIT_PHASE.slice("support")] = phase[GAIT_PHASE.slice("blend")] = shares > 0
    wrench = np.zeros(IDEAL_WRENCH.size)
    wrench[IDEAL_WRENCH.slice("F")] = 0.0, 0.0, weight
    return {"task_reference": reference, "gait_phase": phase, "ideal_wrench": wrench}


def _fix_plan(wiring: Wiring, context: Context, plan: dict[str, np.ndarray]) -> None:
    for name, value in plan.items():
        source: Source = wiring.select(name).source
        for target in wiring.targets(source):
            block = wiring.blocks[target.block]
            fix_port(block.get_input_port(target.port), own_context(block, context), value)


def _put_posture(wiring, context, q, w, kinematics, scenario, shares) -> None:
    """Give plant, inverse kinematics and servos the posture; loaded feet are in the ground."""
    plant = wiring.blocks["plant"]
    own = own_context(plant, context)
    stance = int(np.argmax(shares))
    sink = shares[stance] * kinematics.mass * GRAVITY / scenario.ground.stiffness
    p_TCom, _ = kinematics.centroidal_inertia(q)
    ground = scenario.terrain.height_at(0.0, 0.0)
    base = np.array([0.0, 0.0, ground - sink]) - w[stance, :3] - p_TCom
    positions = np.concatenate([[1.0, 0.0, 0.0, 0.0], base, q])
    plant.SetPositionsAndVelocities(own, np.concatenate([positions, np.zeros(len(q) + 6)]))
    _put_joint_angles(wiring, context, q)
    servos = _context(wiring, context, "joint_servos")
    line = discrete_state(servos).reshape(-1, 3 * len(JOINTS))
    line[:] = 0.0
    line[:, : len(JOINTS)] = q
    set_discrete_state(servos, line.ravel())


def _put_joint_angles(wiring: Wiring, context: Context, q: np.ndarray) -> None:
    """Give the commanded joint angles to the block that has them as state, whichever does it."""
    for block in wiring.blocks.values():
        declared = getattr(block, "block", None)
        parts = list(declared.states) if declared else []
        if JOINT_ANGLES.name in parts:
            state = own_context(block, context).get_mutable_discrete_state()
            state.get_mutable_value(parts.index(JOINT_ANGLES.name))[:] = q
            return
    set_discrete_state(_context(wiring, context, "inverse_kinematics"), q)


def _put_forces(wiring: Wiring, context: Context, shares: np.ndarray, weight: float) -> None:
    """Let the sensors, and the filter of the desired forces, know who carries how much."""
    measured = np.zeros(MEASURED_WRENCH.size)
    measured[[MEASURED_WRENCH.slice(f"F_{foot}").start + 2 for foot in FEET]] = shares * weight
    set_discrete_state(_context(wiring, context, "foot_force_sensor"), measured)
    desired = np.zeros(6)
    desired[[2, 5]] = shares * weight
    set_discrete_state(_context(wiring, context, "force_distribution"), desired)
    switches = _context(wiring, context, "contact_switches")
    state = discrete_state(switches)
    state[: CONTACT.size] = np.repeat(shares > 0, 4)
    set_discrete_state(switches, state)


def _context(wiring: Wiring, context: Context, name: str) -> Context:
    """Return the context of the only block of that name."""
    (path,) = (path for path in wiring.blocks if path.split(".")[-1] == name)
    return own_context(wiring.blocks[path], context)
