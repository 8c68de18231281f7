"""Small diagrams whose linear models are known, for the tests of the analyses."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Gain, LinearSystem

PERIOD = 1e-3


class Filter(LeafSystem):
    """x+ = x + gain (u - x), y = x, written in Python as the blocks are."""

    def __init__(self, gain: float = 0.1, period: float = PERIOD, size: int = 1):
        super().__init__()
        self._gain = gain
        self._input = self.DeclareVectorInputPort("u", size)
        state = self.DeclareDiscreteState(size)
        self.DeclareStateOutputPort("y", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, state):
        x = context.get_discrete_state_vector().value()
        state.set_value(0, x + self._gain * (self._input.Eval(context) - x))


class Square(LeafSystem):
    """y = u^2, without state."""

    def __init__(self):
        super().__init__()
        self._input = self.DeclareVectorInputPort("u", 1)
        self.DeclareVectorOutputPort(
            "y", 1, self._calc, prerequisites_of_calc={self._input.ticket()}
        )

    def _calc(self, context, output):
        output.set_value(self._input.Eval(context) ** 2)


class AbstractState(LeafSystem):
    """Cannot be linearised."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("u", 1)
        self.DeclareAbstractState(Value("secret"))
        self.DeclareDiscreteState(1)
        self.DeclareVectorOutputPort("y", 1, lambda context, output: None)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, lambda context, state: None)


class Failing(Filter):
    """Its law fails when it is evaluated."""

    def _update(self, context, state):
        raise SystemExit("condition 'x > 0' failed")


def loop(plant: LinearSystem, gain: float = 1.0):
    """Return a diagram: plant y -> gain -> negative feedback, all ports named."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", plant)
    controller = builder.AddNamedSystem("controller", Gain(-gain, plant.get_input_port().size()))
    builder.Connect(plant.get_output_port(), controller.get_input_port())
    builder.Connect(controller.get_output_port(), plant.get_input_port())
    diagram = builder.Build()
    diagram.set_name("loop")
    return diagram


def discrete(A, B, C, D=None) -> LinearSystem:
    """Return a discrete LinearSystem with the tests' period."""
    A, B, C = (np.atleast_2d(np.asarray(M, dtype=float)) for M in (A, B, C))
    D = np.zeros((len(C), B.shape[1])) if D is None else np.atleast_2d(D)
    return LinearSystem(A=A, B=B, C=C, D=D, time_period=PERIOD)
