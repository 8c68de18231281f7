"""The inertial measurement unit in the torso: inclination and its rate.

LOLA carries a high-precision unit; noise, bias and delay are estimates of its class.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import asin, atan2, hypot

import numpy as np

from lola_drake.block import Block, Part, State, law
from lola_drake.bus import MissedCycles, gaps_of, is_missed
from lola_drake.parameters import parameter, validate
from lola_drake.signals import PERIOD, PLANT_STATE, TORSO_ORIENTATION
from lola_drake.theory.delay_line import arriving, delayed
from lola_drake.theory.noise import Noise


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
    drift: tuple[float, float] = parameter(
        (0.0, 0.0), "a fault: how fast phi_x and phi_y go wrong", "rad/s", minimum=-0.1, maximum=0.1
    )
    delay_ticks: int = parameter(3, "delay in control periods", "", minimum=1, maximum=50)

    def __post_init__(self):
        validate(self)

    def ideal(self) -> "ImuParams":
        """Return a unit without errors but its faults; one tick is left for sampling."""
        return replace(self, angle_noise=0.0, rate_noise=0.0, angle_bias=0.0, delay_ticks=1)


def inclination(quaternion, angular_velocity):
    """Return phi_x, phi_y and their rates.

    Args:
        quaternion: w, x, y, z of the torso in W, shape (4,).
        angular_velocity: w_WT_W (rad/s), shape (3,).

    Returns:
        Roll and pitch of the torso (rad), the angular velocity's x and y in the torso's heading
        frame (rad/s), shape (4,).
    """
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = asin(min(max(2 * (w * y - z * x), -1.0), 1.0))
    c, s = 1 - 2 * (y * y + z * z), 2 * (w * z + x * y)
    norm = hypot(c, s)
    c, s = c / norm, s / norm
    w_x, w_y = angular_velocity[0], angular_velocity[1]
    return roll, pitch, c * w_x + s * w_y, c * w_y - s * w_x


SAMPLES = replace(TORSO_ORIENTATION, name="imu_samples", doc="Samples that are under way.")


class Imu(Block):
    """Samples the torso's inclination and reports it late, with noise and bias."""

    Params = ImuParams
    kind = "sensor"
    state = (State(SAMPLES, hidden=True), TORSO_ORIENTATION)
    parts = {
        "quaternion": Part(PLANT_STATE, "quaternion"),
        "angular_velocity": Part(PLANT_STATE, "angular_velocity"),
    }

    def __init__(self, params: ImuParams, seed: int, missed: Sequence[MissedCycles] = ()):
        """Create the unit; `seed` is that of the run, `missed` are cycles of the bus."""
        deviation = np.repeat([params.angle_noise, params.rate_noise], 2)
        bias = params.angle_bias * np.random.default_rng([seed, 0]).standard_normal(2)
        super().__init__(
            params,
            initial={SAMPLES.name: np.zeros(SAMPLES.size * (params.delay_ticks - 1))},
            bias=np.concatenate([bias, [0.0, 0.0]]),
            gaps=gaps_of(missed),
            noise=Noise(deviation, seed, stream=1, drift=PERIOD * np.array([*params.drift, 0, 0])),
        )

    @law
    def next_imu_samples(imu_samples, quaternion, angular_velocity, bias, noise):
        """Let the newest sample follow those that are under way."""
        return delayed(imu_samples, sample(quaternion, angular_velocity, bias, noise))

    @law
    def next_torso_orientation(
        imu_samples, torso_orientation, quaternion, angular_velocity, bias, noise, gaps, time
    ):
        """Return the sample that arrives, or that was there."""
        if is_missed(time, gaps):
            return torso_orientation
        return arriving(imu_samples, sample(quaternion, angular_velocity, bias, noise))


def sample(quaternion, angular_velocity, bias, noise):
    """Return what the unit measures now: phi_x, phi_y (rad) and their rates (rad/s)."""
    phi_x, phi_y, rate_x, rate_y = inclination(quaternion, angular_velocity)
    return (
        phi_x + (bias[0] + noise[0]),
        phi_y + (bias[1] + noise[1]),
        rate_x + (bias[2] + noise[2]),
        rate_y + (bias[3] + noise[3]),
    )
