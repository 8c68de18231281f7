"""The laws of the feet's forces that `control.law` chooses from."""

from lola_drake.block import Block
from lola_drake.blocks.configuration_force_control import ConfigurationForceControl
from lola_drake.blocks.damping_force_control import DampingForceControl
from lola_drake.blocks.hybrid_force_control import HybridForceControl, HybridForceControlParams
from lola_drake.blocks.second_order_force_control import SecondOrderForceControl
from lola_drake.blocks.sensed_force_control import SensedForceControl
from lola_drake.blocks.two_dof_force_control import TwoDofForceControl

FORCE_LAWS: dict[str, type[Block]] = {
    "hybrid": HybridForceControl,
    "configuration_space": ConfigurationForceControl,
    "damping": DampingForceControl,
    "second_order": SecondOrderForceControl,
    "two_dof": TwoDofForceControl,
}
"""The paper's, its predecessor [23], and its rivals."""


def law_class(name: str, params: object) -> type[Block]:
    """Return the block of a law; that of the paper has two, see `HybridForceControlParams`."""
    senses = isinstance(params, HybridForceControlParams) and params.senses
    return SensedForceControl if name == "hybrid" and senses else FORCE_LAWS[name]
