"""The CoM's dynamics inside the force control, for one foot (the paper's section IV.C).

In single support an error of the contact force is also met by accelerating the CoM.

| paper          | here                                         |
|----------------|----------------------------------------------|
| M              | `inertia`, the diagonal of M in eq. 18       |
| R_f            | `com_acceleration()`          |
| g_a            | `gain`                                       |
| s_a,f          | `single_support()`, from measured contacts   |
| K_a,x          | `decay_gain`                                 |
| Delta w_a,f'   | `com_dynamics_rate`, eq. 20                  |

K_a,x and the limits are our own choice; the paper gives no numbers. With K_a,x = 1/delta the motion
of the CoM ends as fast as an error of the contact force.
"""

from dataclasses import dataclass

import numpy as np

from lola_drake.block import Block, Part, law
from lola_drake.parameters import parameter, validate
from lola_drake.signals import COM_DYNAMICS_RATE, DESIRED_WRENCH, PERIOD, TASK_REFERENCE


@dataclass(frozen=True)
class ComDynamicsParams:
    """Gains and limits of the integrated CoM dynamics."""

    gain: float = parameter(
        1.0,
        "g_a, 0 switches it off (paper)",
        "-",
        minimum=0,
        maximum=1,
        symbol="g_a",
        slider=(0, 1, 0.05),
    )
    decay_gain: float = parameter(
        50.0,
        "K_a,x, decay outside single support (own choice, 1/delta)",
        "1/s",
        minimum=0,
        maximum=500,
        symbol="K_a,x",
        slider=(0, 100, 1),
    )
    max_height_rate: float = parameter(0.4, "limit of the vertical part", "m/s", above=0, maximum=5)
    max_angle_rate: float = parameter(
        1.5, "limit of the angular parts", "rad/s", above=0, maximum=20
    )

    def __post_init__(self):
        validate(self)

    @property
    def limits(self) -> np.ndarray:
        """Return the limits of Delta w_a,f' (sin gamma_x, sin gamma_y, z), shape (3,)."""
        return np.array([self.max_angle_rate, self.max_angle_rate, self.max_height_rate])


def com_acceleration(inertia, r_x, r_y, e_x, e_y, e_z):
    """Return Delta a = M^-1 R_f e (eq. 18): phi_x'', phi_y'' (rad/s^2), z_c'' (m/s^2).

    Args:
        inertia: theta_xx, theta_yy (kg m^2) and mass (kg), the diagonal of M.
        r_x: from the CoM to the foot in T (m).
        r_y: the same along y.
        e_x: e, what the foot's torque lacks about x (Nm).
        e_y: the same about y.
        e_z: what its vertical force lacks (N).
    """
    return (e_x + r_y * e_z) / inertia[0], (e_y - r_x * e_z) / inertia[1], e_z / inertia[2]


def single_support(contact, foot):
    """Return s_a,f: whether the foot, and not the other one, has closed contacts.

    Args:
        contact: the switches of the left and then the right foot, 0 or 1, shape (8,).
        foot: 0 for left, 1 for right.
    """
    left = contact[0] + contact[1] + contact[2] + contact[3] > 0
    right = contact[4] + contact[5] + contact[6] + contact[7] > 0
    return (left and not right) if foot == 0 else (right and not left)


def limited_step(rate, change, limit, modification, modification_limit):
    """Return one direction of the integrator's next state.

    It is clamped, and does not grow where it drives the modification beyond its limit: there the
    integrator's output has no effect (anti-windup).

    Args:
        rate: the present state, an entry of Delta w_a,f'.
        change: what the integration would add.
        limit: greatest magnitude of the state.
        modification: the same entry of Delta w.
        modification_limit: its greatest magnitude.
    """
    at_limit = abs(modification) >= modification_limit * (1 - 1e-9)
    if at_limit and change * modification > 0 and rate * modification >= 0:
        return rate
    return min(max(rate + change, -limit), limit)


class ComDynamics(Block):
    """Integrates the force error of the stance foot into a motion of that foot.

    Its state is Delta w_a,f' (rates of sin gamma_x, sin gamma_y and z).
    """

    Params = ComDynamicsParams
    state = (COM_DYNAMICS_RATE,)
    parts = {
        "r": Part(TASK_REFERENCE, "w"),
        "wrench": Part(DESIRED_WRENCH, "wrench"),
    }

    @law
    def next_com_dynamics_rate(
        com_dynamics_rate,
        wrench,
        contact_wrench,
        contact,
        r,
        task_modification,
        gain,
        decay_gain,
        inertia,
        limits,
        modification_limits,
        foot,
    ):
        """Integrate eq. 20 over one period."""
        rate = com_dynamics_rate
        if single_support(contact, foot):
            a_x, a_y, a_z = com_acceleration(
                inertia,
                r[0],
                r[1],
                wrench[0] - contact_wrench[0],
                wrench[1] - contact_wrench[1],
                wrench[2] - contact_wrench[2],
            )
            step = -gain * PERIOD
            d_x, d_y, d_z = step * a_x, step * a_y, step * a_z
        else:
            step = -decay_gain * PERIOD
            d_x, d_y, d_z = step * rate[0], step * rate[1], step * rate[2]
        delta, most = task_modification, modification_limits
        return (
            limited_step(rate[0], d_x, limits[0], delta[0], most[0]),
            limited_step(rate[1], d_y, limits[1], delta[1], most[1]),
            limited_step(rate[2], d_z, limits[2], delta[2], most[2]),
        )
