"""CoM, ZMP, DCM and centre of pressure."""

import numpy as np
import pytest

from lola_drake.figures.balance import balance, centre_of_pressure
from lola_drake.signals import CONTACT_WRENCH
from lola_drake.theory.constants import GRAVITY


@pytest.fixture
def result(make_result):
    return make_result(steps=1)


def test_the_dcm_is_ahead_of_a_moving_com(result):
    com = result.signals["com_position"]
    com[:, 0], com[:, 2] = 0.4 * result.times, 0.9
    at = balance(result)
    assert at.dcm[100] - at.com[100] == pytest.approx([0.4 * np.sqrt(0.9 / GRAVITY), 0.0])


def test_the_dcm_of_a_fallen_robot_is_a_number(result):
    assert np.isfinite(balance(result).dcm).all()


def test_pressure_acts_in_the_foot_where_its_torques_say(result):
    result.signals["contact_wrench_l"][:, CONTACT_WRENCH.slice("wrench")] = (6.0, -12.0, 300.0)
    assert centre_of_pressure(result, "l")[0] == pytest.approx([0.04, 0.02])
    assert np.isnan(centre_of_pressure(result, "r")).all()
