"""The walking controller of the humanoid LOLA as a Drake block diagram.

Names are imported when they are first used (PEP 562), so that `import lola_drake` is instant and
what does not need Drake does not wait for it.
"""

import importlib
from typing import Any

_HOME = {
    "build_simulation": "simulation",
    "frequency_data": "linear.frequency",
    "linearize": "linear.linearize",
    "load_result": "results",
    "load_scenario": "scenario",
    "margins": "linear.margins",
    "open_loop": "linear.open_loop",
    "poles": "linear.poles",
    "Result": "results",
    "save_diagram": "diagram.block_diagram",
    "Scenario": "scenario",
    "ScenarioError": "scenario",
    "simulate": "simulation",
    "write_report": "reports.run_report",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
