"""What mypy has to know about Drake's stubs.

They write an array as ndarray[float64[m, 1]], a type that no array has: a parameter of this type
takes whatever NumPy makes an array of, and what is returned is an array. And where a stub names
one of these base classes as what a function returns, Python gets an object of its own class.
"""

from mypy.plugin import FunctionSigContext, MethodSigContext, Plugin
from mypy.type_visitor import TypeTranslator
from mypy.types import AnyType, FunctionLike, Instance, Type, TypeOfAny

_ANY = AnyType(TypeOfAny.explicit)
_BASES = (
    "builtins.object",
    "pydrake.multibody.tree.Joint",
    "pydrake.systems.framework.System",
)


class _Taken(TypeTranslator):
    def visit_instance(self, t: Instance) -> Type:
        return _ANY if t.type.fullname == "numpy.ndarray" else super().visit_instance(t)


class _Returned(TypeTranslator):
    def visit_instance(self, t: Instance) -> Type:
        if t.type.fullname == "numpy.ndarray":
            return t.copy_modified(args=[_ANY, _ANY])
        return _ANY if t.type.fullname in _BASES else super().visit_instance(t)


def _corrected(context: FunctionSigContext | MethodSigContext) -> FunctionLike:
    signature = context.default_signature
    if not (signature.definition and signature.definition.fullname.startswith("pydrake.")):
        return signature
    return signature.copy_modified(
        arg_types=[t.accept(_Taken()) for t in signature.arg_types],
        ret_type=signature.ret_type.accept(_Returned()),
    )


class _DrakeStubs(Plugin):
    def get_function_signature_hook(self, fullname):
        return _corrected  # A method is asked for by the class of its object, not its own.

    get_method_signature_hook = get_function_signature_hook


def plugin(version: str) -> type[Plugin]:
    """Return the plugin, for mypy."""
    return _DrakeStubs
