"""The blocks of a system cut apart: each with its inputs fixed, in a copy of a context."""

from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, InputPort, OutputPort, System

from lola_drake.analysis.linear.entries import is_vector, is_wrench_list
from lola_drake.analysis.linear.errors import AnalysisError, drake_errors
from lola_drake.analysis.linear.wiring import Target, Wiring


@dataclass(frozen=True)
class Instance:
    """A block and its context, of whatever scalar type.

    Attributes:
        owner: whatever must stay alive with them.
    """

    system: System
    context: Context
    owner: object = None


class CutBlocks:
    """Every block of a system with its inputs fixed to what they are in a context.

    The copy's time is the context's, so that noise and plans are what they are in that tick.

    Attributes:
        wiring: the blocks and their connections.
        instances: the blocks with their contexts in the copy.
        inputs: the fixed values.
    """

    def __init__(self, wiring: Wiring, context: Context):
        """Cut the blocks; `context`, of the system or of a diagram around it, stays as it is."""
        self.wiring = wiring
        with drake_errors("not a context of this system"):
            root = context.Clone()
            self.instances = {
                path: Instance(block, own_context(block, root), root)
                for path, block in wiring.blocks.items()
            }
            originals = {path: own_context(block, context) for path, block in wiring.blocks.items()}
        self.inputs: dict[Target, np.ndarray] = {}
        for path, block in wiring.blocks.items():
            for i in range(block.num_input_ports()):
                port = block.get_input_port(i)
                if is_vector(port) and port.HasValue(originals[path]):
                    with drake_errors(f"{path}.{port.get_name()} cannot be evaluated"):
                        self.inputs[Target(path, i)] = read_port(port, originals[path])
        for target, value in self.inputs.items():
            instance = self.instances[target.block]
            fix_port(instance.system.get_input_port(target.index), instance.context, value)

    def check(self, path: str) -> None:
        """Raise AnalysisError if a block is not a discrete system with one period."""
        block, context = self.instances[path].system, self.instances[path].context
        reason = None
        if block.num_continuous_states():
            reason = "it has continuous state"
        elif context.num_abstract_states():
            reason = "it has abstract state"
        elif context.num_discrete_state_groups() and self.period(path) is None:
            reason = "it has no single periodic discrete update"
            if isinstance(block, MultibodyPlant):
                reason += " (build the plant with use_sampled_output_ports=False)"
        if reason:
            raise AnalysisError(f"{path} cannot be linearised: {reason}")

    def period(self, path: str) -> float | None:
        """Return the period of a block's discrete update (s), None if it has none or several."""
        timing = self.instances[path].system.GetUniquePeriodicDiscreteUpdateAttribute()
        return timing.period_sec() if timing else None


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
