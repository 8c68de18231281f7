"""The pads' forces, read off poses alone."""

import numpy as np
import pytest

from lola_drake.pad_forces import PAD_NAMES, pad_forces


def test_pads_bear_what_the_feet_bear_at_rest(standing_run):
    samples = np.array([len(standing_run.times) - 1])
    (forces,) = pad_forces(standing_run, samples)
    ground = standing_run.signals["ground_force"][-1]
    assert len(PAD_NAMES) == 8 and (forces > 0).all()
    assert forces.reshape(2, 4).sum(axis=1) == pytest.approx(ground[[2, 5]], rel=0.02)


def test_nothing_presses_on_a_foot_in_the_air(standing_run):
    lifted = {name: values.copy() for name, values in standing_run.signals.items()}
    lifted["torso_pose"][:, 2] += 0.1
    in_air = type(standing_run)(**{**vars_of(standing_run), "signals": lifted})
    assert not pad_forces(in_air, np.array([0, 100])).any()


def vars_of(result):
    names = ("scenario", "times", "signals", "completed", "fall_time", "wall_time", "versions")
    return {name: getattr(result, name) for name in names}


@pytest.fixture(scope="module")
def standing_run():
    from lola_drake.scenario import load_scenario
    from lola_drake.simulation import simulate

    return simulate(load_scenario("stand", {"duration": 1.0}))
