"""Any diagram is linearised right to 1e-6 against its own tick, or refused with the reason."""

import numpy as np
import pytest
from linear_toys import AbstractState, Failing, Square, discrete, loop
from linear_zoo import (
    PERIOD,
    Counting,
    LastInput,
    Receiver,
    Sender,
    Toy,
    TwoGroups,
    ball,
    cart_pole,
    chain,
    pendulum,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.controllers import PidController
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    Adder,
    AffineSystem,
    DiscreteDerivative,
    DiscreteTimeDelay,
    Gain,
    Integrator,
    LogVectorOutput,
    Saturation,
    Sine,
    ZeroOrderHold,
)

import lola_drake as lola
from lola_drake.linear.coordinates import coordinates
from lola_drake.linear.errors import AnalysisError
from lola_drake.linear.isolated import discrete_state, set_discrete_state
from lola_drake.linear.wiring import Wiring


def swing(x, u, t):
    """One step of a pendulum in the coordinates angle and rate."""
    return x + PERIOD * np.array([x[1], -9.81 * np.sin(x[0]) - 0.3 * x[1] ** 3 + u[0]])


def with_source():
    """Return a filter behind the sum of its input and a sine."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source", Sine(1.0, 3.0, 0.2, 1))
    add = builder.AddNamedSystem("add", Adder(2, 1))
    toy = builder.AddNamedSystem("toy", Toy(lambda x, u, t: 0.9 * x + u**2))
    builder.ExportInput(add.get_input_port(0), "u")
    builder.Connect(source.get_output_port(0), add.get_input_port(1))
    builder.Connect(add.get_output_port(), toy.get_input_port(0))
    builder.ExportOutput(toy.get_output_port(0), "y")
    return builder.Build()


def logged():
    """Return a filter whose output is logged and published at every step."""
    builder = DiagramBuilder()
    publish = lambda block: block.DeclarePerStepPublishEvent(lambda context: None)  # noqa: E731
    toy = builder.AddNamedSystem("toy", Toy(events=publish))
    LogVectorOutput(toy.get_output_port(0), builder, 0.01)
    builder.ExportInput(toy.get_input_port(0), "u")
    builder.ExportOutput(toy.get_output_port(0), "y")
    return builder.Build()


RIGHT = {
    "linear block": lambda: chain(discrete([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 2]], [[3]])),
    "affine block": lambda: chain(
        AffineSystem(A=[[0.5]], B=[[2.0]], f0=[7.0], C=[[1.0]], D=[[0.0]], time_period=PERIOD)
    ),
    "static feedback": lambda: chain(loop_with_ports()),
    "filter chain": lambda: chain(Toy(), Toy(lambda x, u, t: 0.7 * x + 0.3 * u), Toy()),
    "square between": lambda: chain(Toy(), Square(), Toy()),
    "static block alone": lambda: chain(Square()),
    "gain and filter": lambda: chain(Gain(-3.0, 1), Toy()),
    "nested twice": lambda: chain(chain(chain(Toy()), Toy()), Square()),
    "delay line": lambda: chain(Toy(), DiscreteTimeDelay(PERIOD, 5, 1), Toy()),
    "zero-order hold": lambda: chain(ZeroOrderHold(PERIOD, 1), Toy()),
    "derivative": lambda: chain(Toy(), DiscreteDerivative(1, PERIOD)),
    "two groups of states": lambda: chain(TwoGroups(), Toy()),
    "an object between": lambda: chain(Toy(), Sender(), Receiver()),
    "pendulum by hand": lambda: chain(Toy(swing, size=2)),
    "direct feed-through": lambda: chain(Toy(output=lambda x, u: x * u + u**3, feed=True)),
    "inside a saturation": lambda: chain(Saturation([-9.0], [9.0]), Toy()),
    "outside a saturation": lambda: chain(Saturation([-0.1], [0.1]), Toy()),
    "time-varying": lambda: chain(Toy(lambda x, u, t: np.cos(20 * t + x) + u)),
    "source inside": with_source,
    "published and logged": logged,
    "one offset for all": lambda: chain(Toy(offset=4e-4), Toy(offset=4e-4)),
    "smooth but sharply curved": lambda: chain(Toy(lambda x, u, t: np.sqrt(1e-4 + (u - 0.3) ** 2))),
    "pendulum with torque": pendulum,
    "plant with PD gains": lambda: pendulum(gains=True),
    "cart-pole": cart_pole,
    "ball in the air": lambda: ball(0.5),
    "ball on the ground": lambda: ball(0.099),
}
"""Diagrams with an input u (or none) and an output y."""


def loop_with_ports():
    """Return a plant in static feedback as one more block."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", Toy(swing, lambda x, u: x[1:], size=2))
    add, gain = (builder.AddNamedSystem(*s) for s in (("add", Adder(2, 1)), ("gain", Gain(-4, 1))))
    builder.Connect(plant.get_output_port(0), gain.get_input_port())
    builder.Connect(gain.get_output_port(), add.get_input_port(0))
    builder.Connect(add.get_output_port(), plant.get_input_port(0))
    builder.ExportInput(add.get_input_port(1), "u")
    builder.ExportOutput(plant.get_output_port(0), "y")
    return builder.Build()


