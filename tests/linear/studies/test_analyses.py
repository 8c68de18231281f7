"""Named analyses, their texts, numbers and pictures, and the commands."""

import json
from dataclasses import replace

import control
import numpy as np
import pytest
from typer.testing import CliRunner

import lola_drake as lola
from lola_drake.cli.app import app
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.presentation.analysis_figures import analysis_figure
from lola_drake.linear.presentation.report import as_numbers, report
from lola_drake.linear.studies import measured_steps as measured_steps_module
from lola_drake.linear.studies.analyses import (
    Locus,
    analyse,
    open_at,
    part,
    root_locus,
    settled_step,
    step_response,
)
from lola_drake.linear.studies.named_analyses import NAMED_ANALYSES, named_analysis
from lola_drake.linear.studies.tables import contact_responses
from lola_drake.linear.studies.workpoint import make_workpoint
from lola_drake.robot import PADS
from lola_drake.theory.contact_model import contact_matrix


@pytest.fixture(scope="module")
def scenario():
    return lola.load_scenario("stand")


@pytest.fixture(scope="module")
def stabilizer(scenario):
    return analyse("stabilizer", scenario, locus=False)


@pytest.mark.parametrize("name", NAMED_ANALYSES)
def test_every_named_analysis_is_complete(name):
    how = named_analysis(name)
    assert len(how.steps) == len(how.inputs)
    assert len(how.units) == len(how.inputs)
    assert len(how.outputs) >= len(how.inputs)
    assert list(how.values) == sorted(how.values)


def test_the_stabilizers_loop_is_opened_at_the_imu(stabilizer):
    imu, *torques = stabilizer.loops
    assert imu.transfer.ninputs == 4
    assert all(m.stable for m in imu.margins)
    assert imu.together.disk < min(m.disk for m in imu.margins) + 1e-9
    for loop in torques:
        # The robot falls over without the stabiliser: less gain than this does not hold it.
        assert 0.2 < loop.margins[0].gain_down < 1 < loop.margins[0].gain_up


def test_an_analysis_says_it_all_in_text(stabilizer):
    text = report(stabilizer)
    assert "at stand, an equilibrium to" in text
    assert "Margins, opened at torso_orientation" in text
    assert "plant/q/torso_rot_z (100%)" in text
    assert "neutral" in text


def test_an_analysis_is_plain_numbers_too(stabilizer):
    numbers = json.loads(json.dumps(as_numbers(stabilizer), allow_nan=False))
    assert numbers["analysis"] == "stabilizer"
    assert numbers["margins"]["modified_wrench.T.x"]["signals"][0]["stable"] is True
    assert len(numbers["poles"]) > 20


def test_an_analysis_has_a_picture(stabilizer):
    """Gain, phase, poles twice, two steps, Nyquist, S and T; every loop in each of them."""
    axes = analysis_figure(stabilizer).axes
    assert len(axes) == 8
    gain, *_, nyquist, sensitivity = axes
    assert gain.get_title("left") == "all 6 loops, and their disk margins"
    worst = min(m.disk for loop in stabilizer.loops for m in loop.margins)
    assert f"the disk of {worst:.3g}" in nyquist.get_title("left")
    assert len(sensitivity.lines) == 2 * 6 + 1


def test_a_picture_of_more_loops_than_colours_says_which_it_shows(scenario):
    axes = analysis_figure(analyse("full", scenario, locus=False)).axes
    assert axes[0].get_title("left").startswith("6 of 17 loops")
    assert any("phi_dot/y" in text.get_text() for text in axes[1].get_legend().get_texts())


def test_the_picture_shows_every_pole(stabilizer):
    plane = analysis_figure(stabilizer).axes[2]
    drawn = next(line for line in plane.lines if "poles" in line.get_label())
    assert len(drawn.get_xdata()) == len(stabilizer.poles)


def test_a_root_locus_says_over_what_and_its_unit(stabilizer):
    poles = np.array([pole.z for pole in stabilizer.poles])
    locus = Locus("control.force.time_constant", (0.01, 0.02), (poles, poles), 0.02)
    labels = [ax.get_ylabel() for ax in analysis_figure(replace(stabilizer, locus=locus)).axes]
    assert "control.force.time_constant (s)" in labels


def test_a_step_response_starts_with_the_direct_part():
    model = control.ss(0.5, 1.0, 2.0, 3.0, 1e-3)
    _, outputs = step_response(model, 0, 10.0, duration=3e-3)
    np.testing.assert_allclose(outputs[:, 0], [30.0, 50.0, 60.0])


