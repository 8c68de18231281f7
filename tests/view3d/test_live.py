"""Taking part in a running simulation: gains, steering, pushes."""

import types

import numpy as np
import pytest

from lola_drake.blocks.hybrid_force_control import HybridForceControl
from lola_drake.blocks.walking_pattern import pack_request, standing_request
from lola_drake.scenario import load_scenario, override
from lola_drake.simulation import ENGINES, simulate, start
from lola_drake.view3d.controls import PUSHES, STEERING, Controls, gamepad_command
from lola_drake.view3d.frames import frames_of
from lola_drake.view3d.live import LiveView, next_footsteps, push, signals_now
from lola_drake.view3d.scene import open_meshcat


@pytest.fixture(scope="module")
def stand():
    return load_scenario("stand")


@pytest.fixture(params=ENGINES)
def run(request, stand):
    """Return a run that has stood for a twentieth of a second."""
    run = start(stand, engine=request.param)
    run.advance(0.05)
    return run


@pytest.fixture(scope="module")
def meshcat():
    return open_meshcat()


def find(run, name):
    return next(gain for gain in run.gains() if gain.name == name)


def test_gains_are_those_of_the_scenario(run, stand):
    control = stand.control
    params = {
        "imu_stabilizer": control.stabilizer,
        "force_control": control.force,
        "com_dynamics": control.com_dynamics,
    }
    gains = list(run.gains())
    assert {gain.block for gain in gains} == params.keys()
    for gain in gains:
        low, high, _ = gain.field.metadata["slider"]
        assert low <= run.gain(gain) == getattr(params[gain.block], gain.name) <= high


@pytest.mark.parametrize("engine", ENGINES)
def test_the_reference_variant_runs_without_com_dynamics(stand, engine):
    run = start(override(stand, {"variant": "ref"}), engine=engine)
    assert run.gain(find(run, "gain")) == 0.0


@pytest.mark.parametrize("engine", ENGINES)
def test_the_original_variant_runs_without_com_dynamics(stand, engine):
    run = start(override(stand, {"variant": "original"}), engine=engine)
    gains = {gain.name: run.gain(gain) for gain in run.gains()}
    assert gains["time_constant"] == stand.control.force.time_constant
    assert gains["gain"] == 0.0


