"""How far a loop is from instability: gain, phase, delay and disk margins, SISO and MIMO."""

from dataclasses import dataclass

import control
import numpy as np
from scipy.linalg import matrix_balance

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.frequency import frequency_grid, frequency_response
from lola_drake.linear.poles import UNSTABLE, spectral_radius


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
        phase: that may be lost at the most critical gain crossover (deg).
        phase_frequency: that crossover (Hz).
        delay: that may be added (s).
        disk: radius of the disk margin, for gain and phase errors at once (balanced, 0 to 2).
        disk_frequency: where it is reached (Hz).
        peak_sensitivity: of S = 1/(1 + L), its largest gain.
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
    disk: float
    disk_frequency: float
    peak_sensitivity: float


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


def margins(loop: control.StateSpace) -> Margins:
    """Return the margins of a loop transfer with one input and one output.

    Raises:
        AnalysisError: if it has more; see `loop_margins` and `matrix_margins`.
    """
    if loop.D.shape != (1, 1):
        raise AnalysisError(f"a loop of {loop.D.shape[0]} signals has no margins of one signal")
    response = frequency_response(loop, frequency_grid(loop))
    frequencies, L = response.frequencies, response.values[:, 0, 0]
    up, up_at, down, down_at = _gain_margins(frequencies, L)
    phase, phase_at, delay = _phase_margins(frequencies, L)
    worst = np.abs((1 - L) / (1 + L)) / 2
    return Margins(
        name=loop.input_labels[0],
        stable=closed_loop_is_stable(loop),
        gain_up=up,
        gain_up_frequency=up_at,
        gain_down=down,
        gain_down_frequency=down_at,
        phase=phase,
        phase_frequency=phase_at,
        delay=delay,
        disk=float(1 / worst.max()),
        disk_frequency=float(frequencies[worst.argmax()]),
        peak_sensitivity=float(np.abs(1 / (1 + L)).max()),
    )


def loop_margins(loop: control.StateSpace) -> list[Margins]:
    """Return the margins of every signal of a loop, all its other signals being closed."""
    return [margins(one_loop(loop, k)) for k in range(loop.ninputs)]


def matrix_margins(loop: control.StateSpace, count: int = 1500) -> MatrixMargins:
    """Return the margins of all signals of a loop at once, by singular values.

    Channels of different units are balanced at every frequency, so the result does not depend on
    units. Errors of the channels are independent of each other but may be complex: the margin is
    on the safe side.

    Args:
        loop: the loop transfer.
        count: of the frequencies looked at.
    """
    response = frequency_response(loop, frequency_grid(loop, count))
    one = np.eye(loop.ninputs)
    S = np.linalg.inv(one + response.values)
    disk = 1 / np.array([_balanced_norm(matrix) for matrix in S - 0.5 * one])
    peak = np.array([_balanced_norm(matrix) for matrix in S])
    return MatrixMargins(
        names=tuple(loop.input_labels),
        stable=closed_loop_is_stable(loop),
        disk=float(disk.min()),
        disk_frequency=float(response.frequencies[disk.argmin()]),
        peak_sensitivity=float(peak.max()),
        peak_sensitivity_frequency=float(response.frequencies[peak.argmax()]),
    )


def closed_loop_is_stable(loop: control.StateSpace) -> bool:
    """Return whether negative feedback of the loop is stable."""
    return closed_radius(loop) < 1 + UNSTABLE


def closed_radius(loop: control.StateSpace) -> float:
    """Return the spectral radius of the loop closed by negative feedback."""
    feedback = np.linalg.solve(np.eye(loop.ninputs) + loop.D, loop.C)
    return spectral_radius(loop.A - loop.B @ feedback)


def one_loop(loop: control.StateSpace, k: int) -> control.StateSpace:
    """Return the loop of signal k alone, all other signals of the loop being closed."""
    others = np.delete(np.arange(loop.ninputs), k)
    D = np.eye(len(others)) + loop.D[np.ix_(others, others)]
    gain = np.linalg.solve(D, np.column_stack([loop.C[others], loop.D[others, k]]))
    from_states, from_input = gain[:, :-1], gain[:, -1:]
    return control.StateSpace(
        loop.A - loop.B[:, others] @ from_states,
        loop.B[:, [k]] - loop.B[:, others] @ from_input,
        loop.C[[k]] - loop.D[[k]][:, others] @ from_states,
        loop.D[[k]][:, [k]] - loop.D[[k]][:, others] @ from_input,
        loop.dt,
        inputs=[loop.input_labels[k]],
        outputs=[loop.output_labels[k]],
        states=loop.state_labels,
        remove_useless_states=False,
    )


def _gain_margins(frequencies: np.ndarray, L: np.ndarray) -> tuple[float, float, float, float]:
    """Return the factors of gain that lead to L = -1 next above and below 1, and where."""
    at, values = _crossings(frequencies, L.imag, L)
    # The response begins and ends on the real axis, just outside the sampled frequencies.
    for end in (0, -1):
        if abs(L[end].imag) < 0.05 * abs(L[end].real):
            at, values = np.append(at, frequencies[end]), np.append(values, L[end])
    negative = values.real < 0
    factors, at = -1 / values.real[negative], at[negative]
    up, up_at, down, down_at = np.inf, np.nan, 0.0, np.nan
    if (factors >= 1).any():
        k = np.where(factors >= 1, factors, np.inf).argmin()
        up, up_at = factors[k], at[k]
    if (factors < 1).any():
        k = np.where(factors < 1, factors, 0.0).argmax()
        down, down_at = factors[k], at[k]
    return float(up), float(up_at), float(down), float(down_at)


def _phase_margins(frequencies: np.ndarray, L: np.ndarray) -> tuple[float, float, float]:
    """Return the smallest phase error (deg) that leads to L = -1, where, and the delay (s)."""
    at, values = _crossings(frequencies, np.log(np.abs(L) + 1e-300), L)
    if not at.size:
        return np.inf, np.nan, np.inf
    lag = np.mod(np.angle(values) + np.pi, 2 * np.pi)
    lead = 2 * np.pi - lag
    k = np.minimum(lag, lead).argmin()
    delay = (lag / (2 * np.pi * at)).min()
    return float(np.degrees(min(lag[k], lead[k]))), float(at[k]), float(delay)


def _crossings(
    frequencies: np.ndarray, signal: np.ndarray, L: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return where a signal changes its sign, and L there, both interpolated."""
    k = np.flatnonzero(np.sign(signal[1:]) * np.sign(signal[:-1]) < 0)
    part = signal[k] / (signal[k] - signal[k + 1])
    return (
        frequencies[k] + part * (frequencies[k + 1] - frequencies[k]),
        L[k] + part * (L[k + 1] - L[k]),
    )


def _balanced_norm(matrix: np.ndarray) -> float:
    """Return the largest singular value after balancing the channels' units."""
    if len(matrix) > 1:
        _, (scale, _) = matrix_balance(np.abs(matrix), permute=False, separate=True)
        matrix = matrix * scale / scale[:, None]
    return float(np.linalg.norm(matrix, 2))
