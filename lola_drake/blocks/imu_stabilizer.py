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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lola_drake.blocks.scalars import AlgebraicSystem, convertible
from lola_drake.parameters import parameter, validate
from lola_drake.signals import (
    GAIT_PHASE,
    IDEAL_WRENCH,
    MODIFIED_WRENCH,
    TASK_MODIFICATION,
    TORSO_ORIENTATION,
)

_LOAD = GAIT_PHASE.slice("load")
_DELTA_Z = TASK_MODIFICATION.slice("delta_w").start + 2


@dataclass(frozen=True)
class ImuStabilizerParams:
    """Gains of the inclination and height feedback."""

    stiffness: float = parameter(1600.0, "torque per inclination", "Nm/rad", minimum=0, maximum=2e4)
    damping: float = parameter(
        300.0, "torque per rate of inclination", "Nms/rad", minimum=0, maximum=5e3
    )
    torque_limit: float = parameter(
        120.0, "greatest torque that is added", "Nm", above=0, maximum=1e3
    )
    height_stiffness: float = parameter(
        1500.0, "vertical force per missing CoM height", "N/m", minimum=0, maximum=5e4
    )

    def __post_init__(self):
        validate(self)


def stabilize(
    ideal: Sequence[float],
    orientation: Sequence[float],
    sinking: float,
    stiffness: float,
    damping: float,
    torque_limit: float,
    height_stiffness: float,
) -> np.ndarray:
    """Return Lambda_mod.

    Args:
        ideal: Lambda_id = [F, T] in T (N, Nm), shape (6,).
        orientation: phi_x, phi_y (rad) and their rates (rad/s), shape (4,).
        sinking: by how much the force control has lowered the CoM over the feet (m).
        stiffness: torque per inclination (Nm/rad).
        damping: torque per rate of inclination (Nms/rad).
        torque_limit: greatest torque that is added (Nm).
        height_stiffness: vertical force per sinking (N/m).

    Returns:
        [F, T] in T, shape (6,).
    """
    f_x, f_y, f_z, t_x, t_y, t_z = ideal
    phi_x, phi_y, rate_x, rate_y = orientation
    torque_x = stiffness * phi_x + damping * rate_x
    torque_y = stiffness * phi_y + damping * rate_y
    return np.array(
        [
            f_x,
            f_y,
            f_z + height_stiffness * sinking,
            t_x - min(max(torque_x, -torque_limit), torque_limit),
            t_y - min(max(torque_y, -torque_limit), torque_limit),
            t_z,
        ]
    )


@convertible
class ImuStabilizer(AlgebraicSystem):
    """Adds the torque that brings the torso back upright, and the force that holds its height.

    The four gains are the numeric parameter 0, in the order of `ImuStabilizerParams`.

    .. pydrake_system::

        name: ImuStabilizer
        input_ports:
        - ideal_wrench
        - torso_orientation
        - gait_phase
        - task_modification_l
        - task_modification_r
        output_ports:
        - modified_wrench
    """

    def __init__(self, params: ImuStabilizerParams):
        """Create the block; it has no state."""
        super().__init__()
        self._gains = self.DeclareNumericParameter(
            self.Vector(
                [params.stiffness, params.damping, params.torque_limit, params.height_stiffness]
            )
        )
        self._ideal = self.DeclareVectorInputPort("ideal_wrench", IDEAL_WRENCH.size)
        self._orientation = self.DeclareVectorInputPort("torso_orientation", TORSO_ORIENTATION.size)
        self._phase = self.DeclareVectorInputPort("gait_phase", GAIT_PHASE.size)
        self._modifications = [
            self.DeclareVectorInputPort(f"task_modification_{foot}", TASK_MODIFICATION.size)
            for foot in "lr"
        ]
        inputs = [self._ideal, self._orientation, self._phase, *self._modifications]
        self.DeclareVectorOutputPort(
            "modified_wrench",
            MODIFIED_WRENCH.size,
            self._calc,
            prerequisites_of_calc={port.ticket() for port in inputs}
            | {self.all_parameters_ticket()},
        )

    def _calc(self, context, output):
        load_left, load_right = self._phase.Eval(context).tolist()[_LOAD]
        left, right = (port.Eval(context).item(_DELTA_Z) for port in self._modifications)
        output.set_value(
            stabilize(
                self._ideal.Eval(context).tolist(),
                self._orientation.Eval(context).tolist(),
                load_left * left + load_right * right,
                *context.get_numeric_parameter(self._gains).CopyToVector().tolist(),
            )
        )
