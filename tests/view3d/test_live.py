"""Taking part in a running simulation: gains, steering, pushes."""

import socket
import types
from urllib.parse import urlsplit

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from lola_drake.blocks.walking_pattern import pack_request, standing_request
from lola_drake.errors import OutputError
from lola_drake.scenario import load_scenario, override
from lola_drake.simulation import build_simulation, simulate
from lola_drake.typed_yaml import leaves, plain
from lola_drake.view3d.controls import PUSHES, STEERING, Controls, gamepad_command
from lola_drake.view3d.frames import frames_of
from lola_drake.view3d.gains import GAINS, gains_of, get_gain, set_gain
from lola_drake.view3d.live import LiveView, next_footsteps, push, signals_now
from lola_drake.view3d.scene import PRIVATE, address, open_meshcat


@pytest.fixture(scope="module")
def stand():
    return load_scenario("stand")


@pytest.fixture(scope="module")
def diagram(stand):
    return build_simulation(stand)


@pytest.fixture
def simulator(diagram):
    """Return a simulation that has stood for a twentieth of a second."""
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.05)
    return simulator


@pytest.fixture(scope="module")
def meshcat():
    return open_meshcat()


def find(label_start):
    return next(gain for gain in GAINS if gain.label.startswith(label_start))


def test_gains_are_those_of_the_scenario(diagram, stand):
    context = diagram.CreateDefaultContext()
    values = leaves(plain(stand))
    for gain in GAINS:
        assert get_gain(diagram, context, gain) == values[gain.key], gain.key
        assert gain.low <= values[gain.key] <= gain.high


def test_the_reference_variant_runs_without_com_dynamics(stand):
    diagram = build_simulation(override(stand, {"variant": "ref"}))
    assert get_gain(diagram, diagram.CreateDefaultContext(), find("g_a")) == 0.0


def test_the_original_variant_has_no_gains_of_com_dynamics(stand):
    diagram = build_simulation(override(stand, {"variant": "original"}))
    context = diagram.CreateDefaultContext()
    gains = {gain.label: get_gain(diagram, context, gain) for gain in gains_of(diagram)}
    assert gains["δ (s)"] == stand.control.force.time_constant and "g_a (-)" not in gains


@pytest.mark.parametrize(
    ("gain", "signal"),
    [("δ", "task_command_l"), ("P (", "modified_wrench"), ("D", "joint_command")],
)
def test_a_gain_acts_in_the_context_without_a_rebuild(diagram, simulator, gain, signal):
    context = simulator.get_mutable_context()
    controller = diagram.GetSubsystemByName("controller")
    inside = controller.GetMyContextFromRoot(context)

    def output():
        return controller.GetOutputPort(signal).Eval(inside).copy()

    before, changed = output(), find(gain)
    value = get_gain(diagram, context, changed)
    set_gain(diagram, context, changed, 2 * value)
    assert np.abs(output() - before).max() > 1e-6
    assert get_gain(diagram, context, changed) == 2 * value
    set_gain(diagram, context, changed, value)
    assert output() == pytest.approx(before, abs=1e-12)


def test_twice_the_time_constant_halves_the_answer_to_a_force_error(diagram, simulator):
    context = simulator.get_mutable_context()
    controller = diagram.GetSubsystemByName("controller")
    inside = controller.GetMyContextFromRoot(context)

    def rate_of_height():
        return controller.GetOutputPort("task_command_l").Eval(inside)[6 + 2]

    rates = []
    for factor in (1.0, 2.0, 1e9):
        set_gain(diagram, context, find("δ"), 0.02 * factor)
        rates.append(rate_of_height())
    fast, slow, none = rates
    # Half of it but for what the period adds: the rate is held.
    expected = (1 - np.exp(-0.025)) / (1 - np.exp(-0.05))
    assert (slow - none) / (fast - none) == pytest.approx(expected, rel=1e-6)


