"""A force law of one's own in place of the paper's: a foot that answers as if it had a mass.

The paper lets the force error die out as delta e' + e = 0 (eq. 14). Here the law is the same, but
the error that it is given comes through a lag of delta/4: it dies out as
delta^2/4 e'' + delta e' + e = 0. With a longer lag it would swing.

lola simulate step_down --block force_control=examples/own_force_law.py:SecondOrderForceControl
"""

import os

import lola_drake as lola
from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.signals import PERIOD, Field, Signal
from lola_drake.theory.scalars import exp

FELT_ERROR = Signal(
    "felt_error",
    "The error of the contact force behind the lag.",
    (Field("T", ("x", "y"), "Nm"), Field("F", ("z",), "N")),
)

first_order = HybridForceControl.laws["force_rate"]


class SecondOrderForceControl(HybridForceControl):
    """The paper's force control with a second order in the error's dynamics.

    All that it does not name is the paper's: parameters, limits, the swing foot, the late foot.
    """

    signals = (FELT_ERROR,)
    state = (*HybridForceControl.state, FELT_ERROR)

    @lola.law
    def force_rate(
        felt_error,
        wrench_rate,
        time_constant,
        inverse_contact_matrix,
        compliance,
        relaxation,
    ):
        """Return the rate that the paper's law wants, for the error behind the lag."""
        model = inverse_contact_matrix, compliance, relaxation
        return first_order(felt_error, wrench_rate, (0.0, 0.0, 0.0), time_constant, *model)

    @lola.law
    def next_felt_error(felt_error, wrench, contact_wrench, time_constant):
        """Let the error through the lag."""
        part = 1 - exp(-PERIOD / (0.25 * time_constant))
        return (
            felt_error[0] + part * (wrench[0] - contact_wrench[0] - felt_error[0]),
            felt_error[1] + part * (wrench[1] - contact_wrench[1] - felt_error[1]),
            felt_error[2] + part * (wrench[2] - contact_wrench[2] - felt_error[2]),
        )


if __name__ == "__main__":
    changes = {"duration": 0.5} if os.environ.get("LOLA_QUICK") else {}
    scenario = lola.load_scenario("step_down", changes)
    for name, blocks in (("the paper's", {}), ("own", {"force_control": SecondOrderForceControl})):
        result = lola.simulate(scenario, blocks=blocks)
        print(name, result.metrics["max_inclination_deg"])
