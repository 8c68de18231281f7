"""Contacts that come before or after their time: what the plan did not expect."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lola_drake.results import Result
from lola_drake.signals import CONTACT, FEET, GAIT_PHASE

PUNCTUAL = 0.06
"""A landing counts as early or late from this difference to its planned time on (s)."""


@dataclass(frozen=True)
class Landing:
    """One landing of a swing foot.

    Attributes:
        foot: "l" or "r".
        planned: when the plan at lift-off wanted it (s).
        measured: when the first contact switch closed (s).
    """

    foot: str
    planned: float
    measured: float

    @property
    def kind(self) -> str:
        """Return "early", "late", or "punctual"."""
        if abs(self.measured - self.planned) < PUNCTUAL:
            return "punctual"
        return "early" if self.measured < self.planned else "late"


def landings(result: Result) -> list[Landing]:
    """Return every landing of a run in the order of time.

    The contacts are looked at from the middle of the planned swing on, when the foot has long
    left the ground; a swing that ends without a contact is left out.
    """
    times, pattern = result.times, result.scenario.pattern
    swing = pattern.step_time - pattern.double_support
    support = result.signals["gait_phase"][:, GAIT_PHASE.slice("support")]
    found = []
    for i, foot in enumerate(FEET):
        pads = result.signals["contact"][:, CONTACT.slice(f"pads_{foot}")]
        closing = times[1:][np.diff(pads.any(axis=1).astype(int)) > 0]
        lift_offs = times[1:][np.diff(support[:, i]) < 0]
        for lift_off, following in pairwise([*lift_offs, np.inf]):
            candidates = closing[(closing > lift_off + 0.5 * swing) & (closing < following)]
            if len(candidates):
                found.append(Landing(foot, float(lift_off + swing), float(candidates[0])))
    return sorted(found, key=lambda landing: landing.measured)


def surprises(results: Sequence[Result]) -> list[tuple[Landing, ...]]:
    """Return the landings, one of each run, that came early or late in all of the runs.

    Each landing of a run is held against that of the same number in the others; the run that ends
    first ends the list.
    """
    together = zip(*map(landings, results), strict=False)
    return [same for same in together if _surprise(same)]


def _surprise(same: Sequence[Landing]) -> bool:
    one_foot = len({landing.foot for landing in same}) == 1
    return one_foot and all(landing.kind != "punctual" for landing in same)
