"""What there is to see at one time of a recorded run, beside the robot itself."""

from dataclasses import dataclass

import numpy as np

from lola_drake.figures.footprints import pressure_point, zero_moment_point
from lola_drake.results import Result
from lola_drake.scenario import Ground
from lola_drake.signals import FEET, GROUND_FORCE


@dataclass(frozen=True)
class Frame:
    """What the markers show at one time, everything in W.

    Attributes:
        torso: x, y, z (m), roll, pitch, yaw (rad), shape (6,).
        com: Centre of mass (m), shape (3,).
        zmp: On the ground (m), shape (3,); NaN where nothing is loaded.
        forces: Ground force on the left and right foot (N), shape (2, 3).
        origins: Where they act (m), shape (2, 3).
    """

    torso: np.ndarray
    com: np.ndarray
    zmp: np.ndarray
    forces: np.ndarray
    origins: np.ndarray


def frame_samples(times: np.ndarray, per_second: float) -> np.ndarray:
    """Return which samples of a run are the frames of a film."""
    frames = np.arange(times[0], times[-1] + 1e-9, 1 / per_second)
    return np.searchsorted(times, frames - 1e-9)


def frames_at(result: Result, samples: np.ndarray) -> list[Frame]:
    """Return what there is to see at some samples of a run."""
    signals = {name: values[samples] for name, values in result.signals.items()}
    return frames_of(signals, result.scenario.ground)


def frames_of(signals: dict[str, np.ndarray], ground: Ground) -> list[Frame]:
    """Return what there is to see in each row of the signals."""
    zmp = zero_moment_point(signals)
    heights = [ground.height_at(*p) if np.isfinite(p).all() else np.nan for p in zmp]
    forces = [signals["ground_force"][:, GROUND_FORCE.slice(f"F_{foot}")] for foot in FEET]
    origins = [
        np.column_stack([pressure_point(signals, foot), signals[f"foot_pose_{foot}"][:, 2]])
        for foot in FEET
    ]
    return [
        Frame(
            torso=torso,
            com=signals["com_position"][i],
            zmp=np.r_[zmp[i], heights[i]],
            forces=np.array([force[i] for force in forces]),
            origins=np.array([origin[i] for origin in origins]),
        )
        for i, torso in enumerate(signals["torso_pose"])
    ]
