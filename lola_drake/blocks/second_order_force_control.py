"""Impedance control of one foot: a rival of the paper's law with a mass and a spring.

    M Delta w'' + D Delta w' + K Delta w = -(lambda_d - lambda),   (M, D, K) = -U (m, d, k)

so that an ideal contact answers with m e'' + d e' + (1 + k) e = 0 in all three directions, but for
what the spring keeps of a step: the part k / (1 + k).

The paper names it as a "second-order" extension of damping control (its [14]); the equation is that
of impedance control (Hogan 1985), and the rest ours: that M, D and K are proportional to the
contact's gradient U, as in the paper's law the pads in series with the servos, and the numbers,
which `lola tune --law second_order` chose.
"""

from dataclasses import dataclass

from lola_drake.block import State, law
from lola_drake.blocks.foot_force_control import FORCE_RATE, FootForceControl, limited_rate
from lola_drake.blocks.hybrid_force_control import inverse_gradient, motion, wrench_error
from lola_drake.parameters import parameter, validate
from lola_drake.signals import PERIOD, Signal

YIELDING = Signal("yielding", "Delta w' as far as the force law makes it.", FORCE_RATE.fields)


@dataclass(frozen=True)
class SecondOrderForceControlParams:
    """The impedance, relative to the stiffness of the contact."""

    inertia: float = parameter(
        3.5e-4,
        "m, mass over the contact's stiffness",
        "s^2",
        minimum=0,
        maximum=1,
        symbol="m",
        slider=(0, 1e-3, 1e-5),
    )
    damping: float = parameter(
        0.0106,
        "d, damping over the contact's stiffness",
        "s",
        minimum=0.001,
        maximum=1,
        symbol="d",
        slider=(0.005, 0.08, 0.001),
    )
    stiffness: float = parameter(
        0.02,
        "k, stiffness over the contact's",
        "-",
        minimum=0,
        maximum=10,
        symbol="k",
        slider=(0, 0.5, 0.01),
    )

    def __post_init__(self):
        validate(self)


def impedance_rate(rate, drive, deviation, inertia, damping, stiffness):
    """Return the next rate of one direction: m rate' + d rate + k deviation = drive.

    The damper's part is taken at the end of the period: without a mass there is no rate before.

    Args:
        rate: the present one.
        drive: U^-1 (lambda_d - lambda) in this direction.
        deviation: Delta w in this direction.
        inertia: m (s^2).
        damping: d (s).
        stiffness: k.
    """
    push = drive - stiffness * deviation
    return (inertia * rate + PERIOD * push) / (inertia + PERIOD * damping)


class SecondOrderForceControl(FootForceControl):
    """Yields to one foot's force error like a mass with a damper and a spring.

    Its state has, besides, the rate with which it yields: where the foot is not force-controlled,
    or at a limit, it is none.
    """

    Params = SecondOrderForceControlParams
    signals = (YIELDING,)
    state = (*FootForceControl.state, State(YIELDING, hidden=True))

    @law
    def force_rate(
        wrench,
        contact_wrench,
        yielding,
        task_modification,
        inverse_contact_matrix,
        compliance,
        relaxation,
        inertia,
        damping,
        stiffness,
    ):
        """Return the rate of the impedance."""
        inverse = inverse_gradient(inverse_contact_matrix, compliance, relaxation, damping)
        drive, delta = motion(inverse, wrench_error(wrench, contact_wrench)), task_modification
        return (
            impedance_rate(yielding[0], drive[0], delta[0], inertia, damping, stiffness),
            impedance_rate(yielding[1], drive[1], delta[1], inertia, damping, stiffness),
            impedance_rate(yielding[2], drive[2], delta[2], inertia, damping, stiffness),
        )

    @law
    def next_yielding(force_rate, blend, grip, task_modification, limits, rate_limits):
        """Return the rate as far as it moved the foot."""
        rate, delta, angles = force_rate, task_modification, grip[0] * blend
        return (
            limited_rate(angles * rate[0], delta[0], limits[0], rate_limits[0]),
            limited_rate(angles * rate[1], delta[1], limits[1], rate_limits[1]),
            limited_rate(blend * rate[2], delta[2], limits[2], rate_limits[2]),
        )
