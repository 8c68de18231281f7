"""Frequency responses of large discrete-time models, exact and fast."""

from dataclasses import dataclass

import control
import numpy as np
import scipy.linalg
from scipy.linalg.lapack import ztrtrs

LOWEST = 1e-4
"""Lowest frequency that is looked at (Hz)."""


@dataclass(frozen=True)
class Response:
    """A sampled frequency response.

    Attributes:
        frequencies: in Hz, shape (n,).
        values: the transfer matrix at each of them, shape (n, outputs, inputs).
    """

    frequencies: np.ndarray
    values: np.ndarray


def frequency_response(system: control.StateSpace, frequencies: np.ndarray) -> Response:
    """Return the response of a discrete-time model at frequencies in Hz.

    One Schur decomposition makes every frequency a triangular system of equations.
    """
    frequencies = np.asarray(frequencies, dtype=float)
    if not system.nstates:
        return Response(frequencies, np.tile(system.D.astype(complex), (len(frequencies), 1, 1)))
    triangle, basis = scipy.linalg.schur(system.A, output="complex")
    entering, leaving = basis.conj().T @ system.B, system.C @ basis
    values = np.empty((len(frequencies), *system.D.shape), dtype=complex)
    diagonal = np.arange(len(triangle))
    shifted = -np.asfortranarray(triangle)
    for k, z in enumerate(np.exp(2j * np.pi * frequencies * system.dt)):
        shifted[diagonal, diagonal] = z - triangle[diagonal, diagonal]
        values[k] = leaving @ ztrtrs(shifted, entering)[0] + system.D
    return Response(frequencies, values)


def frequency_grid(system: control.StateSpace, count: int = 1500) -> np.ndarray:
    """Return frequencies (Hz) up to Nyquist, denser around lightly damped poles."""
    nyquist = 0.5 / system.dt
    even = np.geomspace(LOWEST, nyquist, count)
    z = np.linalg.eigvals(system.A)
    s = np.log(z[np.abs(z) > 1e-3]) / system.dt
    light = s[(np.abs(s.real) < 0.2 * np.abs(s.imag)) & (s.imag > 0)]
    width = np.maximum(np.abs(light.real), 1e-4 * light.imag)
    around = light.imag[:, None] + width[:, None] * np.linspace(-4, 4, 41)
    around = around.ravel() / (2 * np.pi)
    return np.unique(np.concatenate([even, around[(around > LOWEST) & (around < nyquist)]]))
