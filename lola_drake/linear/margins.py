"""How far a loop is from instability: gain, phase, delay and disk margins, SISO and MIMO.

Extrema are refined and crossings solved on the exact response: no grid has a part in the result.
"""

from dataclasses import dataclass

import control
import numpy as np

from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.frequency import PER_DECADE, Transfer, frequency_grid
from lola_drake.linear.margin import Margins, MatrixMargins
from lola_drake.linear.poles import UNSTABLE, check_discrete, spectral_radius
from lola_drake.linear.refine import largest, zeros_of
from lola_drake.linear.tables import margin_table

ENDLESS = 1e9
"""A gain that may grow by this factor may grow by any: what is beyond is rounding."""


@dataclass(frozen=True)
class LoopMargins:
    """All margins of a loop.

    Attributes:
        each: of every signal, all its other signals being closed.
        together: of all its signals at once.
    """

    each: tuple[Margins, ...]
    together: MatrixMargins

    def _repr_html_(self) -> str:
        names = [margins.name for margins in self.each]
        title = names[0] if len(names) == 1 else f"{len(names)} signals, one at a time"
        table = margin_table(title, self.each)
        return f"{table.as_html()}<p>All at once: disk margin {self.together.disk:.2f}</p>"


def margins(loop: control.StateSpace) -> LoopMargins:
    """Return the margins of a loop transfer L, whose closed loop is 1/(1 + L).

    Args:
        loop: in discrete time, as `lola.open_loop` gives it; as many outputs as inputs.

    Raises:
        AnalysisError: if it is not such a loop.
    """
    _check(loop)
    each = tuple(signal_margins(one_loop(loop, k)) for k in range(loop.ninputs))
    return LoopMargins(each, matrix_margins(loop))


def signal_margins(loop: control.StateSpace) -> Margins:
    """Return the margins of a loop transfer with one input and one output.

    Raises:
        AnalysisError: if it has more; see `margins`.
    """
    _check(loop)
    if loop.ninputs != 1:
        raise AnalysisError(f"a loop of {loop.ninputs} signals has no margins of one signal")
    curve = _Curve(loop)
    up, up_at, down, down_at = _gain_margins(curve)
    phase, phase_at, delay, delay_at = _phase_margins(curve)
    worst, worst_at = curve.largest(lambda L: np.abs((1 - L) / (1 + L)) / 2)
    peak, peak_at = curve.largest(lambda L: np.abs(1 / (1 + L)))
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
        delay_frequency=delay_at,
        disk=1 / worst,
        disk_frequency=worst_at,
        peak_sensitivity=peak,
        peak_sensitivity_frequency=peak_at,
    )


def matrix_margins(loop: control.StateSpace, per_decade: int = PER_DECADE) -> MatrixMargins:
    """Return the margins of all signals of a loop at once, by singular values.

    Channels of different units are balanced at every frequency, so the result does not depend on
    units. Errors of the channels are independent of each other but may be complex: the margin is
    on the safe side.

    Args:
        loop: the loop transfer.
        per_decade: frequencies in every decade from which the search starts.
    """
    _check(loop)
    one, transfer, grid = np.eye(loop.ninputs), Transfer(loop), frequency_grid(loop, per_decade)

    def sensitivity(frequencies: np.ndarray) -> np.ndarray:
        return np.linalg.inv(one + transfer(frequencies))

    def largest_less(part: np.ndarray) -> tuple[float, float]:
        def norm(sensitivities: np.ndarray) -> np.ndarray:
            return _balanced_norm(sensitivities - part)

        return largest(lambda f: norm(sensitivity(f)), grid, norm(sampled))

    sampled = sensitivity(grid)
    disk, disk_frequency = largest_less(0.5 * one)
    peak, peak_frequency = largest_less(0.0 * one)
    return MatrixMargins(
        names=tuple(loop.input_labels),
        stable=closed_loop_is_stable(loop),
        disk=1 / disk,
        disk_frequency=disk_frequency,
        peak_sensitivity=peak,
        peak_sensitivity_frequency=peak_frequency,
    )


