"""The local stabiliser: keeps the torso upright by asking for another wrench.

The paper names the block and not its law. The law here, a PD control of the inclination that adds
a torque about the CoM, is the one of the LOLA group (Buschmann et al., IROS 2009); the feedback
of the CoM's height to the vertical force exists on LOLA too (interface headers, 2018). The gains
are our own.

| paper       | here              |
|-------------|-------------------|
| Lambda_id   | `ideal_wrench`    |
| phi_m       | `phi`, `phi_dot`  |
| Lambda_mod  | `modified_wrench` |
"""

from dataclasses import dataclass

from lola_drake.block import Block, Part, law
from lola_drake.parameters import parameter, validate
from lola_drake.signals import GAIT_PHASE, TORSO_ORIENTATION


@dataclass(frozen=True)
class ImuStabilizerParams:
    """Gains of the inclination and height feedback."""

    stiffness: float = parameter(
        2000.0,
        "torque per inclination",
        "Nm/rad",
        minimum=0,
        maximum=2e4,
        symbol="P",
        slider=(0, 4000, 20),
    )
    damping: float = parameter(
        300.0,
        "torque per rate of inclination",
        "Nms/rad",
        minimum=0,
        maximum=5e3,
        symbol="D",
        slider=(0, 800, 5),
    )
    torque_limit: float = parameter(
        120.0,
        "greatest torque that is added",
        "Nm",
        above=0,
        maximum=1e3,
        symbol="limit",
        slider=(1, 300, 1),
    )
    height_stiffness: float = parameter(
        1000.0,
        "vertical force per missing CoM height",
        "N/m",
        minimum=0,
        maximum=5e4,
        symbol="P_z",
        slider=(0, 9000, 50),
    )

    def __post_init__(self):
        validate(self)


class ImuStabilizer(Block):
    """Adds the torque that brings the torso back upright, and the force that holds its height."""

    Params = ImuStabilizerParams
    parts = {
        "load": Part(GAIT_PHASE, "load"),
        "phi": Part(TORSO_ORIENTATION, "phi"),
        "phi_dot": Part(TORSO_ORIENTATION, "phi_dot"),
    }

    @law
    def modified_wrench(
        ideal_wrench,
        phi,
        phi_dot,
        load,
        task_modification_l,
        task_modification_r,
        stiffness,
        damping,
        torque_limit,
        height_stiffness,
    ):
        """Return Lambda_mod = [F, T] in T (N, Nm), shape (6,)."""
        # By how much the force control has lowered the CoM over the feet.
        sinking = load[0] * task_modification_l[2] + load[1] * task_modification_r[2]
        correction_x = stiffness * phi[0] + damping * phi_dot[0]
        correction_y = stiffness * phi[1] + damping * phi_dot[1]
        return (
            ideal_wrench[0],
            ideal_wrench[1],
            ideal_wrench[2] + height_stiffness * sinking,
            ideal_wrench[3] - min(max(correction_x, -torque_limit), torque_limit),
            ideal_wrench[4] - min(max(correction_y, -torque_limit), torque_limit),
            ideal_wrench[5],
        )
