"""The 6-axis force/torque sensor in each foot.

It is the weld between ankle and sole: what it reads is the load that the sole passes on, which is
the ground's wrench less the weight and inertia of the sole. Noise and filter are estimates.
"""

from dataclasses import dataclass
from math import exp, pi

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.systems.framework import LeafSystem

from lola_drake.blocks.noise import Noise
from lola_drake.parameters import parameter, validate
from lola_drake.signals import MEASURED_WRENCH


@dataclass(frozen=True)
class FootForceSensorParams:
    """Errors and filter of the sensors."""

    force_noise: float = parameter(
        2.0, "standard deviation (estimate)", "N", minimum=0, maximum=200
    )
    torque_noise: float = parameter(
        0.1, "standard deviation (estimate)", "Nm", minimum=0, maximum=20
    )
    cutoff: float = parameter(
        150.0, "of the first-order low-pass; 0 for none", "Hz", minimum=0, maximum=500
    )

    def __post_init__(self):
        validate(self)

    def ideal(self) -> "FootForceSensorParams":
        """Return sensors without errors and filter."""
        return FootForceSensorParams(force_noise=0.0, torque_noise=0.0, cutoff=0.0)


class FootForceSensor(LeafSystem):
    """Samples, disturbs and filters the wrenches of both feet.

    The state is the filtered wrench; in the tick of a contact it already holds what the plant
    computes for the step that begins there, so a reading is one period old when it is used.

    .. pydrake_system::

        name: FootForceSensor
        input_ports:
        - reaction_forces
        output_ports:
        - measured_wrench
    """

    def __init__(
        self,
        params: FootForceSensorParams,
        joint_indices: tuple[int, int],
        initial: np.ndarray,
        period: float,
        seed: int,
    ):
        """Create the sensors of both feet.

        Args:
            params: errors and filter.
            joint_indices: of the left and right sensor's weld joint in the plant.
            initial: F and T of both feet at the start (N, Nm), shape (12,).
            period: the control period (s).
            seed: of the run's noise.
        """
        super().__init__()
        self._joints, self._period = joint_indices, period
        deviation = np.tile(np.repeat([params.force_noise, params.torque_noise], 3), 2)
        self._noise = Noise(deviation, seed, stream=2)
        self._gain = 1 - exp(-2 * pi * params.cutoff * period) if params.cutoff else 1.0
        self._forces = self.DeclareAbstractInputPort("reaction_forces", Value[list[SpatialForce]]())
        state = self.DeclareDiscreteState(initial)
        self._reading = self.DeclareStateOutputPort(MEASURED_WRENCH.name, state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        forces = self._forces.Eval(context)
        on_soles = []
        for joint in self._joints:
            wrench = forces[joint].get_coeffs().tolist()
            on_soles += wrench[3:] + wrench[:3]
        # The plant reports the force on the sole; the sensor feels the opposite.
        raw = self._noise(round(context.get_time() / self._period)) - on_soles
        filtered = self._reading.Eval(context)
        state.set_value(filtered + self._gain * (raw - filtered))
