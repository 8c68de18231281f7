"""Linear models against what is known and against the whole diagram's own differences."""

import control
import numpy as np
import pytest
from linear_toys import PERIOD, Filter, Square, discrete, loop
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import AffineSystem, Linearize

import lola_drake as lola
from lola_drake.block_system import system_of
from lola_drake.blocks.hybrid_force_control import HybridForceControl, HybridForceControlParams
from lola_drake.blocks.imu_stabilizer import ImuStabilizerParams
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import discrete_state, own_context, set_discrete_state
from lola_drake.linear.linear_blocks import linear_blocks
from lola_drake.robot import PADS
from lola_drake.signals import DESIRED_WRENCH, GAIT_PHASE, MEASURED_WRENCH
from lola_drake.theory.contact_model import contact_matrix
from lola_drake.theory.foot_wrench import FootSensor

A = [[0.9, 0.1], [-0.2, 0.8]]


def chain(*blocks):
    """Return blocks in a row as a diagram with the first one's input."""
    builder = DiagramBuilder()
    for k, block in enumerate(blocks):
        builder.AddNamedSystem(f"block{k}", block)
    builder.ExportInput(blocks[0].get_input_port(0), "u")
    for first, second in zip(blocks, blocks[1:], strict=False):
        builder.Connect(first.get_output_port(0), second.get_input_port(0))
    return builder.Build()


def fixed_context(diagram, value=0.0):
    context = diagram.CreateDefaultContext()
    diagram.get_input_port(0).FixValue(context, [value])
    return context


def test_a_linear_block_comes_out_as_it_is():
    block = discrete(A, [[0], [1]], [[1, 0], [0, 1]], [[0], [2]])
    block.set_name("plant")
    model = lola.linearize(block, "u0", "y0", fixed_context(block))
    np.testing.assert_allclose(model.A, A, atol=1e-10)
    np.testing.assert_allclose(model.B, [[0], [1]], atol=1e-10)
    np.testing.assert_allclose(model.D, [[0], [2]], atol=1e-10)
    assert model.dt == PERIOD
    assert model.input_labels == ["u0/0"]


def test_a_loop_is_closed_and_opened():
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    context = diagram.CreateDefaultContext()
    closed = lola.linearize(diagram, "controller.y0", "plant.y0", context)
    np.testing.assert_allclose(closed.A, [[0.7]], atol=1e-10)
    opened = lola.linearize(diagram, "plant.y0", "plant.y0", context, opened="plant.y0")
    np.testing.assert_allclose([opened.A[0, 0], opened.B[0, 0] * opened.C[0, 0]], [0.9, -0.2])
    loop_transfer = lola.open_loop(diagram, "plant.y0", context)
    np.testing.assert_allclose(loop_transfer.B @ loop_transfer.C, [[0.2]])


def test_what_readers_see_holds_what_was_added():
    diagram = loop(discrete(0.9, 0.1, 1.0))
    model = lola.linearize(diagram, "plant.y0", "plant.y0", diagram.CreateDefaultContext())
    np.testing.assert_allclose(model.D, [[1.0]])


def test_blocks_are_linearised_where_they_are():
    diagram = chain(Filter(0.1), Square(), Filter(0.5))
    context = fixed_context(diagram)
    set_discrete_state(own_context(diagram.GetSubsystemByName("block0"), context), np.array([3.0]))
    model = lola.linearize(diagram, "u", "block2.y", context)
    np.testing.assert_allclose(model.A, [[0.9, 0.0], [0.5 * 6.0, 0.5]], atol=1e-9)
    assert model.state_labels == ["block0/x0", "block2/x0"]
    assert model.operating_point.drift["block0/x0"] == pytest.approx(-0.3)


def test_states_can_be_outputs():
    diagram = chain(Filter(0.1), Filter(0.5))
    model = lola.linearize(diagram, "u", "block1.x0", fixed_context(diagram))
    assert isinstance(model, control.StateSpace)
    np.testing.assert_allclose(model.C, [[0.0, 1.0]])


def test_minimal_cuts_what_is_not_observed_or_excited_and_says_so():
    diagram = chain(Filter(0.1), Filter(0.2), Filter(0.3))
    context = fixed_context(diagram)
    model = lola.linearize(diagram, "block0.y", "block1.y", context, minimal=True)
    assert model.state_labels == ["block1/x0"]
    assert model.operating_point.cut == ("block0/x0", "block2/x0")


def test_a_context_around_the_system_will_do(standing):
    stabilizer = standing.diagram.GetSubsystemByName("controller").GetSubsystemByName(
        "imu_stabilizer"
    )
    model = lola.linearize(
        stabilizer, "torso_orientation.phi", "modified_wrench.T", standing.context
    )
    np.testing.assert_allclose(model.D[:2], -ImuStabilizerParams().stiffness * np.eye(2), rtol=1e-6)


