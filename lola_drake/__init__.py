"""The walking controller of the humanoid LOLA as a Drake block diagram.

Names are imported when they are first used (PEP 562), so that `import lola_drake` is instant and
what does not need Drake does not wait for it.
"""

import ast
import importlib
import os
from pathlib import Path
from typing import Any

# A second thread never pays for matrices of a few hundred rows, and on busy cores all threads wait
# for the slowest in every product. OpenBLAS asks when numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_FACE = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_HOME = {
    name.name: statement.module
    for statement in _FACE.body
    if isinstance(statement, ast.ImportFrom)
    for name in statement.names
}
"""Every public name with its module; a type checker reads the same file."""

__all__ = sorted(_HOME, key=str.lower)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