class _Curve:
    """A loop transfer of one signal over frequency, and functions of it."""

    def __init__(self, loop: control.StateSpace):
        self._transfer, self.grid = Transfer(loop), frequency_grid(loop)
        self.sampled = self(self.grid)

    def __call__(self, frequencies: np.ndarray) -> np.ndarray:
        return self._transfer(np.asarray(frequencies))[:, 0, 0]

    def largest(self, of) -> tuple[float, float]:
        """Return the largest value of a function of L, and where."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return largest(lambda f: of(self(f)), self.grid, of(self.sampled))

    def zeros(self, of) -> tuple[np.ndarray, np.ndarray]:
        """Return where a function of L crosses zero, and L there."""
        at = zeros_of(lambda f: of(self(f)), self.grid, of(self.sampled))
        return at, self(at)


def _gain_margins(curve: _Curve) -> tuple[float, float, float, float]:
    """Return the factors of gain that lead to L = -1 next above and below 1, and where."""
    # Over |L|, so that the curve comes near zero only where L comes near the real axis.
    at, values = curve.zeros(lambda L: L.imag / (np.abs(L) + 1e-300))
    ends, at_ends = _real_ends(curve)
    at, values = np.append(at, at_ends), np.append(values, ends)
    negative = values.real * ENDLESS < -1
    factors, at = -1 / values.real[negative], at[negative]
    up, up_at, down, down_at = np.inf, np.nan, 0.0, np.nan
    if (factors >= 1).any():
        k = np.where(factors >= 1, factors, np.inf).argmin()
        up, up_at = factors[k], at[k]
    if ((factors < 1) & (factors * ENDLESS > 1)).any():
        k = np.where(factors < 1, factors, 0.0).argmax()
        down, down_at = factors[k], at[k]
    return float(up), float(up_at), float(down), float(down_at)


def _real_ends(curve: _Curve) -> tuple[list[float], list[float]]:
    """Return L at rest and at Nyquist, where it is real if it is finite."""
    first, second = curve.sampled[:2]
    ends, at = [curve.sampled[-1].real], [curve.grid[-1]]
    # Below the grid nothing bends L any more: it is constant, or grows without end.
    if abs(first - second) < 1e-2 * abs(first) and abs(first.imag) < 1e-2 * abs(first):
        ends, at = [*ends, first.real], [*at, 0.0]
    return ends, at


def _phase_margins(curve: _Curve) -> tuple[float, float, float, float]:
    """Return the phase error (deg) and the delay (s) that lead to L = -1, and where each does."""
    at, values = curve.zeros(lambda L: np.log(np.abs(L) + 1e-300))
    if not at.size:
        return np.inf, np.nan, np.inf, np.nan
    lag = np.mod(np.angle(values) + np.pi, 2 * np.pi)
    error, delay = np.minimum(lag, 2 * np.pi - lag), lag / (2 * np.pi * at)
    k, late = error.argmin(), delay.argmin()
    return float(np.degrees(error[k])), float(at[k]), float(delay[late]), float(at[late])


def _check(loop: control.StateSpace) -> None:
    check_discrete("margins", loop)
    if loop.ninputs != loop.noutputs or not loop.ninputs:
        raise AnalysisError(
            f"a loop has as many outputs as inputs, not {loop.noutputs} and {loop.ninputs}"
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


def _balanced_norm(matrices: np.ndarray, sweeps: int = 8) -> np.ndarray:
    """Return the largest singular value of each matrix after balancing the channels' units.

    Osborne's iteration: every channel in turn gets the unit that makes its row and its column
    equally large, which brings the matrix's Frobenius norm to its minimum.

    Args:
        matrices: shape (n, m, m).
        sweeps: over all channels.
    """
    m = matrices.shape[-1]
    scale, size = np.ones(matrices.shape[:2]), np.abs(matrices) ** 2
    size *= 1 - np.eye(m)
    tiny = 1e-12 * size.sum(axis=(1, 2)) + 1e-300
    for _ in range(sweeps if m > 1 else 0):
        for i in range(m):
            column = (size[:, :, i] * scale**2).sum(axis=1) / scale[:, i] ** 2
            row = (size[:, i] / scale**2).sum(axis=1) * scale[:, i] ** 2
            scale[:, i] *= ((column + tiny) / (row + tiny)) ** 0.25
    return np.linalg.norm(matrices * scale[:, :, None] / scale[:, None, :], 2, axis=(1, 2))