def test_linearising_changes_nothing(standing):
    before = discrete_state(standing.context)
    lola.linearize(standing.diagram, "desired_wrench_l", "contact_wrench_l", standing.context)
    np.testing.assert_array_equal(discrete_state(standing.context), before)


def test_noise_drops_out(standing):
    noisy = lola.build_simulation(lola.load_scenario("stand"))
    context = noisy.CreateDefaultContext()
    context.SetDiscreteState(standing.context.get_discrete_state())
    context.SetTime(standing.context.get_time())
    quiet, loud = (
        lola.linearize(diagram, "desired_wrench_l", "contact_wrench_l", where)
        for diagram, where in ((standing.diagram, standing.context), (noisy, context))
    )
    np.testing.assert_allclose(loud.A[60:, 60:], quiet.A[60:, 60:], atol=1e-6)


STEPS = {"plant": 1e-6, "controller.joint_servos": 3e-5}
"""Large enough for the contact solver to notice; the other blocks need no care."""


def test_the_blocks_together_are_the_whole_diagram(standing):
    """Every sixth column of A against central differences of the whole diagram's tick."""
    blocks = linear_blocks(standing.diagram, standing.context, [], [])
    A = blocks.interconnect([], []).A
    scale = np.maximum(np.abs(A).max(axis=1), 1.0)
    tangents = blocks.coordinates.tangents
    paths = [path for path, tangent in tangents.items() for _ in range(tangent.dimension)]
    for k in range(0, len(A), 6):
        motion = STEPS.get(paths[k], 1e-5) * blocks.coordinates.scales[k] * np.eye(len(A))[k]
        ahead, behind = (whole_tick(standing, blocks, sign * motion) for sign in (1, -1))
        found = (ahead - behind) / (2 * motion[k])
        np.testing.assert_allclose(
            found / scale, A[:, k] / scale, atol=2e-5, err_msg=blocks.state_names[k]
        )


def whole_tick(situation, blocks, motion):
    """Return where the whole diagram goes in a tick from a moved state, as a motion itself."""
    context = situation.context.Clone()
    blocks.coordinates.move(context, motion)
    context.SetDiscreteState(situation.diagram.EvalUniquePeriodicDiscreteUpdate(context))
    return blocks.coordinates.difference(context, situation.context)


def ideal_force_loop(delta: float):
    """Return force control of a foot on its own U, with an ideal servo and no delay, at rest.

    The foot is where it is told to be, and its sensor sits in the TCP.
    """
    U = contact_matrix(PADS, 1.2e5 / sum(pad.area for pad in PADS))
    sensor = FootSensor(p_TcpSensor=(0.0, 0.0, 0.0), weight=0.0, p_TcpFoot=(0.0, 0.0, 0.0))
    params = HybridForceControlParams(time_constant=delta)
    load = np.array([0.0, 0.0, 300.0])
    builder = DiagramBuilder()
    law = HybridForceControl(
        params,
        "l",
        inverse_contact_matrix=np.linalg.inv(U),
        compliance=np.zeros((3, 3)),
        relaxation=0.014,
        sensor=sensor,
    )
    block = builder.AddNamedSystem("control", system_of(law))
    to_sensor = np.zeros((MEASURED_WRENCH.size, 3))
    to_sensor[MEASURED_WRENCH.slice("T_l")][:2] = np.eye(3)[:2]
    to_sensor[MEASURED_WRENCH.slice("F_l")][2] = np.eye(3)[2]
    ground = builder.AddNamedSystem("ground", AffineSystem(D=to_sensor @ U, y0=to_sensor @ load))
    builder.Connect(block.GetOutputPort("task_modification"), ground.get_input_port())
    builder.Connect(ground.get_output_port(), block.GetInputPort("measured_wrench"))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inside = block.GetMyMutableContextFromRoot(context)
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        if port.get_name() != "measured_wrench":
            port.FixValue(inside, np.zeros(port.size()))
    phase = np.zeros(GAIT_PHASE.size)
    phase[GAIT_PHASE.slice("blend")] = phase[GAIT_PHASE.slice("support")] = 1.0
    desired = np.zeros(DESIRED_WRENCH.size)
    desired[DESIRED_WRENCH.slice("wrench_l")] = load
    block.GetInputPort("gait_phase").FixValue(inside, phase)
    block.GetInputPort("desired_wrench").FixValue(inside, desired)
    return diagram, context


