"""The predecessor's force control walks; the paper says: equivalently in normal walking."""

import numpy as np
import pytest

from lola_drake.signals import TASK_REFERENCE


@pytest.fixture
def pair(run):
    return [run("walk_flat", "duration=7", f"variant={name}") for name in ("ref", "original")]


def test_it_walks_as_well_as_the_papers_contact_model(pair):
    ref, original = pair
    assert original.completed
    speeds = [result.metrics["mean_speed_m_per_s"] for result in pair]
    assert speeds[1] == pytest.approx(speeds[0], rel=0.01)
    for metric, margin in (("max_inclination_deg", 0.1), ("rms_torque_error_Nm", 1.0)):
        for axis in "xy":
            expected = ref.metrics[metric][axis]
            assert original.metrics[metric][axis] == pytest.approx(expected, abs=margin)


def test_its_records_mean_the_same(pair):
    """Where the joint command takes the feet is the plan and the modification together."""
    _, original = pair
    controlled = [3, 4, 2]
    for foot in "lr":
        planned = original.signals["task_reference"][:, TASK_REFERENCE.slice(f"w_{foot}")]
        commanded = original.signals[f"task_command_{foot}"][:, :6]
        modified = original.signals[f"task_modification_{foot}"]
        np.testing.assert_allclose(
            commanded[:, controlled], planned[:, controlled] + modified, atol=1e-12
        )
        held = commanded[:, [0, 1, 5]] - planned[:, [0, 1, 5]]
        assert np.abs(held).max() < 1e-3


def test_its_com_dynamics_are_switched_off(pair):
    _, original = pair
    for foot in "lr":
        assert not original.signals[f"com_dynamics_rate_{foot}"].any()
