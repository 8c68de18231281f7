"""What is said of a margin: of one signal, and of several at once."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Margins:
    """The margins of a loop, alone or as one of several.

    Attributes:
        name: of the signal at which the loop is opened.
        stable: whether the closed loop is stable; if not, the margins say how far it is from that.
        gain_up: the gain may grow by this factor; infinite if by any.
        gain_up_frequency: where it is reached then (Hz).
        gain_down: the gain may shrink by this factor; 0 if by any.
        gain_down_frequency: where it is reached then (Hz).
        phase: that may be lost, or won, at the most critical gain crossover (deg).
        phase_frequency: that crossover (Hz).
        delay: that may be added (s).
        delay_frequency: the crossover at which it is reached (Hz), not always that of the phase.
        disk: radius of the disk margin, for gain and phase errors at once (balanced, 0 to 2).
        disk_frequency: where it is reached (Hz).
        peak_sensitivity: of S = 1/(1 + L), its largest gain.
        peak_sensitivity_frequency: where that is (Hz).
    """

    name: str
    stable: bool
    gain_up: float
    gain_up_frequency: float
    gain_down: float
    gain_down_frequency: float
    phase: float
    phase_frequency: float
    delay: float
    delay_frequency: float
    disk: float
    disk_frequency: float
    peak_sensitivity: float
    peak_sensitivity_frequency: float


@dataclass(frozen=True)
class MatrixMargins:
    """The margins of a loop that is opened at several signals at once.

    Attributes:
        names: of the signals.
        stable: whether the closed loop is stable.
        disk: gains and phases of all channels may be wrong at once, each within this disk.
        disk_frequency: where that is reached (Hz).
        peak_sensitivity: largest singular value of S = (1 + L)^-1, in units that balance it.
        peak_sensitivity_frequency: where that is (Hz).
    """

    names: tuple[str, ...]
    stable: bool
    disk: float
    disk_frequency: float
    peak_sensitivity: float
    peak_sensitivity_frequency: float


def disk_gain(disk: float) -> tuple[float, float]:
    """Return the factors by which the gain may shrink and grow within a disk margin."""
    return (2 - disk) / (2 + disk), (2 + disk) / (2 - disk) if disk < 2 else np.inf


def disk_phase(disk: float) -> float:
    """Return the phase (deg) that may be lost or gained within a disk margin."""
    return float(np.degrees(2 * np.arctan(disk / 2)))
