"""Frequency responses of large discrete-time models, exact and fast."""

from dataclasses import dataclass

import control
import numpy as np
import scipy.linalg
from scipy.linalg.lapack import ztrtrs

from lola_drake.linear.poles import UNSTABLE, check_discrete

PER_DECADE = 60
"""Frequencies of a grid in every decade, besides those around what bends the response."""

LIGHT = 0.5
"""A pole or zero of a damping below this gets frequencies of its own."""

_AROUND = np.concatenate([[0.0], np.geomspace(0.05, 1.0, 16)])
_OUTSIDE = 1.37
"""A real point of the z-plane where nothing is likely to have a pole or zero."""


@dataclass(frozen=True)
class Response:
    """A sampled frequency response.

    Attributes:
        frequencies: in Hz, shape (n,).
        values: the transfer matrix at each of them, shape (n, outputs, inputs).
    """

    frequencies: np.ndarray
    values: np.ndarray


class Transfer:
    """The transfer matrix of a discrete-time model, as a function of frequency.

    One Schur decomposition makes every frequency a triangular system of equations.
    """

    def __init__(self, system: control.StateSpace):
        """Decompose a model."""
        self._D, self._dt = system.D.astype(complex), system.dt
        triangle, basis = np.zeros((0, 0), dtype=complex), np.zeros((0, 0))
        if system.nstates:
            triangle, basis = scipy.linalg.schur(system.A, output="complex")
        self._poles, self._shifted = np.diag(triangle), -np.asfortranarray(triangle)
        self._B, self._C = basis.conj().T @ system.B, system.C @ basis

    def __call__(self, frequencies: np.ndarray) -> np.ndarray:
        """Return the transfer matrix at frequencies in Hz, shape (n, outputs, inputs)."""
        values = np.tile(self._D, (len(frequencies), 1, 1))
        if not self._poles.size:
            return values
        diagonal, shifted = np.arange(len(self._poles)), self._shifted.copy(order="F")
        for value, z in zip(values, np.exp(2j * np.pi * frequencies * self._dt), strict=True):
            shifted[diagonal, diagonal] = z - self._poles
            value += self._C @ ztrtrs(shifted, self._B)[0]
        return values


def frequency_response(system: control.StateSpace, frequencies: np.ndarray) -> Response:
    """Return the response of a discrete-time model at frequencies in Hz."""
    frequencies = np.asarray(frequencies, dtype=float)
    return Response(frequencies, Transfer(system)(frequencies))


def frequency_data(loop: control.StateSpace) -> control.FrequencyResponseData:
    """Return a loop's response for python-control, sampled where it bends.

    `control.stability_margins` and `control.bode_plot` are exact on it; of a large StateSpace they
    make polynomials, which are not.

    Args:
        loop: in discrete time, as `lola.open_loop` gives it; of any number of signals.

    Raises:
        AnalysisError: if it is no discrete-time model.
    """
    check_discrete("frequency data", loop)
    response = frequency_response(loop, frequency_grid(loop))
    return control.FrequencyResponseData(
        np.moveaxis(response.values, 0, -1),
        2 * np.pi * response.frequencies,
        dt=loop.dt,
        smooth=True,
        name=loop.name,
        sysname=loop.name,
        inputs=loop.input_labels,
        outputs=loop.output_labels,
    )


def frequency_grid(loop: control.StateSpace, per_decade: int = PER_DECADE) -> np.ndarray:
    """Return frequencies (Hz) between which a loop and its sensitivity are smooth.

    They end at Nyquist, and begin below all that bends the response.
    """
    nyquist = 0.5 / loop.dt
    z = _corners(loop)
    s = np.log(z[(np.abs(z) > 1e-3) & (np.abs(z - 1) > UNSTABLE)].astype(complex)) / loop.dt
    lowest = 1e-3 * np.abs(s).min(initial=nyquist) / (2 * np.pi)
    lowest = max(lowest, 1e-8 * nyquist)
    even = np.geomspace(lowest, nyquist, round(per_decade * np.log10(nyquist / lowest)))
    # Delays turn the phase evenly all the way to Nyquist; each signal has its own part of them.
    delays = -(-loop.nstates // loop.ninputs)
    turning = np.linspace(0.0, nyquist, 10 * (1 + delays))[1:]
    light = np.unique(s[(np.abs(s.real) < LIGHT * s.imag)].round(9))
    width = np.maximum(np.abs(light.real), 1e-7 * light.imag)[:, None]
    reach = np.maximum(0.1 * light.imag[:, None], 4 * width)
    offsets = width * (_AROUND * (reach / width) ** _AROUND)
    around = (light.imag[:, None] + np.hstack([offsets, -offsets[:, 1:]])).ravel() / (2 * np.pi)
    around = around[(around > lowest) & (around < nyquist)]
    grid = np.unique(np.concatenate([even, turning[turning > lowest], around]))
    # The same pole, open and closed: what interpolates must not divide by rounding.
    return grid[np.diff(grid, append=np.inf) > 1e-9 * grid]


def _corners(loop: control.StateSpace) -> np.ndarray:
    """Return what bends the response: poles, closed-loop poles, zeros if it has one signal."""
    found = [np.linalg.eigvals(loop.A)]
    if loop.ninputs == loop.noutputs:
        one = np.eye(loop.ninputs)
        found.append(np.linalg.eigvals(loop.A - loop.B @ np.linalg.solve(one + loop.D, loop.C)))
    if (loop.noutputs, loop.ninputs) == (1, 1):
        found.append(zeros(loop))
    return np.concatenate(found)


def zeros(system: control.StateSpace) -> np.ndarray:
    """Return the zeros of a model of one input and one output in the z-plane.

    By u = 1/(z - z0) the model gets a direct feed-through, L(z0), and its zeros become the
    eigenvalues of one matrix.
    """
    if not system.nstates:
        return np.zeros(0)
    inverse = np.linalg.inv(_OUTSIDE * np.eye(system.nstates) - system.A)
    entering, leaving = inverse @ system.B, system.C @ inverse
    through = (leaving @ system.B + system.D).item()
    if not through:
        return np.zeros(0)
    u = np.linalg.eigvals(entering @ leaving / through - inverse)
    return _OUTSIDE + 1 / u[np.abs(u) > 1e-9]
