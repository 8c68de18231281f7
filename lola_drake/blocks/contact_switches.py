"""The contact switches of the foot pads: closed by force, opened by its absence.

Each pad of LOLA carries a binary switch; the thresholds are estimates.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults

from lola_drake.block import Block, Reading, law
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


class ContactSwitches(Block):
    """Watches the normal force of every pad of both feet.

    The ground's force on each foot is the truth of the simulation, for logs and tests; no block of
    the controller reads it.
    """

    Params = ContactSwitchesParams
    kind = "sensor"
    state = (CONTACT, GROUND_FORCE)
    objects = {"pad_forces": Reading("contact_results", Value[ContactResults], 3 * _SWITCHES)}
    switching = True

    def __init__(self, params: ContactSwitchesParams, pads: Mapping[int, int]):
        """Create the switches of the given pads, all closed.

        Args:
            params: thresholds.
            pads: which switch (0 to 7) belongs to which collision geometry, by the value of its id.
        """
        self._pads = pads
        super().__init__(params, initial={CONTACT.name: np.ones(_SWITCHES)})

    def read_pad_forces(self, results: ContactResults) -> list[float]:
        """Return the ground's force on every pad in W (N), pad by pad, shape (24,)."""
        forces = [0.0] * (3 * _SWITCHES)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            surface = info.contact_surface()
            # The reported force acts on geometry M; a pad may be either of the two.
            pad, sign = self._pads.get(surface.id_M().get_value()), 1.0
            if pad is None:
                pad, sign = self._pads.get(surface.id_N().get_value()), -1.0
            if pad is not None:
                for axis, force in enumerate(info.F_Ac_W().translational().tolist()):
                    forces[3 * pad + axis] += sign * force
        return forces

    @law
    def next_contact(contact, pad_forces, close_force, open_force):
        """Return the new state of the switches, 1 for closed: they have a hysteresis."""
        closed = np.zeros(len(contact))
        for pad in range(len(contact)):
            threshold = open_force if contact[pad] > 0.5 else close_force
            closed[pad] = 1.0 if pad_forces[3 * pad + 2] > threshold else 0.0
        return closed

    @law
    def next_ground_force(pad_forces):
        """Return the sum of each foot's pads (N)."""
        total = np.zeros(6)
        for pad in range(8):
            for axis in range(3):
                total[3 * (pad // 4) + axis] += pad_forces[3 * pad + axis]
        return total
