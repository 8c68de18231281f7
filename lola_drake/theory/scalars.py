"""Functions of a number that a law may use: of a float, of an AutoDiffXd, and in machine code."""

import math
from collections.abc import Callable

import pydrake.math


def _of_either(name: str) -> Callable:
    """Return a function of a number: Python's for a float, which is faster, or else Drake's."""
    of_float, of_autodiff = getattr(math, name), getattr(pydrake.math, name)

    def function(x):
        return of_float(x) if type(x) is float else of_autodiff(x)

    return function


cos, sin, exp = _of_either("cos"), _of_either("sin"), _of_either("exp")
