"""Margins of loops whose margins are known."""

import warnings

import control
import numpy as np
import pytest
from linear_toys import PERIOD, discrete, loop

import lola_drake as lola
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.frequency import frequency_data, frequency_response, zeros
from lola_drake.linear.margin import disk_gain, disk_phase
from lola_drake.linear.margins import (
    margins,
    one_loop,
    signal_margins,
)
from lola_drake.linear.open_loop import negated
from lola_drake.linear.poles import poles, spectral_radius
from lola_drake.linear.studies.analyses import open_at
from lola_drake.linear.studies.workpoint import make_workpoint


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
    result = signal_margins(sampled(control.tf([10], [1, 0])))
    assert result.stable
    assert result.phase == pytest.approx(90 - np.degrees(10 * PERIOD / 2), abs=1e-2)
    assert result.phase_frequency == pytest.approx(10 / (2 * np.pi), rel=1e-4)
    assert result.delay == pytest.approx(np.pi / 2 / 10 - PERIOD / 2, rel=1e-4)
    assert result.gain_up == pytest.approx(2 / (10 * PERIOD), rel=1e-3)
    assert result.gain_down == 0.0


def test_an_unstable_plant_can_lose_gain_too():
    """L = 3 / (s - 1) needs a gain above 1/3."""
    result = signal_margins(sampled(control.tf([3], [1, -1])))
    assert result.stable
    assert result.gain_down == pytest.approx(1 / 3, rel=1e-3)
    assert not signal_margins(sampled(control.tf([0.9], [1, -1]))).stable


def test_margins_agree_with_python_control():
    transfer = sampled(control.tf([400], [1, 14, 40, 0]))
    result = signal_margins(transfer)
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
        found = lola.margins(transfer)
        assert [m.stable for m in found.each] == [True, True]
        results.append(found.together)
    assert results[1].disk == pytest.approx(results[0].disk, rel=1e-6)
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


@pytest.mark.parametrize(
    ("loop", "message"),
    [
        (control.ss(0.5, np.ones((1, 2)), 1, 0, PERIOD), "as many outputs as inputs, not 1 and 2"),
        (control.ss(-0.5, 1, 1, 0), "discrete-time"),
        (control.tf([1], [1, 0], PERIOD), "discrete-time control.StateSpace"),
    ],
)
def test_what_is_no_loop_is_one_clear_error(loop, message):
    with pytest.raises(AnalysisError, match=message):
        margins(loop)


def test_a_matrix_has_no_margins_of_one_signal():
    with pytest.raises(AnalysisError, match="a loop of 2 signals"):
        signal_margins(control.ss(np.eye(2), np.eye(2), np.eye(2), np.zeros((2, 2)), PERIOD))


def resonance() -> control.StateSpace:
    """Return a 20 Hz resonance of damping 0.02 whose peak is 10."""
    w = 2 * np.pi * 20
    return sampled(control.tf([0.4 * w * w], [1, 2 * 0.02 * w, w * w]))


def test_the_margins_of_a_light_resonance():
    result = signal_margins(resonance())
    assert result.gain_up == pytest.approx(1.594, rel=1e-3)
    assert result.phase == pytest.approx(2.54, rel=1e-3)
    assert result.disk == pytest.approx(0.0440, rel=2e-3)


def test_python_control_finds_the_same_on_the_refined_data():
    loop = resonance()
    found, data = signal_margins(loop), frequency_data(loop)
    gain, phase, distance, at_gain, at_phase, at_peak = control.stability_margins(data)
    assert gain == pytest.approx(found.gain_up, rel=1e-3)
    assert phase == pytest.approx(found.phase, rel=1e-3)
    assert 1 / distance == pytest.approx(found.peak_sensitivity, rel=1e-3)
    frequencies = np.array([at_gain, at_phase, at_peak]) / (2 * np.pi)
    assert frequencies == pytest.approx(
        [found.gain_up_frequency, found.phase_frequency, found.peak_sensitivity_frequency],
        rel=1e-3,
    )
    disk = control.disk_margins(loop, data.frequency)[0]
    assert disk == pytest.approx(found.disk, rel=1e-3)


def test_a_double_integrator_may_lose_any_gain():
    result = signal_margins(sampled(control.tf([40, 100], [1, 0, 0])))
    assert result.stable
    assert (result.gain_down, np.isnan(result.gain_down_frequency)) == (0.0, True)


def test_the_delay_margin_has_a_crossover_of_its_own():
    """The second of two crossovers has more phase, and less time for it."""
    w = 2 * np.pi * 30
    loop = sampled(control.tf([3], [1, 0.5]) + control.tf([0.1 * w * w], [1, 0.04 * w, w * w]))
    result = signal_margins(loop)
    assert result.delay_frequency == pytest.approx(31.4, abs=0.5)
    L = loop(np.exp(2j * np.pi * result.delay_frequency * PERIOD))
    assert abs(L) == pytest.approx(1.0, abs=1e-9)
    late = L * np.exp(-2j * np.pi * result.delay_frequency * result.delay)
    assert late == pytest.approx(-1.0, abs=1e-9)


def test_a_stabiliser_near_its_border_shows_how_near():
    """Its gain margin leads to the border, and there the disk is all but gone."""
    signal = "modified_wrench.T.y"

    def margin(part: float):
        turned = {
            "control.stabilizer.stiffness": 2360 * part,
            "control.stabilizer.damping": 900 * part,
        }
        point = make_workpoint(lola.load_scenario("stand", turned), "stand", [signal], [signal])
        (found,) = open_at(point, signal).margins
        return found

    border = margin(1.0).gain_up
    assert 1.02 < border < 1.2
    near, beyond = margin(0.999 * border), margin(1.001 * border)
    assert near.stable
    assert not beyond.stable
    assert near.gain_up == pytest.approx(1 / 0.999, rel=1e-4)
    assert near.disk < 0.002
    assert near.disk * near.peak_sensitivity == pytest.approx(1, rel=0.1)


def test_zeros_are_where_the_response_is_zero():
    loop = sampled(control.tf([1, 0.2, 400], [1, 14, 40, 0]))
    found, expected = zeros(loop), control.zeros(loop)
    np.testing.assert_allclose(np.sort(found.real), np.sort(expected.real), atol=1e-9)
    np.testing.assert_allclose(np.sort(found.imag), np.sort(expected.imag), atol=1e-9)


def test_a_loop_is_negated_with_its_direct_part():
    block = discrete(0.5, 1.0, 2.0, 3.0)
    context = block.CreateDefaultContext()
    loop = lola.linearize(block, "u0", "y0", context)
    z = np.exp(0.3j)
    assert complex(negated(loop)(z)) == pytest.approx(-complex(loop(z)))


def test_neutral_poles_have_no_part_in_the_spectral_radius():
    assert spectral_radius(np.diag([1.0, 0.9, 1 + 1e-8])) == pytest.approx(0.9)
    assert spectral_radius(np.diag([1.0, 1.1])) == pytest.approx(1.1)


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


def test_a_gain_margin_at_rest_is_taken_at_0_hz():
    """L(1) = -1/2, and nowhere else does L come to the negative axis."""
    found = signal_margins(control.ss(0.5, 1.0, -0.25, 0.0, 0.01))
    assert (found.gain_up, found.gain_up_frequency) == (pytest.approx(2.0), 0.0)
