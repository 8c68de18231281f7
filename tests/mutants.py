"""Mutants of this package: where code can be wrong by one operator or number.

Cosmic-ray says how an operator is mutated; here stands which of them say something. What cannot be
told from the right code by any test, or is told at once by the interpreter, is left out: shifts
and bits of floats, annotations, the bounds and texts of declared parameters, messages of errors.
"""

import ast
import random
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[1]
SCOPE = ("blocks/*.py", "theory/*.py", "metrics.py", "linear/*.py")
"""What is mutated, in the package."""

SHOWING = {"tables", "text_table", "units", "errors", "model"}
"""Modules of `linear` that only show what the others find."""

_SAYING = re.compile(
    r"core/(ReplaceBinaryOperator_(Add|Sub|Mul|Div|Pow|Mod|FloorDiv|MatMul)"
    r"_(Add|Sub|Mul|Div)|ReplaceComparison.*(?<!Is)(?<!IsNot)$"
    r"|ReplaceUnary.*|.*Boolean.*|ReplaceAndWithOr|ReplaceOrWithAnd|NumberReplacer|AddNot"
    r"|ZeroIterationForLoop|Replace(Break|Continue).*)"
)
_DECLARING = {"parameter", "listing", "Field", "Signal", "validate"}


@dataclass(frozen=True)
class Mutant:
    """One change of one file.

    Attributes:
        path: of the file, from the root of the project on.
        line: that changes first.
        text: the whole file, changed.
        tests: to try; none for all that run the line.
    """

    path: str
    line: int
    text: str
    tests: tuple[str, ...] = ()

    @cached_property
    def change(self) -> str:
        """Return the line before and after."""
        lines = zip(_read(self.path).splitlines(), self.text.splitlines(), strict=False)
        old, new = next((old, new) for old, new in lines if old != new)
        return f"{self.path}:{self.line}: {old.strip()} -> {new.strip()}"


def _read(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def sampled(count: int, seed: int) -> list[Mutant]:
    """Return mutants drawn at random: a place first, then what may stand there instead."""
    places: dict[tuple[str, tuple[int, int]], list[tuple[str, int]]] = {}
    for pattern in SCOPE:
        for file in sorted((ROOT / "lola_drake").glob(pattern)):
            if file.stem not in SHOWING:
                path = file.relative_to(ROOT).as_posix()
                for start, operator, occurrence in _mutations(_read(path)):
                    places.setdefault((path, start), []).append((operator, occurrence))
    drawn = random.Random(seed)
    chosen = drawn.sample(sorted(places), min(count, len(places)))
    found = []
    for path, start in chosen:
        operator, occurrence = drawn.choice(places[path, start])
        text = mutate_code(_read(path), get_operator(operator)(), occurrence)
        found.append(Mutant(path, start[0], text))
    return found


def _mutations(source: str) -> list[tuple[tuple[int, int], str, int]]:
    """Return where, by which of cosmic-ray's operators, and at which of its occurrences."""
    silent, nodes = _silent_spans(source), list(ast_nodes(get_ast(source)))
    found = []
    for name in filter(_SAYING.fullmatch, operator_names()):
        operator = get_operator(name)()
        starts = (start for node in nodes for start, _ in operator.mutation_positions(node))
        for occurrence, start in enumerate(starts):
            if not any(first <= start < last for first, last in silent):
                found.append((start, name, occurrence))
    return found


def _silent_spans(source: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the parts of a file in which a mutant would say nothing."""
    parts = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.arg, ast.AnnAssign)):
            parts += [getattr(node, "returns", None), getattr(node, "annotation", None)]
        is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if isinstance(node, ast.Raise) or (is_call and node.func.id in _DECLARING):
            parts.append(node)
    return [
        ((part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset))
        for part in parts
        if part is not None
    ]


_STUDIES = "tests/linear/studies/"

_FOUND = (
    ("blocks/walking_pattern.py", "-side * self.params", "side * self.params"),
    ("theory/gait.py", "(stance_z + ground) / 2", "ground / 2"),
    ("theory/gait.py", "max(z, stance_z, ground)", "max(z, ground)"),
    ("theory/step_plan.py", "([zmp, at.ground])", "([zmp, 0 * at.ground])"),
    ("blocks/foot_force_control.py", "w_id[3] + task_modification[0], w_id[4]", "w_id[3], w_id[4]"),
    ("blocks/foot_force_control.py", "max(force / grip_force, 0.0)", "force / grip_force"),
    ("linear/studies/poincare.py", "0.5 * frame", "frame", _STUDIES + "test_poincare.py"),
    ("linear/margins.py", "delay.argmin()", "delay.argmax()"),
    ("linear/interconnection.py", "self.drift / self.coordinates.scales", "self.drift"),
    ("linear/poles.py", "z[np.abs(z - 1) >= UNSTABLE]", "z"),
    ("linear/frequency.py", ", turning[turning > lowest], around]", ", turning[turning > lowest]]"),
    ("linear/studies/analyses.py", "model.D[:, k]", "0", _STUDIES + "test_analyses.py"),
    ("linear/open_loop.py", "-loop.D", "loop.D"),
)
"""Thirteen that no test of version 0.1 killed: file, code, what took its place, tests."""


def found() -> list[Mutant]:
    """Return the thirteen mutants that version 0.1 did not notice."""
    mutants = []
    for name, old, new, *tests in _FOUND:
        path = f"lola_drake/{name}"
        text = _read(path)
        if text.count(old) != 1:
            raise LookupError(f"{path}: {old!r} is there {text.count(old)} times")
        line = text[: text.index(old)].count("\n") + 1
        mutants.append(Mutant(path, line, text.replace(old, new), tuple(tests)))
    return mutants
