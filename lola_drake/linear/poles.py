"""The poles of a discrete-time model: where they are, what they mean, and whose they are."""

import re
from dataclasses import dataclass

import control
import numpy as np
import scipy.linalg

from lola_drake.linear.errors import AnalysisError

NEUTRAL = re.compile(r"/q/\w+((?<!_rot)_[xy]|_rot_z)$")
"""Names of a base's place and heading on the ground: nothing pulls them anywhere."""

UNSTABLE = 1e-6
"""A pole counts as unstable from this far outside the unit circle on: growth e-fold in 1000 s."""


@dataclass(frozen=True)
class Pole:
    """One pole, or one of a conjugate pair.

    Attributes:
        z: in the z-plane.
        s: in the s-plane, log(z)/dt (1/s).
        dominating: the state that takes part in it most.
        participation: of that state, 0 to 1.
    """

    z: complex
    s: complex
    dominating: str
    participation: float

    @property
    def is_neutral(self) -> bool:
        """Return whether it neither decays nor grows, to within the model's accuracy."""
        return abs(self.z - 1) < UNSTABLE

    @property
    def frequency(self) -> float:
        """Return the natural frequency (Hz)."""
        return abs(self.s) / (2 * np.pi)

    @property
    def damping(self) -> float:
        """Return the damping ratio; 1 for a decaying real pole, -1 for a growing one."""
        return -self.s.real / abs(self.s) if self.s else 0.0


def poles(system: control.StateSpace) -> list[Pole]:
    """Return the poles of a discrete-time model, slowest decay first; pairs appear once.

    The dominating state is the one with the largest participation factor, which does not depend
    on units.

    Args:
        system: with named states, as `lola.linearize` gives it.

    Raises:
        AnalysisError: if it is no discrete-time model.
    """
    check_discrete("poles", system)
    values, left, right = scipy.linalg.eig(system.A, left=True, right=True)
    norms = np.einsum("ij,ij->j", left.conj(), right)
    with np.errstate(divide="ignore", invalid="ignore"):
        participation = np.abs(left.conj() * right / norms)
        participation = np.nan_to_num(participation / participation.sum(axis=0))
    order = [i for i in np.argsort(-np.abs(values)) if values[i].imag >= 0]
    return [
        Pole(
            z=complex(values[i]),
            s=complex(np.log(values[i]) / system.dt) if values[i] else -np.inf,
            dominating=system.state_labels[int(participation[:, i].argmax())],
            participation=float(participation[:, i].max()),
        )
        for i in order
    ]


def check_discrete(what: str, system: object) -> None:
    """Raise AnalysisError if what is asked for is not there, for want of a discrete-time model."""
    if not isinstance(system, control.StateSpace) or not system.isdtime(strict=True):
        raise AnalysisError(f"{what} are those of a discrete-time control.StateSpace")


def neutral(names: list[str]) -> np.ndarray:
    """Return which states are a base's place and heading on the ground."""
    return np.array([bool(NEUTRAL.search(name)) for name in names], dtype=bool)


def spectral_radius(A: np.ndarray) -> float:
    """Return the largest magnitude of a pole, without the neutral ones.

    Place and heading are neutral, and so is an integrator without gain.
    """
    z = np.linalg.eigvals(A)
    return float(np.abs(z[np.abs(z - 1) >= UNSTABLE]).max(initial=0.0))