def test_only_a_slider_that_was_moved_changes_its_gain(diagram, simulator, meshcat):
    context = simulator.get_mutable_context()
    set_gain(diagram, context, find("K_x"), 10.123)  # between two steps of the slider
    panel = Controls(meshcat, steering=False)
    panel.show_gains(diagram, context)
    assert not panel.apply_gains(diagram, context)
    assert get_gain(diagram, context, find("K_x")) == 10.123
    meshcat.SetSliderValue(find("g_a").label, 0.3)
    assert panel.apply_gains(diagram, context)
    assert get_gain(diagram, context, find("g_a")) == pytest.approx(0.3)
    assert get_gain(diagram, context, find("K_x")) == 10.123


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


def test_the_view_waits_until_somebody_looks(stand, diagram, simulator, meshcat):
    view = LiveView(stand, meshcat)
    context = simulator.get_mutable_context()
    assert view(diagram, context) == 0.0
    assert meshcat.HasPath("/world/lola/lola/torso")
    assert meshcat.HasPath("/world/markers/ground force/left")
    view.stopped = True
    assert view(diagram, context) is None


def test_the_robot_walks_as_the_panel_commands(stand, diagram, simulator, meshcat):
    view = LiveView(stand, meshcat)
    context = simulator.get_mutable_context()
    view(diagram, context)
    meshcat.SetSliderValue(STEERING[0].label, 0.25)
    view._act(diagram, context)
    simulator.AdvanceTo(0.06)
    pattern = diagram.GetSubsystemByName("controller").GetSubsystemByName("walking_pattern")
    request = pattern.packed_request(pattern.GetMyContextFromRoot(context))
    footsteps = next_footsteps(stand, request)
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


def test_a_push_moves_the_robot_and_ends(diagram, simulator):
    context = simulator.get_mutable_context()
    plant = diagram.GetSubsystemByName("plant")
    velocities = plant.GetVelocities(plant.GetMyContextFromRoot(context))
    push(diagram, context, np.array([0.0, 6.0]))
    simulator.AdvanceTo(0.1)
    pushed = plant.GetVelocities(plant.GetMyContextFromRoot(context))
    assert pushed[4] - velocities[4] > 0.01 > abs(pushed[3] - velocities[3])
    push(diagram, context, np.zeros(2))
    port = plant.get_applied_spatial_force_input_port()
    assert port.Eval(plant.GetMyContextFromRoot(context)) == []


def test_the_signs_show_the_present_moment(diagram, simulator, stand):
    (frame,) = frames_of(signals_now(diagram, simulator.get_context()), stand.ground)
    assert frame.forces[:, 2].sum() == pytest.approx(60 * 9.81, rel=0.02)
    assert frame.com[2] == pytest.approx(0.87, abs=0.02)
    assert frame.zmp[:2] == pytest.approx(frame.com[:2], abs=0.02) and frame.zmp[2] == 0.0


def test_who_attends_decides_how_far_it_goes(stand):
    steps, times = [0.01, 0.0, 0.02, None], []

    def attend(diagram, context):
        times.append(round(context.get_time(), 3))
        return steps.pop(0)

    result = simulate(stand, attend=attend)
    assert times == [0.0, 0.01, 0.01, 0.03]
    assert not result.completed and result.fall_time is None


def test_only_this_machine_may_look(meshcat):
    assert meshcat.web_url().startswith("http://localhost:")


def test_a_private_page_is_found_by_nobody_who_is_not_told():
    page = open_meshcat(host=PRIVATE, live=True)
    place = urlsplit(page.web_url())
    assert place.hostname.startswith("127.") and place.hostname != address(PRIVATE)
    socket.create_connection((place.hostname, place.port)).close()
    # A page of another origin can guess that it is on this machine, and the port.
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", place.port))


def test_a_host_that_is_not_here_is_one_line():
    with pytest.raises(OutputError, match="no page can be shown at '8.8.8.8'"):
        open_meshcat(host="8.8.8.8", live=True)


@pytest.mark.parametrize("sent", [1e300, -1e300, np.nan, np.inf])
def test_what_a_page_sends_stays_within_the_sliders(diagram, simulator, sent):
    page = Sent()
    panel = Controls(page, steering=True)
    context = simulator.get_mutable_context()
    panel.show_gains(diagram, context)
    page.sent = sent
    panel.apply_gains(diagram, context)
    for gain in GAINS:
        assert gain.low <= get_gain(diagram, context, gain) <= gain.high
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