def somewhere(system):
    """Return a context off the beaten track: no state and no input is zero."""
    context = system.CreateDefaultContext()
    context.SetTime(0.0124 if "offset" not in system.get_name() else 0.0)
    state = discrete_state(context)
    moved = state + 0.1 * np.sin(1.0 + np.arange(state.size)) * (state.size < 13)
    set_discrete_state_of(system, context, moved)
    for i in range(system.num_input_ports()):
        size = system.get_input_port(i).size()
        system.get_input_port(i).FixValue(context, 0.3 + 0.1 * np.arange(size))
    return context


def set_discrete_state_of(system, context, state):
    if state.size:
        set_discrete_state(context, state)


def names(system):
    return (["u"] if system.num_input_ports() else []), ["y"]


def whole_tick(system, at):
    """Return a function from motions of states and inputs to the next states and the output."""
    wiring = Wiring(system)
    frame = coordinates(wiring, at, list(wiring.blocks))
    n, port = len(frame.names), system.get_output_port(0)
    resting = at.Clone()
    if n:
        resting.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(at))

    def tick(motion):
        context = at.Clone()
        frame.move(context, motion[:n])
        for i in range(system.num_input_ports()):
            value = system.get_input_port(i).Eval(at) + motion[n:]
            system.get_input_port(i).FixValue(context, value)
        output = port.Eval(context).copy()
        if not n:
            return output
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
        return np.concatenate([frame.difference(context, resting), output])

    return tick, frame.names


def derivative(function, size, step):
    """Return the Jacobian of a function at 0, by Richardson's central differences."""
    columns = []
    for direction in np.eye(size):
        coarse, fine = (
            (function(h * direction) - function(-h * direction)) / (2 * h)
            for h in (step, 0.5 * step)
        )
        columns.append((4 * fine - coarse) / 3)
    return np.array(columns).T


@pytest.mark.parametrize("name", RIGHT)
def test_a_model_is_the_diagrams_own_tick(name):
    system = RIGHT[name]()
    context = somewhere(system)
    model = lola.linearize(system, *names(system), context)
    tick, states = whole_tick(system, context)
    step = 1e-5 if "ground" in name else 2e-4  # contact curves strongly
    expected = derivative(tick, len(states) + model.ninputs, step)
    assert sorted(states) == sorted(model.state_labels)
    order = [states.index(label) for label in model.state_labels]
    columns = [*order, *range(len(states), expected.shape[1])]
    rows = [*order, *range(len(states), len(expected))]
    found = np.block([[model.A, model.B], [model.C, model.D]])
    expected = expected[np.ix_(rows, columns)]
    scale = np.maximum(1.0, np.abs(expected))
    np.testing.assert_allclose(found / scale, expected / scale, atol=1e-6)


def per_step(block):
    block.DeclarePerStepDiscreteUpdateEvent(block.add_one)


def unrestricted(period):
    return lambda block: block.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, block.add_one)


def another(period, offset=0.0):
    return lambda block: block.DeclarePeriodicDiscreteUpdateEvent(period, offset, block.add_one)


def plant(**kwargs):
    system = MultibodyPlant(**kwargs)
    system.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    system.Finalize()
    return system


def unconnected():
    builder = DiagramBuilder()
    first, second = (builder.AddNamedSystem(name, Toy()) for name in ("first", "second"))
    builder.ExportInput(first.get_input_port(0), "u")
    builder.ExportOutput(second.get_output_port(0), "y")
    return builder.Build()


def rounding(u):
    return 0.05 * np.round(u / 0.05)