def test_a_step_response_ends_when_it_has_settled():
    slow = control.ss(np.exp(-1e-3 / 0.2), 1.0, 1.0, 0.0, 1e-3)
    times, outputs, settled = settled_step(slow, 0, 1.0)
    assert settled
    assert times[-1] == pytest.approx(1.3 * 0.2 * np.log(50), rel=0.05)
    assert not settled_step(control.ss(1.0, 1.0, 1.0, 0.0, 1e-3), 0, 1.0)[2]


@pytest.mark.parametrize("name", ["stabilizer", "full"])
def test_a_step_moves_the_output_of_the_same_number(scenario, standing, name):
    """10 N or 10 Nm incline the torso by more than 1 mrad within half a second."""
    how = NAMED_ANALYSES[name]
    workpoint = make_workpoint(scenario, "stand", how.inputs, how.outputs, standing)
    for k, height in enumerate(how.steps):
        _, outputs = step_response(part(workpoint, how), k, height)
        assert 1e-3 < np.abs(outputs[:, k]).max() < 0.1


def test_a_root_locus_turns_one_parameter(scenario, standing):
    how = NAMED_ANALYSES["stabilizer"]
    workpoint = make_workpoint(
        scenario, "stand", (*how.inputs, *how.outputs), how.outputs, standing
    )
    locus = root_locus(workpoint, how)
    assert locus.nominal in locus.values
    fastest = [np.abs(z).max() for z in locus.poles]
    assert fastest[0] < 1 + 1e-6 < fastest[-1], "too much damping makes it unstable"
    nominal = locus.poles[locus.values.index(locus.nominal)]
    np.testing.assert_allclose(
        np.sort(np.abs(nominal)),
        np.sort(np.abs(np.linalg.eigvals(part(workpoint, how).A))),
        atol=1e-6,
    )


@pytest.mark.parametrize(
    ("ground", "frequency"),
    [({"ground.friction_speed": 1e-4}, 1.0), ({}, 5.0)],
    ids=["held", "default"],
)
def test_the_contact_in_the_plant_is_the_one_of_the_model(ground, frequency):
    """U of the paper's eq. 8 with the ground's stiffness, at a slow motion.

    With the load in the middle of the foot, so that every pad bears with all of its area. At 1 Hz
    on ground that holds the pads: where they creep, the toe yields to a slow load. On the default
    ground, where they do, at 5 Hz.
    """
    scenario = lola.load_scenario(
        "stand", {"pattern.zmp_forward": 0, "pattern.zmp_inward": 0} | ground
    )
    names = (*NAMED_ANALYSES["contact"].opened, "contact_wrench_l")
    workpoint = make_workpoint(scenario, "left", names, names)
    stiffness, _ = contact_responses(workpoint, (frequency,))
    area = sum(pad.area for pad in PADS)
    U = contact_matrix(PADS, scenario.ground.stiffness / area)
    np.testing.assert_allclose(np.diag(stiffness[0]).real, np.diag(U), rtol=0.03)


def test_the_com_dynamics_are_a_loop_in_single_support_only(scenario, standing, on_left):
    signals = ("com_dynamics_rate_l",)
    double, single = (
        open_at(make_workpoint(scenario, point.description, signals, signals, point), signals[0])
        for point in (standing, on_left)
    )
    assert double.transfer.nstates == 0
    assert single.transfer.nstates > 50


def test_an_analysis_that_does_not_exist_is_one_clear_error():
    with pytest.raises(AnalysisError, match="no analysis 'force', did you mean force_loop?"):
        named_analysis("force")


def test_the_command_writes_a_picture_and_prints_numbers(tmp_path):
    arguments = ["linearize", "force_loop", "--no-locus", "--json", "-o", str(tmp_path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["at"] == "stand"
    assert (tmp_path / "force_loop.png").stat().st_size > 10_000
    assert (tmp_path / "force_loop.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["linearize", "nothing"], "no analysis 'nothing'"),
        (["linearize", "full", "--at", "moon"], "no operating point 'moon'"),
        (["linearize", "full", "--scenario", "moon"], "no such scenario"),
        (["map", "moon"], "no map 'moon'"),
        (["map", "gains", "--at", "t=0.01"], "a map needs a pose"),
        (["poincare", "stand"], "stand has no steps"),
    ],
)
def test_a_command_that_cannot_be_done_is_one_line(arguments, message, tmp_path):
    result = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path)])
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.strip().startswith("lola: ")


def test_small_steps_of_the_simulation_are_those_of_the_model(stabilizer, monkeypatch):
    monkeypatch.setattr(measured_steps_module, "LONGEST", 0.05)
    for steps in measured_steps_module.measured_steps(stabilizer, factors=(0.1,)):
        (simulated,) = steps.simulated.values()
        assert len(steps.times) == 50 and np.ptp(steps.linear) > 0
        assert simulated == pytest.approx(steps.linear, abs=2e-3 * np.abs(steps.linear).max())
