"""Missed cycles of the bus: which they are, and that sensors then say what they said before."""

import numpy as np
import pytest

from lola_drake.bus import MissedCycles, gaps_of, is_missed
from lola_drake.scenario import load_scenario
from lola_drake.simulation import ENGINES, simulate


def test_cycles_are_missed_tick_by_tick():
    gaps = gaps_of((MissedCycles(0.003, 2), MissedCycles(0.0085, 1)))
    missed = [k for k in range(12) if is_missed(k * 1e-3, gaps)]
    assert missed in ([3, 4, 8], [3, 4, 9])
    assert gaps_of(()).shape == (0, 2) and not is_missed(0.0, gaps_of(()))


@pytest.mark.parametrize("engine", ENGINES)
def test_in_a_missed_cycle_sensors_say_what_they_said_before(engine):
    missed = {"duration": 0.05, "sensors.missed": [{"time": 0.02, "count": 3}]}
    signals = simulate(load_scenario("stand", missed), engine=engine).signals
    for name in ("torso_orientation", "measured_wrench"):
        changes = np.any(np.diff(signals[name], axis=0), axis=1)
        # What arrives in a tick is known in the next one.
        assert np.flatnonzero(~changes[5:]).tolist() == [15, 16, 17], name
