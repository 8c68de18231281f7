"""Machine code for laws: pure functions of numbers and arrays, compiled once and kept.

A law stays what it is, a plain Python function. `compiled` makes a twin of it with numba, and of
every function that it calls. What is kept on disk is found by a digest of the law's code and of all
that it refers to, so a changed law is compiled again together with what calls it, and no more.
Without numba, or with LOLA_COMPILE=0 in the environment, laws run as they are.
"""

import hashlib
import importlib.util
import math
import os
import sys
import tempfile
import types
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from lola_drake.theory import scalars

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

_FOREIGN = ("numpy", "scipy", "math", "numba", "builtins")
_MACHINE = {scalars.cos: math.cos, scalars.sin: math.sin, scalars.exp: math.exp}


class NotCompilable(Exception):
    """A law that numba cannot compile; the message says why."""


def compiling() -> bool:
    """Return whether laws are compiled."""
    return (
        os.environ.get("LOLA_COMPILE", "1") != "0" and importlib.util.find_spec("numba") is not None
    )


def compiled(function: Callable, arguments: tuple) -> "Dispatcher":
    """Return the compiled twin of a pure function for arguments like the given ones.

    Raises:
        NotCompilable: if numba cannot compile it.
    """
    import numba

    try:
        twin = _called(function)
        twin.compile(tuple(numba.typeof(argument) for argument in arguments))
    except NotCompilable:
        raise
    except Exception as error:  # numba's are of many kinds
        reason = str(error).strip().splitlines()
        raise NotCompilable(reason[0] if reason else type(error).__name__) from error
    return twin


@cache
def _called(function: Callable) -> "Dispatcher":
    """Return the twin of a law as Python calls it: around the one that machine code calls.

    The two must not share the objects that numba keeps with a function.
    """
    names = ", ".join(function.__code__.co_varnames[: function.__code__.co_argcount])
    name = f"call_{function.__name__}"
    text = f"def {name}({names}):\n    return law({names})\n"
    return compiled_text(name, text, {"law": function})


def compiled_text(name: str, text: str, called: Mapping[str, Callable]) -> "Dispatcher":
    """Return the compiled function `name` of a program text.

    Args:
        name: of the function.
        text: of the program.
        called: the functions that it calls, and the classes of named tuples that it makes.
    """
    parts = [text, *map(digest, called.values())]
    path = _stub(name, hashlib.sha256("\n".join(parts).encode()).hexdigest(), text)
    # Its home is a module that can be imported when it is loaded from the disk.
    space: dict[str, Any] = {"__name__": __name__} | {
        key: what if isinstance(what, type) else _twin(what) for key, what in called.items()
    }
    exec(compile(text, str(path), "exec"), space)
    return _jit(space[name])


def is_kept(function: "Dispatcher") -> bool:
    """Return whether a function of `compiled_text` was compiled before, in this or another run."""
    name = Path(function.py_func.__code__.co_filename).stem
    folder = function.stats.cache_path
    return folder is not None and any(Path(folder).glob(f"{name}.*"))


@cache
def _twin(function: Callable) -> "Dispatcher":
    """Return a function that is compiled when it is called first, with all that it calls."""
    code = function.__code__
    if code.co_freevars:
        raise NotCompilable(f"{function.__qualname__} is a closure")
    space = function.__globals__ | {
        name: _MACHINE.get(value) or _twin(value)
        for name, value in _globals(function)
        if _is_law(value)
    }
    space["__name__"] = __name__
    path = _stub(function.__name__, digest(function), f'"""Of {function.__qualname__}."""\n')
    twin = types.FunctionType(
        code.replace(co_filename=str(path)), space, function.__name__, function.__defaults__
    )
    twin.__qualname__ = function.__name__
    return _jit(twin)


def _jit(function: Callable) -> "Dispatcher":
    import numba

    return numba.njit(cache=True, error_model="numpy")(function)


@cache
def digest(function: Any) -> str:
    """Return what identifies the code of a function and of all that it refers to.

    Its module is part of that: what numba keeps refers to named tuples by theirs.
    """
    import numba

    name = f"{function.__module__} {function.__qualname__}"
    if hasattr(function, "_fields"):
        return f"{name} {function._fields}"
    parts = [sys.version, numba.__version__, name, repr(function.__defaults__)]
    parts += [
        repr((code.co_code, _plain(code.co_consts), code.co_names))
        for code in _codes(function.__code__)
    ]
    for name, value in _globals(function):
        if _is_law(value):
            parts.append(name if value in _MACHINE else digest(value))
        elif isinstance(value, types.ModuleType):
            attributes = [n for n in _names(function) if n in vars(value)]
            parts += [f"{name}.{n} {_text(getattr(value, n))}" for n in attributes]
        else:
            parts.append(f"{name} {_text(value)}")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _plain(constants: tuple) -> tuple:
    return tuple(c for c in constants if not isinstance(c, types.CodeType))


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _text(value: object) -> str:
    """Return what identifies a constant; nothing for what is none."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    return repr(value) if isinstance(value, (bool, int, float, str, np.generic)) else ""


def _names(function: Callable) -> list[str]:
    """Return the names of globals and attributes that a function refers to."""
    return sorted({name for code in _codes(function.__code__) for name in code.co_names})


def _globals(function: Callable) -> list[tuple[str, Any]]:
    """Return the global names that a function refers to, with their values."""
    space = function.__globals__
    return [(name, space[name]) for name in _names(function) if name in space]


def _is_law(value: object) -> TypeGuard[types.FunctionType]:
    foreign = getattr(value, "__module__", None) or ""
    return isinstance(value, types.FunctionType) and foreign.split(".")[0] not in _FOREIGN


def _stub(name: str, key: str, text: str) -> Path:
    """Return the file beside which numba keeps what it has compiled of this name and key."""
    path = cache_folder() / f"{name}_{key[:20]}.py"
    if not path.exists():
        with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".tmp", delete=False) as file:
            file.write(text)
        os.replace(file.name, path)
    return path


@cache
def cache_folder() -> Path:
    """Return the folder for compiled laws: the user's cache, or a temporary one."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lola_drake"
    try:
        base.mkdir(parents=True, exist_ok=True)
        if os.access(base, os.W_OK | os.X_OK):
            return base
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="lola_drake-"))
