"""Newton closes in every scenario: what the CoM does is gravity, the recorded forces and pushes."""

import numpy as np
import pytest
from momentum import force_residual

from lola_drake.paths import scenario_paths

AT_ONCE = ("walk.start_time=0", "pattern.first_double_support=0.3")
UNEXPECTED = (*AT_ONCE, "duration=6")
"""Until the unexpected contact is over, or has begun."""

FLAT = {name: () for name in ("walk_flat", "walk_fast", "walk_turn", "step_in_place")}
FLAT["stand"] = ("duration=2",)
CHANGES = dict.fromkeys(sorted(scenario_paths()), UNEXPECTED) | FLAT


@pytest.mark.parametrize("scenario", CHANGES)
def test_what_the_com_does_is_what_forces_do(run, scenario):
    """Within the force sensors' noise of 2 N, and 1 % of a force's change in an impact."""
    result = run(scenario, *CHANGES[scenario])
    residual = force_residual(result)
    # As the ground's, a push that is recorded has acted from the tick before on.
    for push in result.scenario.pushes:
        residual -= [push.force(tick) for tick in range(1, len(residual) + 1)]
    changes = np.diff(result.signals["ground_force"].reshape(-1, 2, 3).sum(axis=1), axis=0)
    impact = 0.0 if scenario in FLAT else np.abs(changes).max()
    assert np.abs(residual).max() < 2.0 + 0.01 * impact
    assert np.sqrt(np.mean(residual**2)) < 0.3
