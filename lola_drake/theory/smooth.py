"""Smooth transitions from 0 to 1, with their derivatives."""

import numpy as np


def quintic(tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the minimum-jerk transition and its first two derivatives.

    Args:
        tau: phase, any shape; values outside [0, 1] are held at the ends.

    Returns:
        s, ds/dtau and d2s/dtau2, each of the shape of tau; the derivatives vanish at both ends.
    """
    t = np.minimum(np.maximum(tau, 0.0), 1.0)
    square, product = t * t, t * (1 - t)
    s = t * square * (10 - 15 * t + 6 * square)
    ds = 30 * product * product
    dds = 60 * product * (1 - 2 * t)
    return s, ds, dds


def linear(tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the straight transition and its first two derivatives, as `quintic` does."""
    ds = ((tau >= 0.0) & (tau < 1.0)).astype(float)
    return np.clip(tau, 0.0, 1.0), ds, np.zeros_like(ds)


def bump(tau: np.ndarray) -> np.ndarray:
    """Return sin(pi tau)^2 inside [0, 1] and zero outside."""
    t = np.clip(tau, 0.0, 1.0)
    return np.sin(np.pi * t) ** 2
