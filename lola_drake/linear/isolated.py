"""The blocks of a system cut apart: each with its inputs fixed, in a copy of a context."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.systems.framework import Context, InputPort, OutputPort, System

from lola_drake.linear.errors import drake_errors
from lola_drake.linear.signal_names import is_vector, is_wrench_list
from lola_drake.linear.wiring import Source, Target, Wiring


@dataclass(frozen=True)
class Instance:
    """A block and its context.

    Attributes:
        root: the context that has the time of both; it must stay alive with them.
        owner: so must this.
    """

    system: System
    context: Context
    root: Context
    owner: object = None


@dataclass(frozen=True)
class IsolatedBlocks:
    """Every block of a system with its inputs fixed to what they are in a context.

    Attributes:
        wiring: the blocks and their connections.
        instances: the blocks with their contexts.
        inputs: the fixed values.
        time: of the contexts (s).
    """

    wiring: Wiring
    instances: dict[str, Instance]
    inputs: dict[Target, np.ndarray]
    time: float

    def with_blocks(self, changed: System, paths: Iterable[str]) -> "IsolatedBlocks":
        """Return the same, with some blocks as they are in a system with other parameters.

        They get the present inputs and states. A delay line that is longer or shorter there is
        filled with what it holds, which is right in an equilibrium.
        """
        blocks, instances = Wiring(changed).blocks, dict(self.instances)
        for path in paths:
            context = blocks[path].CreateDefaultContext()
            context.SetTime(self.time)
            size = discrete_state(context).size
            state = discrete_state(self.instances[path].context)
            set_discrete_state(context, np.resize(state, size))
            instances[path] = Instance(blocks[path], context, context, changed)
            for target, value in self.inputs.items():
                if target.block == path:
                    fix_port(blocks[path].get_input_port(target.port), context, value)
        return replace(self, instances=instances)

    def timing(self, path: str) -> tuple[float, float] | None:
        """Return period and offset of a block's discrete update (s), None if it has none."""
        timing = self.instances[path].system.GetUniquePeriodicDiscreteUpdateAttribute()
        return (timing.period_sec(), timing.offset_sec()) if timing else None


def isolate(wiring: Wiring, context: Context, added: Iterable[Source] = ()) -> IsolatedBlocks:
    """Return the blocks cut apart in a copy of a context.

    The copy's time is the context's, so that noise and plans are what they are in that tick.

    Args:
        wiring: of the system.
        context: of the system or of a diagram around it; it stays as it is.
        added: signals to which something will be added; where nothing feeds them they are zero.
    """
    added = set(added)
    blocks = wiring.blocks
    with drake_errors("not a context of this system"):
        root = context.Clone()
        originals = {path: own_context(block, context) for path, block in blocks.items()}
        copies = {path: own_context(block, root) for path, block in blocks.items()}
    inputs = {}
    for path, block in blocks.items():
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            if not is_vector(port):
                continue
            if port.HasValue(originals[path]):
                with drake_errors(f"{path}.{port.get_name()} cannot be evaluated"):
                    inputs[Target(path, i)] = read_port(port, originals[path])
            elif wiring.feeds[Target(path, i)] in added:
                inputs[Target(path, i)] = np.zeros(port.size())
    for target, value in inputs.items():
        port = blocks[target.block].get_input_port(target.port)
        fix_port(port, copies[target.block], value)
    instances = {path: Instance(block, copies[path], root) for path, block in blocks.items()}
    return IsolatedBlocks(wiring, instances, inputs, context.get_time())


def own_context(block: System, root: Context) -> Context:
    """Return a block's part of a context: the context itself, or a part if it is a diagram's."""
    try:
        block.ValidateContext(root)
    except RuntimeError:
        return block.GetMyMutableContextFromRoot(root)
    return root


def discrete_state(context: Context) -> np.ndarray:
    """Return all groups of a context's discrete state as one vector."""
    return join_groups(context.get_discrete_state())


def join_groups(values) -> np.ndarray:
    """Return all groups of Drake's DiscreteValues as one vector."""
    groups = [values.get_vector(i).CopyToVector() for i in range(values.num_groups())]
    return np.concatenate(groups or [np.zeros(0)])


def set_discrete_state(context: Context, state: np.ndarray) -> None:
    """Set all groups of a context's discrete state from one vector."""
    first = 0
    for i in range(context.num_discrete_state_groups()):
        size = context.get_discrete_state(i).size()
        context.SetDiscreteState(i, state[first : first + size])
        first += size


def read_port(port: InputPort | OutputPort, context: Context) -> np.ndarray:
    """Return the value of a port as a vector; a list of wrenches as T and F of each in turn."""
    value = port.Eval(context)
    if is_wrench_list(port):
        return np.concatenate([wrench.get_coeffs() for wrench in value])
    return np.array(value)


def fix_port(port: InputPort, context: Context, value: np.ndarray) -> None:
    """Fix an input port to a value as `read_port` gives it."""
    if is_wrench_list(port):
        wrenches = [SpatialForce(coefficients) for coefficients in value.reshape(-1, 6)]
        port.FixValue(context, Value[list[SpatialForce]](wrenches))
    else:
        port.FixValue(context, value)
