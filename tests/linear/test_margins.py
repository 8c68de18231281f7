"""Margins of loops whose margins are known."""

import warnings

import control
import numpy as np
import pytest
from linear_toys import PERIOD, discrete, loop

import lola_drake as lola
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.frequency import frequency_response
from lola_drake.linear.margins import (
    disk_gain,
    disk_phase,
    loop_margins,
    margins,
    matrix_margins,
    one_loop,
)
from lola_drake.linear.poles import poles


def sampled(transfer: control.TransferFunction) -> control.StateSpace:
    """Return a continuous loop, sampled, with names."""
    system = control.ss(control.c2d(transfer, PERIOD, "zoh"))
    return control.ss(system, inputs=["u"], outputs=["y"])


def test_the_response_is_the_transfer_function():
    loop_transfer = sampled(control.tf([1], [0.02, 1]))
    frequencies = np.array([0.1, 10.0, 300.0])
    z = np.exp(2j * np.pi * frequencies * PERIOD)
    found = frequency_response(loop_transfer, frequencies).values[:, 0, 0]
    np.testing.assert_allclose(found, loop_transfer(z), rtol=1e-12)


def test_an_integrator_with_delay_has_its_textbook_margins():
    """L = (10 rad/s) / s, held over the period: phase 90 deg less 0.29 deg at the crossover."""
    result = margins(sampled(control.tf([10], [1, 0])))
    assert result.stable
    assert result.phase == pytest.approx(90 - np.degrees(10 * PERIOD / 2), abs=1e-2)
    assert result.phase_frequency == pytest.approx(10 / (2 * np.pi), rel=1e-4)
    assert result.delay == pytest.approx(np.pi / 2 / 10 - PERIOD / 2, rel=1e-4)
    assert result.gain_up == pytest.approx(2 / (10 * PERIOD), rel=1e-3)
    assert result.gain_down == 0.0


def test_an_unstable_plant_can_lose_gain_too():
    """L = 3 / (s - 1) needs a gain above 1/3."""
    result = margins(sampled(control.tf([3], [1, -1])))
    assert result.stable
    assert result.gain_down == pytest.approx(1 / 3, rel=1e-3)
    assert not margins(sampled(control.tf([0.9], [1, -1]))).stable


def test_margins_agree_with_python_control():
    transfer = sampled(control.tf([400], [1, 14, 40, 0]))
    result = margins(transfer)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it changes its method by itself
        gain, phase, distance, at_gain, at_phase, _ = control.stability_margins(transfer)
    assert result.gain_up == pytest.approx(gain, rel=1e-3)
    assert result.gain_up_frequency == pytest.approx(at_gain / (2 * np.pi), rel=1e-3)
    assert result.phase == pytest.approx(phase, rel=1e-3)
    assert result.phase_frequency == pytest.approx(at_phase / (2 * np.pi), rel=1e-3)
    assert result.peak_sensitivity == pytest.approx(1 / distance, rel=1e-3)
    disk = control.disk_margins(transfer, 2 * np.pi * np.geomspace(1e-2, 499, 3000))[0]
    assert result.disk == pytest.approx(disk, rel=1e-3)


def test_a_disk_margin_says_what_gain_and_phase_it_allows():
    assert disk_gain(2 / 3) == pytest.approx((0.5, 2.0))
    assert disk_phase(2.0) == pytest.approx(90.0)


def test_two_loops_are_judged_alone_and_together():
    """One channel's units may be any: the result is the same."""
    A, B, C = np.diag([0.99, 0.98]), np.array([[0.02, 0.01], [0.0, 0.05]]), np.eye(2)
    units = np.diag([1.0, 1e4])
    results = []
    for scale in (np.eye(2), units):
        plant = discrete(A, B @ np.linalg.inv(scale), scale @ C)
        diagram = loop(plant)
        transfer = lola.open_loop(diagram, "plant.y0", diagram.CreateDefaultContext())
        assert [m.stable for m in loop_margins(transfer)] == [True, True]
        results.append(matrix_margins(transfer))
    assert results[1].disk == pytest.approx(results[0].disk, rel=0.01)
    assert 0 < results[0].disk < 2


def test_one_loop_of_two_has_the_other_closed():
    rng = np.random.default_rng(3)
    A = 0.5 * np.diag(rng.random(3))
    B, C, D = rng.random((3, 2)), rng.random((2, 3)), rng.random((2, 2))
    both = control.ss(A, B, C, D, PERIOD)
    z = np.exp(0.3j)
    L = both(z)
    expected = L[0, 0] - L[0, 1] * L[1, 0] / (1 + L[1, 1])
    assert complex(one_loop(both, 0)(z)) == pytest.approx(expected)


def test_a_matrix_has_no_margins_of_one_signal():
    with pytest.raises(AnalysisError, match="a loop of 2 signals"):
        margins(control.ss(np.eye(2), np.eye(2), np.eye(2), np.zeros((2, 2)), PERIOD))


def test_poles_say_frequency_damping_and_whose_they_are():
    s = -2 * np.pi * 5 * (0.3 + 1j * np.sqrt(1 - 0.09))
    z = np.exp(s.conjugate() * PERIOD)
    A = [[z.real, z.imag * 100, 0], [-z.imag / 100, z.real, 0], [0, 0, 0.5]]
    system = control.ss(
        A, np.ones((3, 1)), np.ones((1, 3)), 0, PERIOD, states=["angle", "rate", "filter"]
    )
    slow, fast = poles(system)
    assert (slow.frequency, slow.damping) == pytest.approx((5.0, 0.3))
    assert slow.dominating in ("angle", "rate")
    assert slow.participation == pytest.approx(0.5)
    assert (fast.dominating, fast.participation) == ("filter", pytest.approx(1.0))
