"""The layout of the signals: every entry has a name, a unit and, in space, a frame."""

import pytest

from lola_drake.logged import LOGGED
from lola_drake.signals import JOINTS, PERIOD, TASK_REFERENCE, on_tick

SIGNALS = pytest.mark.parametrize("signal", LOGGED.values(), ids=lambda signal: signal.name)


@SIGNALS
def test_every_entry_has_a_name_a_unit_and_a_place_for_its_frame(signal):
    for entries in (signal.entry_names(), signal.entry_units(), signal.entry_frames()):
        assert len(entries) == signal.size
    assert len(set(signal.entry_names())) == signal.size
    assert all(unit and "," not in unit for unit in signal.entry_units())


@SIGNALS
def test_everything_in_space_has_a_frame(signal):
    spatial = {"m", "m/s", "N", "Nm", "N/s", "Nm/s", "rad/s"}
    for field in signal.fields:
        scalar = field.entries == JOINTS or field.name.startswith("toe")
        assert scalar or field.frame or not spatial & set(field.units), field.name


def test_the_units_of_a_foot_differ_by_entry():
    units = dict(zip(TASK_REFERENCE.entry_names(), TASK_REFERENCE.entry_units(), strict=True))
    assert [units[f"w_l.{entry}"] for entry in ("x", "sin_gamma_x", "gamma_z")] == ["m", "-", "rad"]
    assert units["w_dot_r.sin_gamma_y"] == "1/s"


def test_a_sum_of_steps_ends_on_a_tick():
    time = 1.0 + 0.8 + 2 * 0.8
    assert time != 3400 * PERIOD, "or this shows nothing"
    assert on_tick(time) == 3400 * PERIOD