@pytest.mark.parametrize("delta", [0.005, 0.02, 0.027])
def test_the_poles_of_the_ideal_force_loop(delta):
    """The error decays as in the paper's error dynamics: exp(-dt/delta)."""
    diagram, context = ideal_force_loop(delta)
    model = lola.linearize(
        diagram, "desired_wrench_l", "contact_wrench", context, equilibrium=1e-12
    )
    z = np.sort(np.linalg.eigvals(model.A))
    # That the foot has touched the ground is a state, too, and does not move.
    np.testing.assert_allclose(z, [0.0, *np.full(3, np.exp(-PERIOD / delta))], atol=1e-6)
    held = PERIOD / (1 - np.exp(-PERIOD / delta))
    gain = np.hstack([np.eye(3), held * np.eye(3)])  # of the desired wrench and of its rate
    np.testing.assert_allclose(control.dcgain(model), gain, atol=1e-9)


@pytest.mark.parametrize("name", ["imu_stabilizer", "com_dynamics_l"])
def test_drakes_own_linearize_takes_an_algebraic_block(on_left, name):
    block = on_left.diagram.GetSubsystemByName("controller").GetSubsystemByName(name)
    context = block.CreateDefaultContext()
    inside = block.GetMyContextFromRoot(on_left.context)
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        port.FixValue(context, port.Eval(inside))
    signal = {"imu_stabilizer": "torso_orientation", "com_dynamics_l": "desired_wrench"}[name]
    drakes = Linearize(
        block,
        context,
        block.GetInputPort(signal).get_index(),
        block.get_output_port(0).get_index(),
        equilibrium_check_tolerance=1e3,
    )
    ours = lola.linearize(block, signal, block.get_output_port(0).get_name(), context)
    for found, expected in ((ours.A, drakes.A()), (ours.B, drakes.B()), (ours.D, drakes.D())):
        scale = np.abs(expected).max(initial=1.0)
        np.testing.assert_allclose(found / scale, expected / scale, atol=1e-8)


def test_the_full_loop_has_hundreds_of_states(standing):
    model = lola.linearize(standing.diagram, [], [], standing.context)
    assert model.nstates > 190
    assert model.operating_point.held == ("contact_switches", "controller.walking_pattern")


def test_a_block_that_switches_is_let_go_where_its_own_signal_is_read(standing):
    for output, held in (("contact_wrench_l.wrench.F_z", True), ("ground_force.F_l.z", False)):
        desired = "desired_wrench.wrench_l.F_z"
        model = lola.linearize(standing.diagram, desired, output, standing.context)
        assert ("contact_switches" in model.operating_point.held) is held


def test_a_system_in_which_nothing_moves_has_no_states():
    square = Square()
    model = lola.linearize(square, [], [], square.CreateDefaultContext())
    assert (model.nstates, model.ninputs, model.noutputs) == (0, 0, 0)


def test_a_plant_with_sampled_ports_is_one_clear_error():
    plant = MultibodyPlant(1e-3)
    plant.Finalize()
    with pytest.raises(AnalysisError, match="use_sampled_output_ports=False"):
        lola.linearize(plant, [], [], plant.CreateDefaultContext())


def test_a_context_of_another_diagram_is_one_clear_error(standing):
    other = chain(Filter())
    with pytest.raises(AnalysisError, match="not a context of this system"):
        lola.linearize(other, "u", [], standing.context)
    twin = lola.build_simulation(lola.load_scenario("stand"))
    with pytest.raises(AnalysisError, match="not a context of this system"):
        lola.linearize(twin, [], [], standing.context)


def test_an_operating_point_that_is_not_in_equilibrium_is_one_clear_error():
    diagram = chain(Filter(0.1))
    with pytest.raises(AnalysisError, match="not an equilibrium: block0/x0 drifts by 2.0e-01"):
        lola.linearize(diagram, "u", [], fixed_context(diagram, 2.0), equilibrium=1e-6)


@pytest.mark.parametrize(
    ("inputs", "outputs", "message"),
    [
        ("nonsense", [], "no signal 'nonsense'"),
        ([], "nonsense", "no signal 'nonsense'"),
        ("contact", "gait_phase", "gait_phase/support/l does not move"),
        ("planned_motion", [], "nothing that moves reads planned_motion/com/x"),
    ],
)
def test_a_signal_that_is_unknown_or_still_is_one_clear_error(standing, inputs, outputs, message):
    with pytest.raises(AnalysisError, match=message):
        lola.linearize(standing.diagram, inputs, outputs, standing.context)


@pytest.mark.filterwarnings("ignore:Badly conditioned")
def test_a_minimal_model_is_python_controls_and_the_transfer_function():
    """A filter beside the path, and one that nothing reads; what is left is the textbook's."""
    diagram = chain(Filter(0.1), Filter(0.2), Filter(0.3))
    whole = lola.linearize(diagram, "u", "block1.y", fixed_context(diagram))
    model = lola.linearize(diagram, "u", "block1.y", fixed_context(diagram), minimal=True)
    z = np.exp(1j * np.linspace(0.01, 3.1, 20))
    textbook = 0.1 / (z - 0.9) * 0.2 / (z - 0.8)
    theirs = control.minreal(control.tf(whole), verbose=False)
    assert (whole.nstates, model.nstates, len(theirs.poles())) == (3, 2, 2)
    np.testing.assert_allclose(model(z), textbook, rtol=1e-8)
    np.testing.assert_allclose(theirs(z), textbook, rtol=1e-5)


