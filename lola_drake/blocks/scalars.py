"""Blocks whose law is plain algebra exist for AutoDiffXd, too.

Drake can then differentiate them: such a block answers ToAutoDiffXd(), and Drake's own Linearize
takes it. A block is written once, for floats: it derives from `AlgebraicSystem`, and the decorator
`convertible` makes its twin for AutoDiffXd out of the same methods. They must work on either:
`port.Eval(context).tolist()` and `CopyToVector()` do, `value()` of a vector does not. For functions
of such a number there are `cos`, `sin` and `exp`.
"""

import functools
import math
import types
from collections.abc import Callable

import pydrake.math
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_, SystemScalarConverter


def _of_either(name: str) -> Callable:
    """Return a function of a number: Python's for a float, which is faster, or else Drake's."""
    of_float, of_autodiff = getattr(math, name), getattr(pydrake.math, name)
    return lambda x: of_float(x) if type(x) is float else of_autodiff(x)


cos, sin, exp = _of_either("cos"), _of_either("sin"), _of_either("exp")


class AlgebraicSystem(LeafSystem_[float]):
    """A LeafSystem that can be converted; `Vector` is the BasicVector of its scalar."""

    Vector = BasicVector_[float]
    _converter: SystemScalarConverter

    def __init__(self):
        super().__init__(converter=self._converter)


class _AutoDiffSystem(LeafSystem_[AutoDiffXd]):
    Vector = BasicVector_[AutoDiffXd]
    _converter: SystemScalarConverter

    def __init__(self):
        super().__init__(converter=self._converter)


def convertible(block: type[AlgebraicSystem]) -> type[AlgebraicSystem]:
    """Class decorator: give a block its twin for AutoDiffXd."""
    block.__init__ = _remembering(block.__init__)
    twin = _with_base(block, _AutoDiffSystem)

    def convert(system: AlgebraicSystem) -> _AutoDiffSystem:
        arguments, named = system._arguments
        converted = twin(*arguments, **named)
        converted.set_name(system.get_name())
        return converted

    def to_autodiff(system: AlgebraicSystem) -> _AutoDiffSystem:
        converted = convert(system)
        converted._HandlePostConstructionScalarConversion[float](system)
        return converted

    converter = SystemScalarConverter()
    converter._AddConstructor[AutoDiffXd, float](convert)
    block._converter = twin._converter = converter
    block.ToAutoDiffXd = block.ToAutoDiffXdMaybe = to_autodiff
    return block


def _remembering(initialize: Callable) -> Callable:
    """Let an `__init__` remember its arguments: the twin is made with the same."""

    @functools.wraps(initialize)
    def remembering(self, *arguments, **named):
        self._arguments = arguments, named
        initialize(self, *arguments, **named)

    return remembering


def _with_base(block: type, base: type) -> type:
    """Return a class with the members of a block and another base."""
    twin = types.new_class(block.__name__, (base,))
    for name, member in vars(block).items():
        if name not in ("__dict__", "__weakref__"):
            setattr(twin, name, _in_class(member, twin))
    return twin


def _in_class(member: object, owner: type) -> object:
    """Return a method as if it had been written in another class: its `super()` is that one's."""
    if isinstance(member, types.FunctionType):
        wrapped = getattr(member, "__wrapped__", None)
        if wrapped is not None:
            return _remembering(_in_class(wrapped, owner))
        names = member.__code__.co_freevars
        if "__class__" in names:
            cells = list(member.__closure__)
            cells[names.index("__class__")] = types.CellType(owner)
            return types.FunctionType(
                member.__code__,
                member.__globals__,
                member.__name__,
                member.__defaults__,
                tuple(cells),
            )
    return member
