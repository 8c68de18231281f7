"""What README and docs tell people to type in Python runs; simulations are short here."""

import re
from pathlib import Path

import pytest

import lola_drake as lola

ROOT = Path(__file__).parents[1]
PAGES = (
    "README.md",
    "docs/howto/own_law.md",
    "docs/howto/engines.md",
    "docs/howto/notebook.md",
    "docs/howto/records.md",
    "docs/tutorials/first_walk.md",
)


@pytest.mark.parametrize("page", PAGES)
def test_code_of_a_page_runs(page, tmp_path, monkeypatch):
    pytest.importorskip("IPython")
    monkeypatch.chdir(tmp_path)
    load = lola.load_scenario

    def short(name, changes=()):
        return load(name, dict(changes) | {"duration": 0.5})

    monkeypatch.setattr(lola, "load_scenario", short)
    simulate = lola.simulate
    monkeypatch.setattr(
        lola,
        "simulate",
        lambda scenario, **options: simulate(
            short(scenario) if isinstance(scenario, str) else scenario, **options
        ),
    )
    names = {"__name__": "page"}
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```python.*?\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert blocks
    for block in blocks:
        exec(re.sub(r"(advance|AdvanceTo)\(\d\.", r"\1(0.", block), names)  # noqa: S102


@pytest.mark.parametrize("page", ["README.md"])
def test_code_is_not_wider_than_a_page_on_github(page):
    inside = False
    for line in (ROOT / page).read_text(encoding="utf-8").splitlines():
        inside ^= line.lstrip().startswith("```")
        assert not inside or len(line) <= 94, line