@pytest.mark.parametrize(
    ("gain", "signal"),
    [
        ("time_constant", "task_command_l"),
        ("stiffness", "modified_wrench"),
        ("damping", "joint_command"),
    ],
)
def test_a_gain_acts_without_a_rebuild(run, gain, signal):
    before, changed = run.signal(signal).copy(), find(run, gain)
    value = run.gain(changed)
    run.set_gain(changed, 2 * value)
    assert np.abs(run.signal(signal) - before).max() > 1e-6
    assert run.gain(changed) == 2 * value
    run.set_gain(changed, value)
    assert run.signal(signal) == pytest.approx(before, abs=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_twice_the_time_constant_halves_the_answer_to_a_force_error(stand, engine):
    def behind_rigid_servos(block):
        constants = block.constants | {"compliance": np.zeros((3, 3))}
        return HybridForceControl(block.params, block.foot, **constants)

    run, rates = start(stand, {"force_control": behind_rigid_servos}, engine), []
    run.advance(0.05)
    for factor in (1.0, 2.0, 1e9):
        run.set_gain(find(run, "time_constant"), 0.02 * factor)
        rates.append(run.signal("task_command_l")[6 + 2])
    fast, slow, none = rates
    # Half of it but for what the period adds: the rate is held.
    expected = (1 - np.exp(-0.025)) / (1 - np.exp(-0.05))
    assert (slow - none) / (fast - none) == pytest.approx(expected, rel=1e-6)


def test_only_a_slider_that_was_moved_changes_its_gain(run, meshcat):
    run.set_gain(find(run, "position_gain"), 10.123)  # between two steps of the slider
    panel = Controls(meshcat, steering=False)
    panel.show_gains(run)
    assert not panel.apply_gains(run)
    assert run.gain(find(run, "position_gain")) == 10.123
    meshcat.SetSliderValue("g_a (-)", 0.3)
    assert panel.apply_gains(run)
    assert run.gain(find(run, "gain")) == pytest.approx(0.3)
    assert run.gain(find(run, "position_gain")) == 10.123


def test_the_panel_steers_only_a_robot_that_follows_it(meshcat):
    Controls(meshcat, steering=False, pushes=False)
    names = set(meshcat.GetSliderNames()) | set(meshcat.GetButtonNames())
    assert names.isdisjoint({part.label for part in STEERING} | set(PUSHES))
    panel = Controls(meshcat, steering=True)
    assert panel.command() == pytest.approx([0.0, 0.0, 0.0])
    meshcat.SetSliderValue(STEERING[0].label, 0.4)
    meshcat.SetSliderValue(STEERING[2].label, -0.2)
    assert panel.command() == pytest.approx([0.4, 0.0, -0.2])
    assert panel.pushes() == []


def test_gamepad_forward_and_left_are_negative_axes():
    assert gamepad_command([0.05, -0.05, 0.1]) == pytest.approx([0.0, 0.0, 0.0])
    forward = gamepad_command([0.0, -1.0, 0.0, 0.0])
    assert forward == pytest.approx([STEERING[0].limit, 0.0, 0.0])
    left, turn = gamepad_command([-1.0, 0.0, 0.0])[1], gamepad_command([0.0, 0.0, -1.0])[2]
    assert left == pytest.approx(STEERING[1].limit) and turn == pytest.approx(STEERING[2].limit)
    assert gamepad_command([]) == pytest.approx([0.0, 0.0, 0.0])


def test_the_view_waits_until_somebody_looks(stand, run, meshcat):
    view = LiveView(stand, meshcat)
    assert view(run) == 0.0
    assert meshcat.HasPath("/world/lola/lola/torso")
    assert meshcat.HasPath("/world/markers/ground force/left")
    view.stopped = True
    assert view(run) is None


def test_the_robot_walks_as_the_panel_commands(stand, run, meshcat):
    view = LiveView(stand, meshcat)
    view(run)
    meshcat.SetSliderValue(STEERING[0].label, 0.25)
    view._act(run, view._controls)
    run.advance(0.06)
    footsteps = next_footsteps(stand, run.state("walking_pattern", "request"))
    ahead = sorted(place[0] for foot in "lr" for place in footsteps[foot])
    assert ahead == pytest.approx([0.2, 0.4, 0.6])


def test_a_run_that_was_changed_by_hand_says_so(stand, meshcat, make_result):
    view, result = LiveView(stand, meshcat), make_result(stand, steps=0)
    assert view.signed(result) is result
    view.interfered = True
    assert view.signed(result).scenario.description.endswith("(Changed by hand while it ran.)")


def test_nothing_is_planned_while_standing(stand):
    state = pack_request(standing_request(stand.pattern))
    assert next_footsteps(stand, state) == {"l": [], "r": []}


def test_a_push_moves_the_robot_and_ends(run):
    def velocities():
        return run.plant.GetVelocities(run.plant.GetMyContextFromRoot(run.context))

    before = velocities()
    push(run, np.array([0.0, 6.0]))
    run.advance(0.1)
    pushed = velocities()
    assert pushed[4] - before[4] > 0.01 > abs(pushed[3] - before[3])
    push(run, np.zeros(2))
    port = run.plant.get_applied_spatial_force_input_port()
    assert port.Eval(run.plant.GetMyContextFromRoot(run.context)) == []


def test_the_markers_show_the_present(run, stand):
    (frame,) = frames_of(signals_now(run), stand.ground)
    assert frame.forces[:, 2].sum() == pytest.approx(60 * 9.81, rel=0.02)
    assert frame.com[2] == pytest.approx(0.87, abs=0.02)
    assert frame.zmp[:2] == pytest.approx(frame.com[:2], abs=0.02) and frame.zmp[2] == 0.0


def test_who_attends_decides_how_far_it_goes(stand):
    steps, times = [0.01, 0.0, 0.02, None], []

    def attend(run):
        times.append(round(run.time, 3))
        return steps.pop(0)

    result = simulate(stand, attend=attend)
    assert times == [0.0, 0.01, 0.01, 0.03]
    assert not result.completed and result.fall_time is None


def test_only_this_machine_may_look(meshcat):
    assert meshcat.web_url().startswith("http://localhost:")


@pytest.mark.parametrize("sent", [1e300, -1e300, np.nan, np.inf])
def test_what_a_page_sends_stays_within_the_sliders(run, sent):
    page = Sent()
    panel = Controls(page, steering=True)
    panel.show_gains(run)
    page.sent = sent
    panel.apply_gains(run)
    for gain in run.gains():
        low, high, _ = gain.field.metadata["slider"]
        assert low <= run.gain(gain) <= high
    assert 0.0 <= panel.rate <= 2.0
    limits = [part.limit for part in STEERING]
    assert (np.abs(panel.command()) <= limits).all()
    page.pad.index, page.pad.axes = 0, [sent, sent, sent]
    assert (np.abs(panel.command()) <= limits).all()


class Sent:
    """A Meshcat whose page sends the same to every slider."""

    def __init__(self):
        self.sent, self.pad = 0.5, types.SimpleNamespace(index=None, axes=[])

    def __getattr__(self, name):
        return lambda *_: None

    def AddSlider(self, label, low, high, step, value, *_):
        return value

    def GetSliderValue(self, label):
        return self.sent

    def GetButtonClicks(self, name):
        return 0

    def GetGamepad(self):
        return self.pad
