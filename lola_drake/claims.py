"""CLAIMS.md: what README and docs claim, and the tests and commands that show it."""

import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from lola_drake.errors import LolaError

CHECKOUT = Path(__file__).resolve().parents[1]
PAGE = "CLAIMS.md"


@dataclass(frozen=True)
class Claim:
    """One line of the page.

    Attributes:
        where: link to the section that claims it: a file, and an anchor.
        text: what is claimed.
        tests: of pytest, whole files or single ones, which show it in a moment.
        commands: that show it, for somebody with more time.
        measured: when that was last done.
    """

    where: str
    text: str
    tests: tuple[str, ...]
    commands: tuple[str, ...]
    measured: str


def claims() -> list[Claim]:
    """Return all claims.

    Raises:
        LolaError: outside a checkout, which alone has the page and the tests.
    """
    page = CHECKOUT / PAGE
    if not (page.exists() and (CHECKOUT / "tests").is_dir()):
        raise LolaError(f"{PAGE}: lola claims needs a checkout with its tests")
    rows = [line for line in page.read_text(encoding="utf-8").splitlines() if line[:2] == "| "]
    found = []
    for row in rows[1:]:
        where, text, shown, measured = (cell.strip() for cell in row.strip("|").split(" | "))
        link, quoted = re.search(r"\]\((.*?)\)", where), re.findall(r"`([^`]+)`", shown)
        tests = tuple(text for text in quoted if text.startswith("tests/"))
        commands = tuple(text for text in quoted if text not in tests)
        found.append(Claim(link[1] if link else "", text, tests, commands, measured))
    return found


def run_tests(chosen: list[Claim]) -> dict[str, bool]:
    """Return whether every test of some claims passes, each by its name."""
    tests = sorted({test for claim in chosen for test in claim.tests})
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "tests.xml"
        command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={record}", *tests]
        subprocess.run(command, cwd=CHECKOUT, check=False, stdout=sys.stderr)
        if not record.exists():
            raise LolaError("pytest did not run; pip install 'lola_drake[test]'")
        outcome: dict[str, bool] = {}
        for case in ElementTree.parse(record).iter("testcase"):
            file = case.get("classname", "").replace(".", "/") + ".py"
            passed = case.find("failure") is None and case.find("error") is None
            folders = (str(folder) for folder in Path(file).parents)
            for name in (file, *folders, f"{file}::{case.get('name', '').partition('[')[0]}"):
                outcome[name] = outcome.get(name, True) and passed
    return {test: outcome.get(test, False) for test in tests}
