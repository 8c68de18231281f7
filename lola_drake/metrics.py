"""Numbers that sum up a run: each a small pure function of its signals.

All take arrays with one row per sample, as in `Result.signals`; lengths are in m, times in s.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from lola_drake.limits import LIMITS, LOADED, Limits, Signals, beyond_limits
from lola_drake.logged import COM_POSITION, FOOT_POSE, TORSO_POSE
from lola_drake.record import between
from lola_drake.signals import (
    CONTACT_WRENCH,
    DESIRED_WRENCH,
    FEET,
    GAIT_PHASE,
    GROUND_FORCE,
    MODIFIED_WRENCH,
    TASK_COMMAND,
)
from lola_drake.theory.footholds import SOLE
from lola_drake.theory.rectangles import TOUCH

SETTLED = 0.5
"""The first half second does not count: the robot is set down on its feet."""

CALM = 0.5
"""An inclination (deg) that says nothing: walking undisturbed stays below."""

SMOOTHING = 41
"""Samples over which a parabola is fitted to the CoM's height for its acceleration (41 ms)."""

BLOCK = 5000
"""Samples that are looked at together."""

FOOT_HEIGHT = 0.1
"""From the sole to the ankle (m): what of one foot another one may meet."""


def metrics(times: np.ndarray, signals: Signals, limits: Limits) -> dict[str, Any]:
    """Return all metrics of a run (until its fall, if it falls), by the names of summary.json.

    Of a run that ends before it has settled little is said. Signals that lie on the disk are read
    some rows at a time, and no more is kept of them than one metric needs.
    """

    def each(law: Callable[[Signals], np.ndarray]) -> np.ndarray:
        return by_blocks(law, signals, len(times))

    def place_of(name: str) -> Callable[[Signals], np.ndarray]:
        return lambda rows: rows[name][:, :2]

    def walked() -> tuple[float, float, np.ndarray]:
        place = each(place_of("torso_pose"))
        gait = each(lambda rows: rows["gait_phase"])
        return distance(place, gait), mean_speed(times, place, gait), walking_part(gait)

    def stood() -> tuple[float, float]:
        force = each(lambda rows: rows["ground_force"])
        forces = [force[:, GROUND_FORCE.slice(f"F_{foot}")] for foot in FEET]
        feet = (each(place_of(f"foot_pose_{foot}")) for foot in FEET)
        return max_foot_force([f[settled:] for f in forces]), max(map(max_slip, feet, forces))

    def leant() -> tuple[dict[str, float], float | None]:
        torso = each(lambda rows: rows["torso_pose"])[settled:]
        return max_inclination(torso), settling_time(times[settled:], torso)

    def colliding(rows: Signals) -> np.ndarray:
        return feet_colliding(rows["foot_pose_l"], rows["foot_pose_r"])

    settled = int(np.searchsorted(times, SETTLED))
    way, speed, walking = walked()
    counted = walking if walking.any() else slice(settled, None)
    foot_force, slip = stood()
    inclination, settling = leant()
    height = COM_POSITION.slice("p").start + 2
    lifting = vertical_acceleration(times, each(lambda rows: rows["com_position"][:, height]))
    beyond = each(lambda rows: beyond_limits(rows, limits))[settled:]
    found = {
        "distance_m": way,
        "mean_speed_m_per_s": speed,
        "max_inclination_deg": inclination,
        "rms_torque_error_Nm": rms(each(torque_error)[counted]),
        "rms_torque_error_modified_Nm": rms(each(modified_torque_error)[counted]),
        "max_foot_force_N": foot_force,
        "max_slip_m": slip,
        "steps_with_feet_colliding": int(each(colliding).sum()),
        "settling_time_s": settling,
        "max_com_vertical_acceleration_m_per_s2": float(np.abs(lifting[settled:]).max(initial=0.0)),
        "drive_work_J": drive_work(times[counted], each(drive_power)[counted]),
        "steps_beyond_limits": dict(zip(LIMITS, beyond.sum(axis=0).tolist(), strict=True)),
    }
    if settled < len(times):
        return found
    said = ("distance_m", "mean_speed_m_per_s", "steps_with_feet_colliding")
    return {name: value if name in said else _unsaid(value) for name, value in found.items()}


def _unsaid(value: object) -> object:
    """Return a metric of which nothing can be said: None in the place of every number."""
    return dict.fromkeys(value) if isinstance(value, dict) else None


