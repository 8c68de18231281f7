"""The walking controller of the humanoid LOLA as a Drake block diagram.

Names are imported when they are first used (PEP 562), so that `import lola_drake` is instant and
what does not need Drake does not wait for it.
"""

import importlib
import os
from typing import Any

# A second thread never pays for matrices of a few hundred rows, and on busy cores all threads wait
# for the slowest in every product. OpenBLAS asks when numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_HOME = {
    "AnalysisError": "linear.errors",
    "Block": "block",
    "block_diagram": "diagram.block_diagram",
    "BlockError": "block",
    "build_simulation": "world",
    "compare": "studies.variants",
    "frequency_data": "linear.frequency",
    "law": "block",
    "linearize": "linear.linearize",
    "load_result": "results",
    "load_scenario": "scenario",
    "LolaError": "errors",
    "margins": "linear.margins",
    "open_loop": "linear.open_loop",
    "OutputError": "errors",
    "parameter": "parameters",
    "ParameterError": "parameters",
    "Part": "block",
    "poles": "linear.poles",
    "Result": "results",
    "ResultError": "results",
    "save_diagram": "diagram.block_diagram",
    "Scenario": "scenario",
    "ScenarioError": "scenario",
    "settings": "settings",
    "show": "notebook",
    "start": "simulation",
    "State": "block",
    "simulate": "simulation",
    "write_report": "reports.run_report",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    # A module such as `settings` must not take the place of what it holds.
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
