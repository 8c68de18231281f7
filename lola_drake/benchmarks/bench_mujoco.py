"""Drake's plant beside the same robot in MuJoCo: what it weighs, how it stands, and how fast.

An independent check of the model: both engines hold the same servo targets and walk after the same
commands, and MuJoCo's inverse dynamics says which torques Drake's walk needs. And the step time of
the engine that one would otherwise take, with the same ground, and with MuJoCo's own contacts.
"""

from collections.abc import Callable
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydrake.systems.analysis import Simulator

from lola_drake.benchmarks.bare_plant import Motion, bare_plant, record_commands, record_motion
from lola_drake.benchmarks.bench import TURN, Engine, spread, steady_walk, time_to_advance
from lola_drake.benchmarks.mujoco_twin import Twin, inverse_dynamics
from lola_drake.mujoco_model import mujoco_model
from lola_drake.plant import plant_truth
from lola_drake.scenario import Scenario
from lola_drake.signals import FEET, JOINTS, PERIOD

if TYPE_CHECKING:
    from mujoco import MjModel

SETTLE, AVERAGE = 4.0, 2.0
"""How long the robots stand before anything is compared, and over what time (s): they sway."""

GROUPS = {
    "pelvis": ("tbr", "tba"),
    "hips": ("thr", "tha", "thf"),
    "knees": ("tkf",),
    "ankles": ("tsa", "tsf"),
    "toes": ("tzf",),
    "arms": ("taf", "taa", "tef"),
    "head": ("tvp", "tvt"),
}
"""The joints whose torques are of one size, by the first letters of their names."""

_DRAKE, _SAME, _OWN = "drake", "mujoco_same_ground", "mujoco_own_contact"


class Engines(NamedTuple):
    """The same robot in both engines; in MuJoCo by the kind of ground."""

    drake: Simulator
    twins: dict[str, Twin]

    def named(self) -> dict[str, Engine]:
        """Return all by their names in the report."""
        return {_DRAKE: self.drake, **self.twins}


class _Stand(NamedTuple):
    """How a robot stands: mass (kg), height of the CoM (m), force per foot (N), torques (Nm)."""

    mass: float
    com_height: float
    vertical_force: dict[str, float]
    torque: np.ndarray


def bench_mujoco(repeats: int = 5, progress: Callable[[int], None] | None = None) -> dict[str, Any]:
    """Measure and return what bench.json has under "mujoco".

    Args:
        repeats: number of strides that are measured.
        progress: called with the number of strides measured so far.
    """
    # One stride more, which is not timed but recorded.
    scenario, begin, stride = steady_walk(repeats + 1)
    commands = record_commands(scenario, begin + (repeats + 1) * stride)
    hold = np.tile(commands[0], (round((SETTLE + AVERAGE) / PERIOD) + 1, 1))
    standing, walking = _engines(scenario, hold), _engines(scenario, commands)
    standing_us = _step_times(standing.named(), 0.0, SETTLE / repeats, repeats)
    statics = _statics(standing)
    for engine in walking.named().values():
        engine.AdvanceTo(begin)
    walking_us = _step_times(walking.named(), begin, stride, repeats, progress)
    motion = record_motion(walking.drake, round(stride / PERIOD))
    return {
        "version": version("mujoco"),
        "step_us": {"standing": _spreads(standing_us), "walking": _spreads(walking_us)},
        "drake_over_mujoco": {"standing": _ratios(standing_us), "walking": _ratios(walking_us)},
        "strides_upright": {name: len(taken) for name, taken in walking_us.items()},
        "statics": statics,
        "walk": torque_comparison(walking.twins[_SAME].model, motion),
    }


def _engines(scenario: Scenario, commands: np.ndarray) -> Engines:
    """Return the same robot in Drake and, with two kinds of ground, in MuJoCo."""
    drake = Simulator(bare_plant(scenario, commands))
    plant = drake.get_system().GetSubsystemByName("plant")
    q = plant.GetPositions(plant.GetMyContextFromRoot(drake.get_context()))
    servos, ground = scenario.control.servos, scenario.terrain
    twins = {
        _SAME: Twin(mujoco_model(servos, ground), q, commands),
        _OWN: Twin(mujoco_model(servos, ground, own_contact=True), q, commands),
    }
    return Engines(drake, twins)


def _step_times(
    engines: dict[str, Engine],
    begin: float,
    stretch: float,
    repeats: int,
    progress: Callable[[int], None] | None = None,
) -> dict[str, list[float]]:
    """Return the time per tick (us) of every stretch that an engine was upright to the end of."""
    step_us: dict[str, list[float]] = {name: [] for name in engines}
    upright = dict(engines)
    turns = round(stretch / TURN)
    for repeat in range(repeats):
        taken = dict.fromkeys(upright, 0.0)
        for turn in range(turns):
            until = begin + (repeat + (turn + 1) / turns) * stretch
            for name, engine in upright.items():
                taken[name] += time_to_advance(engine, until)
        upright = {name: engine for name, engine in upright.items() if not _has_fallen(engine)}
        for name in upright:
            step_us[name].append(taken[name] / stretch * PERIOD * 1e6)
        if progress is not None:
            progress(repeat + 1)
    return step_us


