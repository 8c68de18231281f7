"""Pushes: forces from outside on a body of the robot, over some time."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from lola_drake.parameters import parameter, validate
from lola_drake.signals import PERIOD

PUSHES = "pushes"
"""Name of the system that pushes, in a diagram that has one."""

BODIES = (
    *("torso", "br", "ba", "vp", "vt"),
    *(f"{link}{side}" for link in ("hr", "ha", "hf", "kf", "sa", "sf") for side in "lr"),
    *("foot_l", "foot_r", "zfl", "zfr"),
    *(f"{link}{side}" for link in ("af", "aa", "ef") for side in "lr"),
)
"""The links of the robot that may be pushed."""


@dataclass(frozen=True)
class Push:
    """A push on one body."""

    time: float = parameter(2.0, "when it begins", "s", minimum=0.0, maximum=3600)
    duration: float = parameter(0.1, "how long it lasts", "s", minimum=PERIOD, maximum=3600)
    impulse: float = parameter(
        20.0, "integral of its force over time", "Ns", minimum=0.0, maximum=10_000
    )
    direction_deg: float = parameter(
        0.0, "in which it pushes: 0 along x of W, 90 along y", "deg", minimum=-360, maximum=360
    )
    elevation_deg: float = parameter(
        0.0, "by which it points up from the horizontal", "deg", minimum=-90, maximum=90
    )
    body: str = parameter("torso", "the link that it acts on", choices=BODIES)
    point: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.25), "where it acts, in the link's frame", "m", minimum=-2, maximum=2
    )
    shape: str = parameter("constant", "of its force over time", choices=("constant", "half_sine"))

    def __post_init__(self):
        validate(self)

    @property
    def direction(self) -> np.ndarray:
        """Return the unit vector in W along which it pushes, shape (3,)."""
        up, turn = radians(self.elevation_deg), radians(self.direction_deg)
        return np.array([cos(up) * cos(turn), cos(up) * sin(turn), sin(up)])

    @property
    def end(self) -> float:
        """Return when it is over (s)."""
        return self.time + self.duration

    def force(self, tick: int) -> np.ndarray:
        """Return its force in W in a tick (N), shape (3,); all ticks add up to the impulse."""
        count = max(round(self.duration / PERIOD), 1)
        i = tick - round(self.time / PERIOD)
        if not 0 <= i < count:
            return np.zeros(3)
        share = 1 / count
        if self.shape == "half_sine":
            share = sin(pi * (i + 0.5) / count) * sin(pi / (2 * count))
        return self.impulse / PERIOD * share * self.direction

    def mean_force(self) -> np.ndarray:
        """Return the mean of its force in W (N), shape (3,)."""
        return self.impulse / self.duration * self.direction


def applied_force(
    body: BodyIndex, point: Sequence[float], force: np.ndarray
) -> ExternallyAppliedSpatialForce:
    """Return a force in W (N) on a body, at a point in its frame (m), as a plant takes it."""
    applied = ExternallyAppliedSpatialForce()
    applied.body_index, applied.p_BoBq_B = body, point
    applied.F_Bq_W = SpatialForce(np.zeros(3), force)
    return applied


class PushSource(LeafSystem):
    """Pushes the bodies of a plant, as a function of time alone."""

    def __init__(self, pushes: Sequence[Push], plant: MultibodyPlant):
        """Create the system; the plant is finalized."""
        super().__init__()
        self._pushes = [(push, plant.GetBodyByName(push.body).index()) for push in pushes]
        model = Value[list[ExternallyAppliedSpatialForce]]
        self.DeclareAbstractOutputPort("forces", model, self._calc, {self.time_ticket()})

    def _calc(self, context, output) -> None:
        tick, found = round(context.get_time() / PERIOD), []
        for push, body in self._pushes:
            force = push.force(tick)
            if force.any():
                found.append(applied_force(body, push.point, force))
        output.set_value(found)


def connect_pushes(builder: DiagramBuilder, plant: MultibodyPlant, pushes: Sequence[Push]) -> None:
    """Add what pushes a finalized plant to its diagram, if there are any pushes."""
    if pushes:
        source = builder.AddNamedSystem(PUSHES, PushSource(pushes, plant))
        builder.Connect(source.get_output_port(), plant.get_applied_spatial_force_input_port())