ONLY = "more than its periodic discrete update changes its state"
TWICE = "comes out different the second time"
KINK = "is at a kink or quantised"
REFUSED = {
    "abstract state": (lambda: chain(Toy(), AbstractState()), "block1 .* has abstract state"),
    "continuous state": (lambda: chain(Toy(), Integrator(1)), "block1 .* has continuous state"),
    "PID controller": (lambda: one_pid(), "has continuous state"),
    "continuous plant": (lambda: plant(time_step=0.0), "build it with a time step"),
    "sampled ports": (lambda: plant(time_step=PERIOD), "use_sampled_output_ports=False"),
    "two periods": (lambda: chain(Toy(), Toy(period=2e-3)), "periods .* block0 1 ms, block1 2 ms"),
    "two offsets": (lambda: chain(Toy(), Toy(offset=5e-4)), "offsets .* block1 0.5 ms"),
    "two periods in a block": (lambda: chain(Toy(events=another(2e-3))), "no single periodic"),
    "two offsets in a block": (
        lambda: chain(Toy(events=another(1e-3, 5e-4))),
        "no single periodic",
    ),
    "no update": (lambda: chain(Toy(period=None)), "no single periodic"),
    "per-step update alone": (lambda: chain(Toy(period=None, events=per_step)), "no single"),
    "per-step update too": (lambda: chain(Toy(events=per_step)), f"block0 .*{ONLY}"),
    "unrestricted update too": (lambda: chain(Toy(events=unrestricted(PERIOD))), ONLY),
    "slow unrestricted update": (lambda: chain(Toy(events=unrestricted(0.2))), ONLY),
    "state in an attribute": (lambda: chain(Toy(), Counting()), f"block1 .*{TWICE}"),
    "attribute that follows time": (lambda: chain(LastInput()), TWICE),
    "random numbers": (
        lambda: chain(Toy(lambda x, u, t: u + np.random.default_rng().random(1))),
        TWICE,
    ),
    "kink": (lambda: chain(Toy(lambda x, u, t: np.abs(u - 0.3))), rf"block0\.u\.0 {KINK}"),
    "kink in the output": (
        lambda: chain(Toy(output=lambda x, u: np.maximum(u, 0.3), feed=True)),
        KINK,
    ),
    "kink in the state": (lambda: chain(Toy(lambda x, u, t: np.abs(x - X0) + u)), r"block0\.x0"),
    "saturation's corner": (lambda: chain(Saturation([-0.3], [0.3]), Toy()), KINK),
    "quantiser": (lambda: chain(Toy(lambda x, u, t: x + rounding(u + 0.01))), KINK),
    "quantiser that only falls": (
        lambda: chain(Toy(lambda x, u, t: x + rounding(np.minimum(u + 0.01, 0.32)))),
        KINK,
    ),
    "quantiser's edge": (lambda: chain(Toy(lambda x, u, t: rounding(u + 0.025))), KINK),
    "comparator's edge": (lambda: chain(Toy(lambda x, u, t: np.sign(u - 0.3))), KINK),
    "unconnected port": (unconnected, "second .*not connected"),
    "not a number": (lambda: chain(Toy(lambda x, u, t: u * np.nan)), "not finite"),
    "law that fails": (lambda: chain(Toy(), Failing()), "block1 cannot be evaluated"),
}
X0 = 0.1 * np.sin(1.0)


def one_pid():
    builder = DiagramBuilder()
    pid = builder.AddNamedSystem("pid", PidController([1.0], [0.1], [0.01]))
    builder.ExportInput(pid.get_input_port(0), "u")
    builder.ExportOutput(pid.get_output_port(0), "y")
    return builder.Build()


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_model_is_refused_with_the_reason(name):
    make, message = REFUSED[name]
    system = make()
    context = somewhere(system) if system.HasOutputPort("y") else system.CreateDefaultContext()
    wanted = names(system) if system.HasOutputPort("y") else ([], [])
    with pytest.raises(AnalysisError, match=message) as error:
        lola.linearize(system, *wanted, context)
    assert "\n" not in str(error.value)


def test_a_kink_can_be_let_pass_and_is_named():
    system = chain(Toy(lambda x, u, t: np.abs(u - 0.3)))
    model = lola.linearize(system, "u", "y", somewhere(system), kinks=True)
    np.testing.assert_allclose(model.B, 0.0, atol=1e-9)
    assert model.operating_point.kinks == ("block0.u.0",)


@pytest.mark.parametrize("hold", [["block3"], "block3", ["toy"]])
def test_a_block_to_hold_that_does_not_exist_is_one_clear_error(hold):
    system = chain(Toy(), Toy())
    with pytest.raises(AnalysisError, match="no block '(block3|toy)' to hold"):
        lola.linearize(system, "u", "y", somewhere(system), hold=hold)


@pytest.mark.parametrize("hold", [["block1"], "block1"])
def test_what_is_held_stays(hold):
    system = chain(Toy(), Toy(), Toy())
    model = lola.linearize(system, "u", "y", somewhere(system), hold=hold)
    assert model.state_labels == ["block0/x0", "block2/x0"]
    assert model.operating_point.held == ("block1",)


def test_a_closed_toy_loop_is_right_too():
    system = loop(discrete(0.9, 0.1, 1.0), gain=2.0)
    model = lola.linearize(system, "controller.y0", [], system.CreateDefaultContext())
    np.testing.assert_allclose(model.A, [[0.7]], atol=1e-9)
