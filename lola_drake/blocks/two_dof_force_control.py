"""Force control with two degrees of freedom, of one foot: a rival of the paper's law.

    lambda_r = lambda_d / (tau s + 1)
    Delta w' = U^-1 (lambda_r' + (lambda_r - lambda) / delta + k_i integral(lambda_r - lambda) dt)

How a contact follows what is desired (tau) and how it forgets a disturbance (delta, k_i) are chosen
apart: with e = lambda_r - lambda an ideal contact has e'' + e' / delta + k_i e = 0, and no error is
left where the ground moves steadily.

The paper names it for the torques of the feet (its [13]); this form is ours and so are the numbers,
which `lola tune --law two_dof` chose.
U is that of the paper's law here: the pads in series with the servos.
"""

from dataclasses import dataclass

import numpy as np

from lola_drake.block import State, law
from lola_drake.blocks.foot_force_control import FootForceControl
from lola_drake.blocks.hybrid_force_control import (
    force_control_rate,
    held_time_constant,
    inverse_gradient,
    wrench_error,
)
from lola_drake.parameters import parameter, validate
from lola_drake.signals import CONTACT_WRENCH, PERIOD, Field, Signal
from lola_drake.theory.scalars import exp

WRENCH = CONTACT_WRENCH.fields[0]
REFERENCE = Signal("reference_wrench", "lambda_r: the desired wrench behind its lag.", (WRENCH,))
INTEGRAL = Signal(
    "wrench_integral",
    "Of lambda_r - lambda, where the foot is force-controlled.",
    (Field("integral", WRENCH.entries, ("Nms", "Nms", "Ns"), WRENCH.frame),),
)


@dataclass(frozen=True)
class TwoDofForceControlParams:
    """The lag of what is desired, and the dynamics of the error."""

    reference_time: float = parameter(
        0.01,
        "tau, lag of the desired wrench",
        "s",
        minimum=0.001,
        maximum=1,
        symbol="τ",
        slider=(0.001, 0.08, 0.001),
    )
    time_constant: float = parameter(
        0.0106,
        "delta, of the force error",
        "s",
        minimum=0.001,
        maximum=1,
        symbol="δ",
        slider=(0.005, 0.08, 0.001),
    )
    integral_gain: float = parameter(
        350.0,
        "k_i, of the error's integral",
        "1/s^2",
        minimum=0,
        maximum=1e4,
        symbol="k_i",
        slider=(0, 1000, 10),
    )

    def __post_init__(self):
        validate(self)


def lag(time):
    """Return which part of a distance a first-order lag goes in a period, its time constant (s)."""
    return 1 - exp(-PERIOD / time)


class TwoDofForceControl(FootForceControl):
    """Lets the wrench follow the desired one behind a lag, and integrates what it lacks.

    Its state has, besides, lambda_r and the integral; this one is forgotten as the foot is unloaded
    or taken back to its plan.
    """

    Params = TwoDofForceControlParams
    signals = (REFERENCE, INTEGRAL)
    state = (*FootForceControl.state, State(REFERENCE, hidden=True), State(INTEGRAL, hidden=True))

    def __init__(self, params=None, foot="", *, standing_wrench=(0.0, 0.0, 0.0), **constants):
        """Create the block; `standing_wrench` is the foot's wrench at the start, shape (3,)."""
        initial = {REFERENCE.name: np.array(standing_wrench)}
        super().__init__(params, foot, initial=initial, **constants)

    @law
    def force_rate(
        wrench,
        contact_wrench,
        reference_wrench,
        wrench_integral,
        time_constant,
        reference_time,
        integral_gain,
        inverse_contact_matrix,
        compliance,
        relaxation,
    ):
        """Return U^-1 times the rate that the wrench is to have."""
        inverse = inverse_gradient(inverse_contact_matrix, compliance, relaxation, time_constant)
        error = wrench_error(reference_wrench, contact_wrench)
        follow, ahead = lag(reference_time) / PERIOD, wrench_error(wrench, reference_wrench)
        wanted = (
            follow * ahead[0] + integral_gain * wrench_integral[0],
            follow * ahead[1] + integral_gain * wrench_integral[1],
            follow * ahead[2] + integral_gain * wrench_integral[2],
        )
        return force_control_rate(inverse, error, wanted, held_time_constant(time_constant))

    @law
    def next_reference_wrench(reference_wrench, wrench, reference_time):
        """Let the desired wrench through the lag."""
        r, part, ahead = (
            reference_wrench,
            lag(reference_time),
            wrench_error(wrench, reference_wrench),
        )
        return r[0] + part * ahead[0], r[1] + part * ahead[1], r[2] + part * ahead[2]

    @law
    def next_wrench_integral(wrench_integral, reference_wrench, contact_wrench, blend, grip):
        """Integrate the error as far as the foot is force-controlled, and forget the rest."""
        error, degree = wrench_error(reference_wrench, contact_wrench), grip[0] * blend
        return (
            degree * (wrench_integral[0] + PERIOD * error[0]),
            degree * (wrench_integral[1] + PERIOD * error[1]),
            degree * (wrench_integral[2] + PERIOD * error[2]),
        )
