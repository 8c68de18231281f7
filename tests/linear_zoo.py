"""Blocks and diagrams of all kinds that people may hand to `linearize`."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import HalfSpace, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.framework import Diagram, DiagramBuilder, EventStatus, LeafSystem, System
from pydrake.systems.primitives import MatrixGain

PERIOD = 1e-3


class Toy(LeafSystem):
    """x+ = next_state(x, u, t), y = output(x, u); what else happens is up to `events`.

    Args:
        next_state: the law.
        output: the law of the output.
        size: of the state.
        period, offset: of the update (s); no update without a period.
        events: declares further ones: called with the block.
        feed: whether u reaches y at once.
    """

    def __init__(
        self,
        next_state=lambda x, u, t: x + 0.1 * (u - x),
        output=lambda x, u: x,
        *,
        size=1,
        period=PERIOD,
        offset=0.0,
        events=lambda block: None,
        feed=False,
    ):
        super().__init__()
        self._next, self._output, self._feed = next_state, output, feed
        self._u = self.DeclareVectorInputPort("u", 1)
        state = self.DeclareDiscreteState(size)
        tickets = {self.discrete_state_ticket(state)} | ({self._u.ticket()} if feed else set())
        self.DeclareVectorOutputPort("y", 1, self._calc, prerequisites_of_calc=tickets)
        if period:
            self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self.update)
        events(self)

    def update(self, context, state):
        x = context.get_discrete_state_vector().value()
        state.set_value(0, self._next(x, self._u.Eval(context), context.get_time()))

    def add_one(self, context, state):
        """One more is what events that should not be there do."""
        target = state if hasattr(state, "set_value") else state.get_mutable_discrete_state()
        target.set_value(0, context.get_discrete_state_vector().value() + 1)
        return EventStatus.Succeeded()

    def _calc(self, context, output):
        x = context.get_discrete_state_vector().value()
        output.set_value(self._output(x, self._u.Eval(context) if self._feed else None)[:1])


class Counting(Toy):
    """Integrates in a Python attribute."""

    def __init__(self):
        self._sum = 0.0
        super().__init__(self._add)

    def _add(self, x, u, t):
        self._sum += u[0] + 1.0
        return x + self._sum


class LastInput(Toy):
    """Integrates in a Python attribute whenever time has gone on."""

    def __init__(self):
        self._time, self._sum = -1.0, 0.0
        super().__init__(self._add)

    def _add(self, x, u, t):
        if t > self._time:
            self._time, self._sum = t, self._sum + u[0]
        return x + self._sum


class TwoGroups(LeafSystem):
    """A state in two groups, one of which reads the other."""

    def __init__(self):
        super().__init__()
        self._u = self.DeclareVectorInputPort("u", 1)
        self.DeclareDiscreteState(2)
        second = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("y", second)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _update(self, context, state):
        first, second = (context.get_discrete_state(i).value() for i in range(2))
        state.set_value(0, [first[0] + PERIOD * first[1], np.sin(first[0]) + second[0]])
        state.set_value(1, 0.9 * second + first[:1] ** 2 + self._u.Eval(context))


class Sender(LeafSystem):
    """A state that goes out as an object."""

    def __init__(self):
        super().__init__()
        self._u = self.DeclareVectorInputPort("u", 1)
        self.DeclareDiscreteState(1)
        self.DeclareAbstractOutputPort("object", lambda: Value([0.0]), self._calc)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _calc(self, context, output):
        output.set_value([float(np.sin(context.get_discrete_state_vector()[0]))])

    def _update(self, context, state):
        state.set_value(
            0, 0.8 * context.get_discrete_state_vector().value() + self._u.Eval(context)
        )


class Receiver(LeafSystem):
    """A state that follows an object."""

    def __init__(self):
        super().__init__()
        self._object = self.DeclareAbstractInputPort("object", Value([0.0]))
        state = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("y", state)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _update(self, context, state):
        (received,) = self._object.Eval(context)
        state.set_value(0, 0.5 * context.get_discrete_state_vector().value() + received)


def chain(*blocks: System) -> Diagram:
    """Return blocks in a row: input u, output y."""
    builder = DiagramBuilder()
    for k, block in enumerate(blocks):
        builder.AddNamedSystem(f"block{k}", block)
    builder.ExportInput(blocks[0].get_input_port(0), "u")
    for first, second in zip(blocks, blocks[1:], strict=False):
        builder.Connect(first.get_output_port(0), second.get_input_port(0))
    builder.ExportOutput(blocks[-1].get_output_port(0), "y")
    return builder.Build()


def _rod(plant: MultibodyPlant, parent) -> None:
    """Hang a rod on a frame."""
    inertia = SpatialInertia(1.0, [0.0, 0.0, -0.5], UnitInertia(0.34, 0.34, 0.01))
    rod = plant.AddRigidBody("rod", inertia)
    plant.AddJoint(RevoluteJoint("hinge", parent, rod.body_frame(), [0.0, 1.0, 0.0], 0.1))


def pendulum(*, gains: bool = False) -> Diagram:
    """Return a pendulum with a torque at its hinge, or an implicit PD controller there."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", MultibodyPlant(PERIOD))
    plant.SetUseSampledOutputPorts(False)
    _rod(plant, plant.world_frame())
    motor = plant.AddJointActuator("motor", plant.GetJointByName("hinge"))
    if gains:
        motor.set_controller_gains(PdControllerGains(p=20.0, d=2.0))
    plant.Finalize()
    if gains:
        world = plant.GetModelInstanceByName("DefaultModelInstance")
        builder.ExportInput(plant.get_desired_state_input_port(world), "u")
    else:
        builder.ExportInput(plant.get_actuation_input_port(), "u")
    builder.ExportOutput(plant.get_state_output_port(), "y")
    return builder.Build()


def cart_pole() -> Diagram:
    """Return a pole on a cart, held upright by a gain on its state; u disturbs that gain."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", MultibodyPlant(PERIOD))
    plant.SetUseSampledOutputPorts(False)
    cart = plant.AddRigidBody("cart", SpatialInertia.SolidBoxWithMass(2.0, 0.2, 0.2, 0.1))
    rail = plant.AddJoint(
        PrismaticJoint("rail", plant.world_frame(), cart.body_frame(), [1.0, 0.0, 0.0])
    )
    _rod(plant, cart.body_frame())
    plant.AddJointActuator("motor", rail)
    plant.Finalize()
    gain = builder.AddNamedSystem("gain", MatrixGain(np.array([[-20.0, 60.0, -15.0, 20.0]])))
    builder.Connect(plant.get_state_output_port(), gain.get_input_port())
    builder.Connect(gain.get_output_port(), plant.get_actuation_input_port())
    builder.ExportOutput(plant.get_state_output_port(), "y")
    return builder.Build()


def ball(height: float) -> Diagram:
    """Return a ball of 0.1 m at a height of its centre over the ground (m)."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, PERIOD)
    plant.set_name("plant")
    plant.SetUseSampledOutputPorts(False)
    body = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(2.0, 0.1))
    friction = CoulombFriction(0.8, 0.8)
    for owner, shape in ((plant.world_body(), HalfSpace()), (body, Sphere(0.1))):
        plant.RegisterCollisionGeometry(owner, RigidTransform(), shape, "shape", friction)
    plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0.0, 0.0, height]))
    plant.Finalize()
    builder.ExportOutput(plant.get_state_output_port(), "y")
    return builder.Build()
