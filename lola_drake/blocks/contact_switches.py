"""The contact switches of the foot pads: closed by force, opened by its absence.

Each pad of LOLA carries a binary switch; the thresholds are estimates.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import LeafSystem

from lola_drake.parameters import ParameterError, parameter, validate
from lola_drake.signals import CONTACT, GROUND_FORCE

_SWITCHES = CONTACT.size


@dataclass(frozen=True)
class ContactSwitchesParams:
    """Thresholds of the switches."""

    close_force: float = parameter(15.0, "closes the switch (estimate)", "N", above=0, maximum=500)
    open_force: float = parameter(8.0, "opens the switch (estimate)", "N", above=0, maximum=500)

    def __post_init__(self):
        validate(self)
        if self.open_force > self.close_force:
            raise ParameterError(
                "open_force", self.open_force, f"<= close_force {self.close_force}"
            )

    def ideal(self) -> "ContactSwitchesParams":
        """Return switches that close at the lightest touch and have no hysteresis."""
        return ContactSwitchesParams(close_force=1.0, open_force=1.0)


class ContactSwitches(LeafSystem):
    """Watches the normal force of every pad of both feet.

    The state is the switches, 1 for closed, and the ground's force on each foot; the latter is the
    truth of the simulation, for logs and tests, and no block of the controller reads it.

    .. pydrake_system::

        name: ContactSwitches
        input_ports:
        - contact_results
        output_ports:
        - contact
        - ground_force
    """

    def __init__(self, params: ContactSwitchesParams, pads: dict[int, int], period: float):
        """Create the switches of the given pads, all closed.

        Args:
            params: thresholds.
            pads: which switch (0 to 7) belongs to which collision geometry, by the value of its id.
            period: the control period (s).
        """
        super().__init__()
        self._params, self._pads = params, pads
        self._results = self.DeclareAbstractInputPort("contact_results", Value[ContactResults]())
        self._state = self.DeclareDiscreteState(np.ones(_SWITCHES))
        self._ground_force = self.DeclareDiscreteState(GROUND_FORCE.size)
        self._contact = self.DeclareStateOutputPort(CONTACT.name, self._state)
        self.DeclareStateOutputPort(GROUND_FORCE.name, self._ground_force)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        forces = pad_forces(self._results.Eval(context), self._pads)
        closed = self._contact.Eval(context).tolist()
        close_force, open_force = self._params.close_force, self._params.open_force
        state.set_value(
            self._state,
            [
                switched(was_closed, force[2], close_force, open_force)
                for was_closed, force in zip(closed, forces, strict=True)
            ],
        )
        feet = forces[:4], forces[4:]
        state.set_value(
            self._ground_force, [sum(f) for foot in feet for f in zip(*foot, strict=True)]
        )


def switched(closed: float, force: float, close_force: float, open_force: float) -> float:
    """Return the new state of a switch, 1 for closed: it has a hysteresis."""
    return float(force > (open_force if closed else close_force))


def pad_forces(results: ContactResults, pads: dict[int, int]) -> list[list[float]]:
    """Return the ground's force on every pad in W (N), shape (8, 3)."""
    forces = [[0.0, 0.0, 0.0] for _ in range(_SWITCHES)]
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        # The reported force acts on geometry M; a pad may be either of the two.
        pad, sign = pads.get(surface.id_M().get_value()), 1.0
        if pad is None:
            pad, sign = pads.get(surface.id_N().get_value()), -1.0
        if pad is not None:
            f_x, f_y, f_z = info.F_Ac_W().translational().tolist()
            x, y, z = forces[pad]
            forces[pad] = [x + sign * f_x, y + sign * f_y, z + sign * f_z]
    return forces
