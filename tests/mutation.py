"""Does a test fail where the code is wrong? A command, the long form of the tests.

    pip install '.[test,mutation]'
    python tests/mutation.py                # the thirteen of version 0.1, and 200 at random
    python tests/mutation.py --samples 50 --seed 3

First all tests of the mutated modules run once and tell which lines they reach. Then each mutant is
tried by the tests that reach its line, the quickest first, in a process of its own, with laws that
run as Python. What survives is printed; docs/experiments/mutation.json keeps it, with the reasons
that somebody has given.
"""

import argparse
import importlib.machinery
import json
import linecache
import os
import resource
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

os.environ |= {"LOLA_COMPILE": "0", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg"}

from mutants import ROOT, Mutant, found, sampled  # noqa: E402

TESTS = (
    "tests/theory",
    "tests/blocks",
    "tests/linear",
    "tests/test_metrics.py",
    "tests/test_block.py",
    "tests/test_controller.py",
    "tests/test_ground.py",
    "tests/scenarios/test_closed_loop.py",
)
SLOW = (
    "tests/linear/studies",
    "tests/linear/test_docs.py",
    "tests/linear/test_margins_brute_force.py",
)
"""Tests among them that only ask what others ask, at length."""

TRIED = 0.2
"""The tests of one mutant take at most this part of what all of them take."""

PATIENCE = 120
"""A mutant that needs more time of the processor is killed, too (s)."""

RECORD = ROOT / "docs" / "experiments" / "mutation.json"


class Reach:
    """Which tests reach which line, and how long they take."""

    def __init__(self, folder: Path):
        """Run all tests once, unless the folder already knows."""
        self._data, times = folder / "coverage", folder / "times.xml"
        if not times.exists():
            command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
            command += ["--cov=lola_drake", "--cov-context=test", "--cov-report="]
            command += [f"--junitxml={times}", *TESTS, *(f"--ignore={slow}" for slow in SLOW)]
            where = os.environ | {"COVERAGE_FILE": str(self._data)}
            subprocess.run(command, cwd=ROOT, env=where, check=False)
        # What fails with the right code, or is skipped, says nothing.
        self._times = {
            f"{case.get('classname').replace('.', '/')}.py::{case.get('name')}": float(
                case.get("time")
            )
            for case in ElementTree.parse(times).iter("testcase")
            if not len(case)
        }

    def tests(self, mutant: Mutant) -> list[str]:
        """Return the tests of a mutant, the quickest first."""
        if mutant.tests:
            return list(mutant.tests)
        from coverage import CoverageData

        data = CoverageData(basename=str(self._data))
        data.read()
        by_line = data.contexts_by_lineno(str(ROOT / mutant.path))
        reaching = {c.rpartition("|")[0] for c in by_line.get(mutant.line, ())} - {""}
        # A line that runs on import concerns whoever uses the module.
        reaching = reaching or {c.rpartition("|")[0] for each in by_line.values() for c in each}
        taken, chosen, allowed = 0.0, [], TRIED * sum(self._times.values())
        for test in sorted(reaching & self._times.keys(), key=self._times.get):
            taken += self._times[test]
            if taken > allowed and chosen:
                break
            chosen.append(test)
        return chosen


def survives(mutant: Mutant, tests: list[str]) -> bool:
    """Return whether all tests pass, in a process of their own."""
    if not tests:
        return True
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1), os.dup2(nothing, 2)
        _replace(ROOT / mutant.path, mutant.text)
        import pytest

        code = 1
        try:
            code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-p", "no:cov", *tests])
        finally:
            os._exit(int(code))
    _, status = os.waitpid(child, 0)
    return status == 0


def _replace(path: Path, text: str) -> None:
    """Let a module have another text when it is imported."""
    real = importlib.machinery.SourceFileLoader.get_code

    def get_code(self, name):
        if Path(self.path) == path:
            return compile(text, self.path, "exec")
        return real(self, name)

    importlib.machinery.SourceFileLoader.get_code = get_code
    linecache.cache[str(path)] = len(text), None, text.splitlines(keepends=True), str(path)


def _warm_up() -> None:
    """Import once what all tests need, but nothing of the package itself."""
    import control  # noqa: F401
    import hypothesis  # noqa: F401
    import pydrake.all  # noqa: F401
    import pytest  # noqa: F401
    import scipy.optimize  # noqa: F401


def _surviving(mutants: list[Mutant], reach: Reach) -> Iterator[Mutant]:
    for number, mutant in enumerate(mutants, 1):
        alive = survives(mutant, reach.tests(mutant))
        print(f"{number:4d} {'SURVIVES' if alive else 'killed'} {mutant.change}", flush=True)
        if alive:
            yield mutant


def main() -> None:
    """Try mutants, and write what became of them."""
    parser = argparse.ArgumentParser(description="Try mutants of the package.")
    parser.add_argument("--samples", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, help="try only so many of the samples")
    parser.add_argument("--reach", type=Path, help="folder that keeps which test reaches what")
    given = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    with tempfile.TemporaryDirectory() as folder:
        reach = Reach(given.reach or Path(folder))
        _warm_up()
        old = list(_surviving(found(), reach))
        chosen = sampled(given.samples, given.seed)[: given.first]
        alive = list(_surviving(chosen, reach))
    known = json.loads(RECORD.read_text())["survivors"] if RECORD.exists() else {}
    content = {
        "samples": given.samples,
        "seed": given.seed,
        "tried": len(chosen),
        "killed_percent": 100 * (1 - len(alive) / max(len(chosen), 1)),
        "survivors_of_version_0_1": [mutant.change for mutant in old],
        "survivors": {mutant.change: known.get(mutant.change, "") for mutant in alive},
    }
    RECORD.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"{content['killed_percent']:.1f} % of {len(chosen)} killed; written to {RECORD}")


if __name__ == "__main__":
    main()
