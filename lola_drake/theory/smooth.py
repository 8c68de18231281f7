"""Smooth transitions from 0 to 1, with their derivatives."""

import numpy as np


def quintic(tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the minimum-jerk transition and its first two derivatives.

    Args:
        tau: phase, any shape; values outside [0, 1] are held at the ends.

    Returns:
        s, ds/dtau and d2s/dtau2, each of the shape of tau; the derivatives vanish at both ends.
    """
    t = np.clip(tau, 0.0, 1.0)
    s = t**3 * (10 - 15 * t + 6 * t**2)
    ds = 30 * t**2 * (1 - t) ** 2
    dds = 60 * t * (1 - t) * (1 - 2 * t)
    return s, ds, dds


def linear(tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the straight transition and its first two derivatives, as `quintic` does."""
    ds = ((tau >= 0.0) & (tau < 1.0)).astype(float)
    return np.clip(tau, 0.0, 1.0), ds, np.zeros_like(ds)


def bump(tau: np.ndarray) -> np.ndarray:
    """Return sin(pi tau)^2 inside [0, 1] and zero outside."""
    t = np.clip(tau, 0.0, 1.0)
    return np.sin(np.pi * t) ** 2
