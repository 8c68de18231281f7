"""What README and docs tell people to type in Python runs; simulations are short here."""

import inspect
import pkgutil
import re
import shlex
import tomllib
from pathlib import Path

import pytest
import typer

import lola_drake as lola
from lola_drake.cli.app import app
from lola_drake.paths import scenario_paths

ROOT = Path(__file__).parents[1]
PAGES = (
    "README.md",
    "docs/howto/own_law.md",
    "docs/howto/engines.md",
    "docs/howto/notebook.md",
    "docs/howto/records.md",
    "docs/howto/studies.md",
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
    names = {"__name__": "__main__"}
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


DOCS = sorted((ROOT / "docs").rglob("*.md"))
TEXTS = [*DOCS, *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))]


def prose(page):
    """Return the text of a page without its code."""
    return re.sub(r"```.*?```|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def anchors(page):
    """Return the anchors of a page's headings, as GitHub and the site make them."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    titles = re.findall(r"^#+ (.*)", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page):
    text = prose(page)
    for link, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", text):
        if "://" not in link:
            target = page.parent / link if link else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), f"{link}#{anchor}"
    for source in re.findall(r'src="([^"]*)"', text):
        assert (page.parent / source).exists(), source


def test_links_to_other_sites_are_encrypted_and_each_is_written_in_one_way():
    links = {link for page in TEXTS for link in re.findall(r"https?:[^\s)>\"]+", prose(page))}
    assert links and all(re.fullmatch(r"https://[a-z.]+\.[a-z]+(/[\w./-]*)?", x) for x in links)
    assert len({link.rstrip("/").replace("www.", "") for link in links}) == len(links)


def named_commands(page):
    """Return what a page tells to type after `lola`, but for what stands for something else."""
    text = page.read_text(encoding="utf-8")
    spans = re.findall(r"`(lola [^`]+)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    lines = re.findall(r"^(?:venv/bin/)?(lola .*)", text, re.MULTILINE)
    found = (re.split(r" {2,}#|\s#", command)[0] for command in [*spans, *lines])
    return sorted({c for c in found if re.match(r"lola [a-z]", c) and "…" not in c})


@pytest.mark.parametrize("page", TEXTS[:-1], ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_of_a_page_exist_with_their_options(page):
    """Options and their kinds are right; what they are for may be left out."""
    for line in named_commands(page):
        rest, command = shlex.split(line)[1:], typer.main.get_command(app)
        while hasattr(command, "commands") and rest:
            assert rest[0] in command.commands, line
            command, rest = command.commands[rest[0]], rest[1:]
        try:
            command.make_context(line, rest)
        except Exception as error:  # of click, or of the copy that typer has of it
            left_out = type(error).__name__ in ("MissingParameter", "NoArgsIsHelpError")
            assert left_out, f"{line}: {error}"


def test_every_command_is_in_the_reference_and_in_the_readme():
    commands = set(typer.main.get_command(app).commands)
    for page in ("README.md", "docs/reference/commands.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert commands <= set(re.findall(r"`lola ([a-z]+)", text)), page


def test_every_scenario_is_in_the_table_and_in_the_readme():
    for page in ("README.md", "docs/scenarios.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert set(scenario_paths()) <= set(re.findall(r"`([a-z_0-9]+)`", text)), page


def test_no_module_is_called_like_a_public_name():
    """Who imports it would find the module in the place of what it holds."""
    assert not {module.name for module in pkgutil.iter_modules(lola.__path__)} & set(lola.__all__)


def test_every_public_name_is_in_the_reference():
    pages = "\n".join(page.read_text(encoding="utf-8") for page in DOCS)
    shown = set(re.findall(r"^::: (\S+)", pages, re.MULTILINE))
    homes = {name: getattr(lola, name).__module__ for name in lola.__all__}
    assert {name: home for name, home in homes.items() if home not in shown} == {}


@pytest.mark.parametrize("name", lola.__all__)
def test_every_public_name_says_what_it_takes(name):
    thing = getattr(lola, name)
    doc = inspect.getdoc(thing)
    assert doc
    if inspect.isfunction(thing):
        for parameter in inspect.signature(thing).parameters:
            assert re.search(rf"^ +{parameter}: \S", doc, re.MULTILINE), parameter


def test_every_page_of_the_site_is_in_its_menu():
    menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for page in DOCS:
        assert page.relative_to(ROOT / "docs").as_posix() in menu


def test_every_extra_is_in_the_one_table():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `lola_drake\[(\w+)\]` \|", table, re.MULTILINE))
    assert told == set(project["optional-dependencies"])


def test_the_version_is_everywhere_the_same():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    noted = re.search(r"^## (\S+)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert project["version"] == cited[1] == noted[1]