def by_blocks(law: Callable[[Signals], np.ndarray], signals: Signals, count: int) -> np.ndarray:
    """Return what a law says of each row, of which it sees some at a time."""
    first = law(between(signals, 0, BLOCK))
    whole = np.empty((count, *first.shape[1:]), first.dtype)
    whole[:BLOCK] = first
    for start in range(BLOCK, count, BLOCK):
        whole[start : start + BLOCK] = law(between(signals, start, start + BLOCK))
    return whole


def inclination_deg(torso_pose: np.ndarray) -> np.ndarray:
    """Return the torso's roll and pitch in degrees, shape (n, 2)."""
    return np.degrees(torso_pose[:, TORSO_POSE.slice("rpy")][:, :2])


def max_inclination(torso_pose: np.ndarray) -> dict[str, float]:
    """Return the largest inclination (deg) about x and y, without sign."""
    return _xy(np.abs(inclination_deg(torso_pose)).max(axis=0, initial=0.0))


def torque_error(signals: Signals) -> np.ndarray:
    """Return the torque about the CoM in T (Nm) by lambda_d minus the measured, shape (n, 2)."""
    desired = [DESIRED_WRENCH.slice(f"wrench_{foot}") for foot in FEET]
    wanted = _feet_torque(signals, [signals["desired_wrench"][:, wrench] for wrench in desired])
    return wanted - _measured_torque(signals)


def modified_torque_error(signals: Signals) -> np.ndarray:
    """Return the torque of Lambda_mod minus the measured in T (Nm), shape (n, 2).

    It also counts what the distribution could not ask of the feet. The horizontal forces, which
    nobody controls, count as those of Lambda_mod, at the height of the load.
    """
    modified, load = signals["modified_wrench"], signals["gait_phase"][:, GAIT_PHASE.slice("load")]
    z = [signals[f"task_command_{foot}"][:, TASK_COMMAND.slice("w").start + 2] for foot in FEET]
    height = (load * np.column_stack(z)).sum(axis=1)
    F_x, F_y = modified[:, MODIFIED_WRENCH.slice("F", 2)].T
    wanted = modified[:, MODIFIED_WRENCH.slice("T", 2)]
    by_horizontal_forces = np.column_stack([-height * F_y, height * F_x])
    return wanted - by_horizontal_forces - _measured_torque(signals)


def _measured_torque(signals: Signals) -> np.ndarray:
    wrench = CONTACT_WRENCH.slice("wrench")
    return _feet_torque(signals, [signals[f"contact_wrench_{foot}"][:, wrench] for foot in FEET])


def _feet_torque(signals: Signals, wrenches: list[np.ndarray]) -> np.ndarray:
    """Return the torque of both feet's T_x, T_y, F_z about the CoM, x and y, shape (n, 2).

    With r from the CoM to the TCP: the rows of R_f in eq. 18, T_x + r_y F_z and T_y - r_x F_z.
    """
    total = np.zeros((len(wrenches[0]), 2))
    for foot, wrench in zip(FEET, wrenches, strict=True):
        r = signals[f"task_command_{foot}"][:, TASK_COMMAND.slice("w")]
        T_x, T_y, F_z = wrench.T
        total = total + np.column_stack([T_x + r[:, 1] * F_z, T_y - r[:, 0] * F_z])
    return total


def rms(values: np.ndarray) -> dict[str, float]:
    """Return the root mean square of both columns; zero where there are no rows."""
    return _xy(np.sqrt(np.square(values).sum(axis=0) / max(len(values), 1)))


def walking_part(gait_phase: np.ndarray) -> np.ndarray:
    """Return which samples lie between the first lift-off and the last touchdown of the plan."""
    swinging = gait_phase[:, GAIT_PHASE.slice("support")].sum(axis=1) < 1.5
    later, earlier = np.cumsum(swinging) > 0, np.cumsum(swinging[::-1])[::-1] > 0
    return later & earlier


def touchdowns(gait_phase: np.ndarray) -> np.ndarray:
    """Return the samples at which the plan has finished one step more."""
    return np.flatnonzero(np.diff(gait_phase[:, GAIT_PHASE.index("step_index")]) > 0.5) + 1


def centre_line(torso_pose: np.ndarray, gait_phase: np.ndarray) -> np.ndarray:
    """Return where the torso is from step to step, in W, shape (steps - 1, 2).

    Midpoints of its positions at successive touchdowns: the sway to left and right cancels.
    """
    at = torso_pose[touchdowns(gait_phase), :2]
    return 0.5 * (at[1:] + at[:-1])


