"""The inertial measurement unit in the torso: inclination and its rate.

LOLA carries a high-precision unit; noise, bias and delay are estimates of its class.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, hypot

import numpy as np
from pydrake.systems.framework import LeafSystem

from lola_drake.blocks.noise import Noise
from lola_drake.parameters import parameter, validate
from lola_drake.signals import TORSO_ORIENTATION


@dataclass(frozen=True)
class ImuParams:
    """Errors of the unit."""

    angle_noise: float = parameter(
        3.5e-4, "standard deviation (estimate)", "rad", minimum=0, maximum=0.2
    )
    rate_noise: float = parameter(
        1.7e-3, "standard deviation (estimate)", "rad/s", minimum=0, maximum=2
    )
    angle_bias: float = parameter(
        1.7e-3, "standard deviation of the constant bias (estimate)", "rad", minimum=0, maximum=0.2
    )
    delay_ticks: int = parameter(3, "delay in control periods", "", minimum=1, maximum=50)

    def __post_init__(self):
        validate(self)

    def ideal(self) -> "ImuParams":
        """Return a unit without errors; one tick is left for sampling."""
        return ImuParams(angle_noise=0.0, rate_noise=0.0, angle_bias=0.0, delay_ticks=1)


def inclination(quaternion: Sequence[float], angular_velocity: Sequence[float]) -> np.ndarray:
    """Return phi_x, phi_y and their rates.

    Args:
        quaternion: w, x, y, z of the torso in W.
        angular_velocity: w_WT_W (rad/s), shape (3,).

    Returns:
        Roll and pitch of the torso (rad), the angular velocity's x and y in the torso's heading
        frame (rad/s), shape (4,).
    """
    w, x, y, z = quaternion
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = asin(min(max(2 * (w * y - z * x), -1.0), 1.0))
    c, s = 1 - 2 * (y * y + z * z), 2 * (w * z + x * y)
    norm = hypot(c, s)
    c, s = c / norm, s / norm
    w_x, w_y, _ = angular_velocity
    return np.array([roll, pitch, c * w_x + s * w_y, c * w_y - s * w_x])


class Imu(LeafSystem):
    """Samples the torso's inclination and reports it late, with noise and bias.

    The state is the line of samples under way, the newest first, and the sample that has arrived.

    .. pydrake_system::

        name: Imu
        input_ports:
        - plant_state
        output_ports:
        - torso_orientation
    """

    def __init__(self, params: ImuParams, state_size: int, period: float, seed: int):
        """Create the unit for a plant whose state of `state_size` begins with the torso's pose."""
        super().__init__()
        self._period = period
        deviation = np.repeat([params.angle_noise, params.rate_noise], 2)
        self._noise = Noise(deviation, seed, stream=1)
        bias = params.angle_bias * np.random.default_rng([seed, 0]).standard_normal(2)
        self._bias = np.concatenate([bias, [0.0, 0.0]])
        first = (state_size + 1) // 2
        self._angular_velocity = slice(first, first + 3)
        self._plant = self.DeclareVectorInputPort("plant_state", state_size)
        self._line = self.DeclareDiscreteState(np.zeros(4 * (params.delay_ticks - 1)))
        self._arrived = self.DeclareDiscreteState(TORSO_ORIENTATION.size)
        self.DeclareStateOutputPort(TORSO_ORIENTATION.name, self._arrived)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        plant = self._plant.Eval(context)
        sample = inclination(plant[:4].tolist(), plant[self._angular_velocity].tolist())
        sample += self._bias + self._noise(round(context.get_time() / self._period))
        line = np.concatenate([sample, context.get_discrete_state(self._line).value()])
        state.set_value(self._line, line[:-4])
        state.set_value(self._arrived, line[-4:])
