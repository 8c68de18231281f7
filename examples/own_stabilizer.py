"""A law of one's own in place of the stabiliser: a torque that grows with the cube of the lean.

lola simulate step_down --block imu_stabilizer=examples/own_stabilizer.py:CubicStabilizer
"""

import os
from dataclasses import dataclass

import lola_drake as lola
from lola_drake.signals import TORSO_ORIENTATION


@dataclass(frozen=True)
class CubicStabilizerParams:
    """Its gains; those with a slider may be turned while it runs."""

    slope: float = lola.parameter(
        1600.0, "torque per lean", "Nm/rad", minimum=0, maximum=1e4, slider=(0, 4000, 20)
    )
    cube: float = lola.parameter(
        1e6, "torque per cubed lean", "Nm/rad^3", minimum=0, maximum=1e8, slider=(0, 1e7, 1e5)
    )
    damping: float = lola.parameter(
        300.0, "torque per rate", "Nms/rad", minimum=0, maximum=5e3, slider=(0, 800, 5)
    )


class CubicStabilizer(lola.Block):
    """Adds a torque about the CoM that grows faster than the torso leans."""

    Params = CubicStabilizerParams
    parts = {
        "phi": lola.Part(TORSO_ORIENTATION, "phi"),
        "phi_dot": lola.Part(TORSO_ORIENTATION, "phi_dot"),
    }

    @lola.law
    def modified_wrench(ideal_wrench, phi, phi_dot, slope, cube, damping):
        """Return [F, T] in T (N, Nm), shape (6,)."""
        torque_x = slope * phi[0] + cube * phi[0] ** 3 + damping * phi_dot[0]
        torque_y = slope * phi[1] + cube * phi[1] ** 3 + damping * phi_dot[1]
        f = ideal_wrench
        return f[0], f[1], f[2], f[3] - torque_x, f[4] - torque_y, f[5]


if __name__ == "__main__":
    changes = {"duration": 0.5} if os.environ.get("LOLA_QUICK") else {}
    scenario = lola.load_scenario("step_down", changes)
    result = lola.simulate(scenario, blocks={"imu_stabilizer": CubicStabilizer})
    print(result.metrics["max_inclination_deg"])
