"""The walking controller of the humanoid LOLA as a Drake block diagram."""

import importlib

_HOME = {
    "Result": "results",
    "load_result": "results",
    "Scenario": "scenario",
    "ScenarioError": "scenario",
    "load_scenario": "scenario",
    "build_simulation": "simulation",
    "simulate": "simulation",
    "linearize": "analysis.linear.linearize",
    "open_loop": "analysis.linear.open_loop",
}

__all__ = list(_HOME)


def __getattr__(name: str):
    """Import a public name when it is first used: `lola list` need not wait for Drake."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