def _has_fallen(engine: Engine) -> bool:
    return isinstance(engine, Twin) and engine.has_fallen()


def _spreads(step_us: dict[str, list[float]]) -> dict[str, object]:
    return {name: spread(taken) if taken else None for name, taken in step_us.items()}


def _ratios(step_us: dict[str, list[float]]) -> dict[str, object]:
    """Return how much longer Drake's step takes than MuJoCo's, while that was upright."""
    drake = step_us[_DRAKE]
    return _spreads(
        {
            name: [ours / theirs for ours, theirs in zip(drake, taken, strict=False)]
            for name, taken in step_us.items()
            if name != _DRAKE
        }
    )


def _statics(engines: Engines) -> dict[str, Any]:
    """Compare weights and, on average over some time, how the robots stand.

    Torques about the hips' adduction axes differ most: the feet push each other apart a little,
    and MuJoCo's friction gives way to that, slowly. The toes come next, for MuJoCo's pads rest on
    their corners.
    """
    ticks = round(AVERAGE / PERIOD)
    ours = _stand(engines.drake, ticks)
    theirs = {name: _twin_stand(twin, ticks) for name, twin in engines.twins.items()}
    torque = ours.torque
    differences = {name: stand.torque - torque for name, stand in theirs.items()}
    told = {
        name: {
            "mass_kg": stand.mass,
            "com_height_m": stand.com_height,
            "vertical_force_N": stand.vertical_force,
        }
        for name, stand in {_DRAKE: ours, **theirs}.items()
    }
    return told | {
        "joint_torque_Nm": {
            "rms": _rms(torque),
            "difference_rms": {name: _rms(difference) for name, difference in differences.items()},
            "difference_worst": {
                name: float(np.abs(difference).max()) for name, difference in differences.items()
            },
        }
    }


def _stand(drake: Simulator, ticks: int) -> _Stand:
    """Return how the robot stands in Drake, on average over some ticks."""
    plant = drake.get_system().GetSubsystemByName("plant")
    motion = record_motion(drake, ticks)
    com = plant_truth(plant, np.hstack([motion.q, motion.v]))["com_position"]
    robot = [plant.GetModelInstanceByName("lola")]
    return _Stand(
        mass=plant.CalcTotalMass(plant.CreateDefaultContext(), robot),
        com_height=float(com[:, 2].mean()),
        vertical_force=_per_foot(motion.sole_wrench[:, :, 2].mean(axis=0)),
        torque=motion.torque.mean(axis=0),
    )


def _twin_stand(twin: Twin, ticks: int) -> _Stand:
    """Return the same of the robot in MuJoCo."""
    heights, forces, torques = [], [], []
    for _ in range(ticks):
        twin.AdvanceTo((twin.ticks + 1) * PERIOD)
        heights.append(twin.com_height())
        forces.append(twin.vertical_forces())
        torques.append(twin.joint_torques())
    return _Stand(
        mass=float(twin.model.body_mass.sum()),
        com_height=float(np.mean(heights)),
        vertical_force=_per_foot(np.mean(forces, axis=0)),
        torque=np.mean(torques, axis=0),
    )


def _per_foot(forces: np.ndarray) -> dict[str, float]:
    return dict(zip(FEET, forces.reshape(len(FEET), -1).sum(axis=1).tolist(), strict=True))


def torque_comparison(model: "MjModel", motion: Motion) -> dict[str, object]:
    """Compare the torques of a motion in Drake with those that MuJoCo finds necessary for it.

    Returns:
        Under "joint_torque", by group of joints: the RMS torque, the RMS and the greatest
        difference (Nm), and the ratio of the two RMS values. Under "unexplained", what would have
        to push and turn the torso, at most: force (N) and torque (Nm).
    """
    needed = inverse_dynamics(model, motion)
    difference = needed[:, 6:] - motion.torque
    groups = {}
    for group, beginnings in GROUPS.items():
        joints = [i for i, joint in enumerate(JOINTS) if joint.startswith(beginnings)]
        rms, rms_difference = _rms(motion.torque[:, joints]), _rms(difference[:, joints])
        groups[group] = {
            "rms_Nm": rms,
            "difference_rms_Nm": rms_difference,
            "difference_worst_Nm": float(np.abs(difference[:, joints]).max()),
            "relative": rms_difference / rms,
        }
    return {
        "joint_torque": groups,
        "unexplained": {
            "force_N": float(np.abs(needed[:, :3]).max()),
            "torque_Nm": float(np.abs(needed[:, 3:6]).max()),
        },
    }


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