def distance(torso_pose: np.ndarray, gait_phase: np.ndarray) -> float:
    """Return the length of the torso's way from its first place over the centre line to its last.

    On a straight walk this is the distance covered, in a curve the length of the curve.
    """
    line = centre_line(torso_pose, gait_phase)
    return _length(np.vstack([torso_pose[:1, :2], line, torso_pose[-1:, :2]]))


def mean_speed(times: np.ndarray, torso_pose: np.ndarray, gait_phase: np.ndarray) -> float:
    """Return the mean speed of steady walking, along the centre line.

    The first step, which gathers speed, ends before that line; the last one, which brakes, is
    left out. A walk too short to be steady has its distance over its whole time.
    """
    steady = centre_line(torso_pose, gait_phase)[:-1]
    if len(steady) < 2:
        duration = np.ptp(times) if len(times) else 0.0
        return distance(torso_pose, gait_phase) / duration if duration else 0.0
    at = times[touchdowns(gait_phase)]
    middle = 0.5 * (at[1:] + at[:-1])[:-1]
    return _length(steady) / float(middle[-1] - middle[0])


def max_foot_force(ground_forces: list[np.ndarray]) -> float:
    """Return the largest vertical force of the ground on one foot (N)."""
    return float(max(force[:, 2].max(initial=0.0) for force in ground_forces))


def max_slip(foot_pose: np.ndarray, ground_force: np.ndarray) -> float:
    """Return how far the TCP of one foot moved along the ground in its worst step."""
    loaded = np.concatenate([[False], ground_force[:, 2] > LOADED, [False]])
    starts, ends = np.flatnonzero(np.diff(loaded)).reshape(-1, 2).T
    moved = foot_pose[ends - 1, :2] - foot_pose[starts, :2]
    return float(np.linalg.norm(moved, axis=1).max(initial=0.0))


def settling_time(times: np.ndarray, torso_pose: np.ndarray) -> float | None:
    """Return the time from the largest inclination until it stays below `CALM`.

    Zero if it never was above; None if it still is at the end.
    """
    size = np.linalg.norm(inclination_deg(torso_pose), axis=1)
    disturbed = np.flatnonzero(size >= CALM)
    if not len(disturbed):
        return 0.0
    if disturbed[-1] == len(times) - 1:
        return None
    return float(times[disturbed[-1] + 1] - times[np.argmax(size)])


def vertical_acceleration(times: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the second derivative of a height (m/s^2), shape (n,).

    It is that of the parabola which fits `SMOOTHING` samples around each sample best (Savitzky
    and Golay), and near the ends of the first or last parabola.
    """
    if len(times) < SMOOTHING:
        return np.zeros(len(times))
    period = (times[-1] - times[0]) / (len(times) - 1)
    reach = SMOOTHING // 2
    squares = np.arange(-reach, reach + 1) ** 2.0
    squares -= squares.mean()
    curvature = np.convolve(height, squares, "valid") / (squares @ squares)
    return np.pad(2 * curvature / period**2, reach, mode="edge")


def drive_power(signals: Signals) -> np.ndarray:
    """Return the power of all drives (W), shape (n,); what they brake counts as what they drive."""
    return np.abs(signals["joint_torque"] * signals["joint_velocity"]).sum(axis=1)


def drive_work(times: np.ndarray, power: np.ndarray) -> float:
    """Return the mechanical work of all drives (J) from their power (W) at times (s)."""
    return float(np.trapezoid(power, times))


def feet_colliding(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return where two feet that do not know of each other in the plant are one in the other.

    Their soles overlap, seen from above, and lie no further apart in height than a foot is high.

    Args:
        left: pose of the TCP, shape (n, 6).
        right: the same of the other foot.
    """
    apart, half = right[:, :2] - left[:, :2], np.divide(SOLE, 2)
    yaws = [pose[:, FOOT_POSE.slice("rpy").stop - 1] for pose in (left, right)]
    colliding = np.abs(right[:, 2] - left[:, 2]) < FOOT_HEIGHT
    # One of a rectangle's sides keeps the other out, or none does.
    for direction in (yaws[0], yaws[0] + np.pi / 2, yaws[1], yaws[1] + np.pi / 2):
        seen = [half @ np.abs([np.cos(direction - yaw), np.sin(direction - yaw)]) for yaw in yaws]
        distance = np.abs(apart[:, 0] * np.cos(direction) + apart[:, 1] * np.sin(direction))
        colliding &= distance < sum(seen) - TOUCH
    return colliding


def _length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _xy(pair: np.ndarray) -> dict[str, float]:
    return {"x": float(pair[0]), "y": float(pair[1])}