def test_labels_have_units_and_are_names(standing):
    names = ("desired_wrench.wrench_l.F_z", "torso_orientation.phi.x")
    model = lola.linearize(standing.diagram, names[0], names[1], standing.context, minimal=True)
    assert model.input_labels == ["desired_wrench/wrench_l/F_z (N)"]
    assert model.output_labels == ["torso_orientation/phi/x (rad)"]
    again = lola.linearize(
        standing.diagram, model.input_labels, model.output_labels, standing.context, minimal=True
    )
    np.testing.assert_array_equal(again.B, model.B)


def test_a_drift_counts_relative_to_what_is_a_lot(standing):
    """5 N are a twentieth of a lot, 5 rad would be fifty times more than a lot."""
    context = standing.context.Clone()
    sensor = standing.diagram.GetSubsystemByName("foot_force_sensor")
    own = own_context(sensor, context)
    set_discrete_state(own, discrete_state(own) + 5.0)
    blocks = linear_blocks(standing.diagram, context, [], [])
    at = [i for i, n in enumerate(blocks.state_names) if n.startswith("foot_force_sensor/F_l")]
    np.testing.assert_allclose(blocks.relative_drift[at], blocks.drift[at] / 100.0)
    assert np.abs(blocks.drift[at]).min() > 0.01


@pytest.mark.parametrize("none", [[], (), {}])
def test_a_model_that_python_control_does_not_have_is_said(none):
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    context = diagram.CreateDefaultContext()
    for outputs in [], "plant.y0", ["plant.y0", "controller.y0"]:
        with pytest.raises(AnalysisError, match="^inputs: .* it must be at least one signal where"):
            lola.linearize(diagram, none, outputs, context)
    with pytest.raises(AnalysisError, match="^at: .* it must be at least one signal$"):
        lola.open_loop(diagram, none, context)
    block = discrete(A, [[0], [1]], [[1, 0], [0, 1]], [[0], [2]])
    with pytest.raises(AnalysisError, match="^inputs: .* it must be at least one signal where"):
        lola.linearize(block, none, "y0.1", fixed_context(block))
    unread = lola.linearize(diagram, "plant.y0", none, context)
    assert (unread.ninputs, unread.noutputs) == (1, 0)
    for outputs in [], ["y0"]:
        alone = lola.linearize(block, none, outputs, fixed_context(block))
        np.testing.assert_allclose(alone.A, A, atol=1e-10)


@pytest.mark.parametrize("argument", ["inputs", "outputs", "opened", "hold"])
@pytest.mark.parametrize("wrong", [None, 5, [5], [None], b"y0", [["y0"]]])
def test_what_is_no_name_is_said(argument, wrong):
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    given = {"inputs": "plant.y0", "outputs": "plant.y0", argument: wrong}
    with pytest.raises(AnalysisError, match=f"^{argument}: .* must be a name, or a list of names$"):
        lola.linearize(diagram, at=diagram.CreateDefaultContext(), **given)


def test_one_name_is_no_list_of_letters():
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    held = lola.linearize(diagram, [], [], diagram.CreateDefaultContext(), hold="plant")
    assert held.operating_point.held == ("plant",)


def test_a_signal_counts_once():
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    with pytest.raises(AnalysisError, match="^inputs: plant/y0/0 is named more than once$"):
        lola.open_loop(diagram, ["plant.y0"] * 2, diagram.CreateDefaultContext())
    block = discrete(A, [[0], [1]], [[1, 0], [0, 1]], [[0], [2]])
    with pytest.raises(AnalysisError, match="^outputs: y0/1 is named more than once$"):
        lola.linearize(block, "u0", ["y0", "y0.1"], fixed_context(block))


def test_what_is_no_system_and_no_context_is_said():
    diagram = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    with pytest.raises(AnalysisError, match="^system: 'stand' is not allowed"):
        lola.linearize("stand", "y0", "y0", None)
    with pytest.raises(AnalysisError, match="^not a context of this system"):
        lola.linearize(diagram, "plant.y0", "plant.y0", None)


@pytest.mark.parametrize("model", [None, control.ss(-1, 1, 1, 0), control.tf([1], [1, 2], 0.1)])
def test_poles_and_responses_are_those_of_a_discrete_model(model):
    for function, what in (lola.poles, "poles"), (lola.frequency_data, "frequency data"):
        with pytest.raises(AnalysisError, match=f"^{what} are those of a discrete-time"):
            function(model)
