"""What mypy has to know about Drake's stubs.

They write an array as ndarray[float64[m, 1]], a type that no array has: what takes this takes
whatever NumPy makes an array of, and what gives it gives an array. And where a stub names one of
these base classes as what is given, Python gets an object of its own class.
"""

from mypy.plugin import AttributeContext, FunctionSigContext, MethodSigContext, Plugin
from mypy.type_visitor import TypeTranslator
from mypy.types import AnyType, FunctionLike, Instance, Type, TypeAliasType, TypeOfAny
from mypy.types import get_proper_type as without_alias

_ANY = AnyType(TypeOfAny.explicit)
_BASES = (
    "builtins.object",
    "pydrake.multibody.tree.Joint",
    "pydrake.systems.framework.System",
)


class _Taken(TypeTranslator):
    def visit_instance(self, t: Instance) -> Type:
        return _ANY if t.type.fullname == "numpy.ndarray" else super().visit_instance(t)

    def visit_type_alias_type(self, t: TypeAliasType) -> Type:
        return without_alias(t).accept(self)


class _Given(_Taken):
    def visit_instance(self, t: Instance) -> Type:
        if t.type.fullname == "numpy.ndarray":
            return t.copy_modified(args=[_ANY, _ANY])
        return _ANY if t.type.fullname in _BASES else super().visit_instance(t)


def _signature(context: FunctionSigContext | MethodSigContext) -> FunctionLike:
    signature = context.default_signature
    if not (signature.definition and signature.definition.fullname.startswith("pydrake.")):
        return signature
    return signature.copy_modified(
        arg_types=[t.accept(_Taken()) for t in signature.arg_types],
        ret_type=signature.ret_type.accept(_Given()),
    )


def _attribute(context: AttributeContext) -> Type:
    return context.default_attr_type.accept(_Taken() if context.is_lvalue else _Given())


class _DrakeStubs(Plugin):
    def get_function_signature_hook(self, fullname):
        return _signature  # A method is asked for by the class of its object, not its own.

    get_method_signature_hook = get_function_signature_hook

    def get_attribute_hook(self, fullname):
        return _attribute if fullname.startswith("pydrake.") else None


def plugin(version: str) -> type[Plugin]:
    """Return the plugin, for mypy."""
    return _DrakeStubs
