"""The 6-axis force/torque sensor in each foot.

It is the weld between ankle and sole: what it reads is the load that the sole passes on, which is
the ground's wrench less the weight and inertia of the sole. Noise and filter are estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import exp, pi

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce

from lola_drake.block import Block, Reading, law
from lola_drake.bus import MissedCycles, gaps_of, is_missed
from lola_drake.parameters import parameter, validate
from lola_drake.signals import MEASURED_WRENCH, PERIOD
from lola_drake.theory.noise import Noise


@dataclass(frozen=True)
class FootForceSensorParams:
    """Errors and filter of the sensors."""

    force_noise: float = parameter(
        2.0, "standard deviation (estimate)", "N", minimum=0, maximum=200
    )
    torque_noise: float = parameter(
        0.1, "standard deviation (estimate)", "Nm", minimum=0, maximum=20
    )
    bias_l: tuple[float, float, float, float, float, float] = parameter(
        (0.0,) * 6, "a fault: of F and T of the left foot", "N, Nm", minimum=-500, maximum=500
    )
    bias_r: tuple[float, float, float, float, float, float] = parameter(
        (0.0,) * 6, "a fault: of F and T of the right foot", "N, Nm", minimum=-500, maximum=500
    )
    cutoff: float = parameter(
        150.0, "of the first-order low-pass; 0 for none", "Hz", minimum=0, maximum=500
    )

    def __post_init__(self):
        validate(self)

    def ideal(self) -> "FootForceSensorParams":
        """Return sensors without errors and filter, but with their faults."""
        return replace(self, force_noise=0.0, torque_noise=0.0, cutoff=0.0)


class FootForceSensor(Block):
    """Samples, disturbs and filters the wrenches of both feet.

    In the tick of a contact the state already holds what the plant computes for the step that
    begins there, so a reading is one period old when it is used.
    """

    Params = FootForceSensorParams
    kind = "sensor"
    state = (MEASURED_WRENCH,)
    objects = {"sole_reactions": Reading("reaction_forces", Value[list[SpatialForce]], 12)}

    def __init__(
        self,
        params: FootForceSensorParams,
        joint_indices: Sequence[int],
        initial: np.ndarray,
        seed: int,
        missed: Sequence[MissedCycles] = (),
    ):
        """Create the sensors of both feet.

        Args:
            params: errors and filter.
            joint_indices: of the left and right sensor's weld joint in the plant.
            initial: F and T of both feet at the start (N, Nm), shape (12,).
            seed: of the run's noise.
            missed: cycles of the bus.
        """
        self._joints = joint_indices
        deviation = np.tile(np.repeat([params.force_noise, params.torque_noise], 3), 2)
        filter_gain = 1 - exp(-2 * pi * params.cutoff * PERIOD) if params.cutoff else 1.0
        super().__init__(
            params,
            initial={MEASURED_WRENCH.name: initial},
            filter_gain=filter_gain,
            gaps=gaps_of(missed),
            noise=Noise(deviation, seed, stream=2, bias=np.array([*params.bias_l, *params.bias_r])),
        )

    def read_sole_reactions(self, forces: list[SpatialForce]) -> np.ndarray:
        """Return the plant's torque and force on the left and the right sole (Nm, N)."""
        return np.concatenate([forces[joint].get_coeffs() for joint in self._joints])

    @law
    def next_measured_wrench(measured_wrench, sole_reactions, noise, filter_gain, gaps, time):
        """Filter what the sensor feels: the opposite of what acts on the sole."""
        if is_missed(time, gaps):
            return measured_wrench
        reading = np.zeros(len(noise))
        for i in range(len(noise)):
            raw = noise[i] - sole_reactions[i // 6 * 6 + (i + 3) % 6]  # the force comes first
            reading[i] = measured_wrench[i] + filter_gain * (raw - measured_wrench[i])
        return reading
