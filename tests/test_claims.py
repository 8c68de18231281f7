"""CLAIMS.md leads somewhere, leaves no section out, and the figures are those of the records."""

import ast
import json
import re
import shlex

import pytest
import typer
from typer.testing import CliRunner

import lola_drake as lola
from lola_drake import claims as claims_module
from lola_drake.claims import CHECKOUT, Claim, claims, run_tests
from lola_drake.cli.app import app
from lola_drake.errors import LolaError
from lola_drake.paths import scenario_paths

PAGES = (
    "README.md",
    "docs/architecture.md",
    "docs/experiments.md",
    "docs/scenarios.md",
    "docs/laws.md",
    "docs/linearise.md",
    "docs/faq.md",
    "docs/limitations.md",
    "docs/howto/engines.md",
    "docs/howto/tuning.md",
)
MEASURED = re.compile(r"\d ?(%|°|ms\b|µs\b|mm\b|MB\b|km/h)")
"""What a section with a measured number looks like."""

CLAIMS = claims()


def recorded(name):
    return json.loads((CHECKOUT / f"docs/experiments/{name}.json").read_text())["experiments"]


RECORD, MUJOCO = recorded("reproduction"), recorded("reproduction_20_mujoco")
NAMES = ("step_down", "step_down_8cm5", "board_9cm", "board_4cm")
METRICS = [
    (metric, axis) for metric in ("max_inclination_deg", "rms_torque_error_Nm") for axis in "xy"
]


def text_of(page):
    return (CHECKOUT / page).read_text(encoding="utf-8")


def sections(page):
    """Return the prose of every section of a page, by the anchor that GitHub gives it."""
    found, anchor, inside = {}, "", False
    for line in text_of(page).splitlines():
        inside ^= line.startswith("```")
        if line.startswith("#") and not inside:
            title = re.sub(r"[^\w\- ]", "", line.lstrip("# ").lower())
            anchor = title.replace(" ", "-")
            found[anchor] = ""
        elif not inside and anchor:
            found[anchor] += re.sub(r"`[^`]*`", "", line) + "\n"
    return found


@pytest.mark.parametrize("link", sorted({claim.where for claim in CLAIMS}))
def test_links_lead_to_sections(link):
    page, _, anchor = link.partition("#")
    assert anchor in sections(page)


def test_links_in_the_page_lead_to_files():
    targets = re.findall(r"\]\(([^)#]+)", text_of("CLAIMS.md"))
    assert targets and all((CHECKOUT / target).exists() for target in targets)


@pytest.mark.parametrize("test", sorted({test for claim in CLAIMS for test in claim.tests}))
def test_tests_exist(test):
    file, _, name = test.partition("::")
    if (CHECKOUT / file).is_dir():
        assert not name and list((CHECKOUT / file).glob("test_*.py"))
        return
    defined = {
        node.name
        for node in ast.walk(ast.parse(text_of(file)))
        if isinstance(node, ast.FunctionDef)
    }
    assert name in defined or not name


@pytest.mark.parametrize("command", sorted({c for claim in CLAIMS for c in claim.commands}))
def test_commands_exist_with_their_options(command):
    program, *arguments = shlex.split(command)
    if program == "python":
        assert (CHECKOUT / arguments[0]).exists()
        return
    assert program == "lola"
    name, *rest = arguments
    chosen = typer.main.get_command(app).commands[name]
    context = chosen.make_context(name, list(rest), resilient_parsing=False)
    scenario = context.params.get("scenario")
    assert scenario is None or scenario in scenario_paths()
    changes = context.params.get("changes")
    lola.load_scenario(scenario or "stand", changes or [])


@pytest.mark.parametrize("page", PAGES)
def test_every_section_with_a_measured_number_is_claimed(page):
    claimed = {claim.where.partition("#")[2] for claim in CLAIMS if claim.where.startswith(page)}
    measured = {anchor for anchor, text in sections(page).items() if MEASURED.search(text)}
    assert measured <= claimed, "CLAIMS.md wants a line for each of these sections"


def test_a_claim_without_test_or_command_shows_nothing():
    assert all(claim.tests or claim.commands for claim in CLAIMS)
    assert all(re.fullmatch(r"each run|20\d\d-\d\d-\d\d", claim.measured) for claim in CLAIMS)
    assert all(claim.tests or claim.measured != "each run" for claim in CLAIMS)


def percent(value):
    """Return a change as the pages write it."""
    rounded = round(value)
    return f"{'−' if value < 0 else '+'}{abs(rounded)}"


def falls(record):
    return ", ".join(f"{variant} {n}" for variant, n in record["falls"].items())


def test_the_table_of_the_experiments_is_their_record():
    table = sections("docs/experiments.md")["in-100-worlds"]
    rows = [row for row in table.splitlines() if "&#124;" in row or "| RMS" in row]
    assert len(rows) == len(NAMES) * len(METRICS)
    for row, (name, (metric, axis)) in zip(
        rows, [(name, place) for name in NAMES for place in METRICS], strict=True
    ):
        record = RECORD[name]
        said = [cell.strip() for cell in row.strip("| ").split(" | ")]
        median, quartiles, interval = (
            record[key][metric][axis]
            for key in ("median_change_percent", "quartiles", "interval_95")
        )
        here = f"{percent(median)} % ({percent(quartiles[0])} … {percent(quartiles[1])})"
        assert here in row, (name, metric, axis)
        assert " … ".join(map(percent, interval)) in said, (name, metric, axis)
        paper = record["paper"].get(metric, {}).get(axis)
        assert ("–" if paper is None else f"{percent(paper)} %") in said
        if (metric, axis) == METRICS[0]:
            assert falls(record) in row


def test_the_table_of_a_thousand_worlds_is_its_record():
    section = text_of("docs/experiments.md").split("\n## In 1000 worlds\n")[1].split("\n## ")[0]
    rows = [row.strip("| ").split(" | ") for row in section.splitlines() if row.startswith("| `")]
    found = {(row[0].strip("`"), row[1]): row[2:] for row in rows}
    record = json.loads(text_of("docs/experiments/thousand_worlds.json"))["scenarios"]
    wanted = {}
    for name, scenario in record.items():
        for variant, said in scenario["variants"].items():
            metric = said["metric"]
            low, high = metric["interval_95"]
            inclined = f"{metric['median']:.2f}° ({low:.2f} … {high:.2f})"
            wanted[name, variant] = [str(scenario["worlds"]), str(said["falls"]), inclined]
            assert said["failures"] == 0
    assert found == wanted
    change = record["step_down"]["change_percent"]
    low, high = map(percent, change["quartiles"])
    assert f"{percent(change['median'])} % in the median of the 1000 pairs" in section
    assert f"(quartiles {low} … {high})" in section


def test_the_table_of_engines_is_its_records():
    records = {"Drake": recorded("reproduction_20"), "MuJoCo": MUJOCO}
    table = sections("docs/experiments.md")["in-another-engine"].splitlines()
    rows = [row for row in table if re.match(r"\|.*\| (Drake|MuJoCo) \|", row)]
    wanted = [(name, engine) for name in NAMES for engine in records]
    changes = {}
    for row, (name, engine) in zip(rows, wanted, strict=True):
        record = records[engine][name]
        assert record["worlds"] == 20
        median = record["median_change_percent"]
        changes[name, engine] = [median[metric][axis] for metric, axis in METRICS]
        cells = [cell.strip() for cell in row.split("|")]
        fallen = falls(record)
        assert cells[2:-1] == [engine, *(f"{percent(c)} %" for c in changes[name, engine]), fallen]
    for name in NAMES:
        for one, other in zip(changes[name, "Drake"], changes[name, "MuJoCo"], strict=True):
            assert one * other > 0 and abs(one - other) < 4.0


def test_the_readme_has_the_figures_of_the_records():
    table = text_of("README.md").split("\n## The paper's experiments\n")[1].split("\n## ")[0]
    rows = [[cell.strip() for cell in row.split(" | ")[1:]] for row in table.splitlines()]
    rows = [row for row in rows if len(row) == 4]
    wanted = []
    for drake, mujoco in ((RECORD[name], MUJOCO[name]) for name in NAMES):
        for metric, axis in METRICS[1:]:  # of the inclinations only that about y
            here, there = (r["median_change_percent"][metric][axis] for r in (drake, mujoco))
            interval = " … ".join(map(percent, drake["interval_95"][metric][axis]))
            paper = drake["paper"].get(metric, {}).get(axis)
            said = "–" if paper is None else f"{percent(paper)} %"
            wanted.append([said, f"{percent(here)} % ({interval})", f"{percent(there)} %"])
        wanted.append(["–", falls(drake), falls(mujoco)])
    assert [[*row[1:3], row[3].rstrip(" |")] for row in rows] == wanted


def test_the_readme_has_no_figure_of_its_own():
    """Each figure of its limitations is one of the page that it leads to."""
    said, page = (
        re.findall(r"\d+(?:\.\d+)?(?: (?:%|cm|times|of \d+))", sections(name)["limitations"])
        for name in ("README.md", "docs/limitations.md")
    )
    assert len(said) >= 5 and set(said) <= set(page)


@pytest.mark.parametrize("page", ["README.md", "docs/tutorials/paper.md"])
def test_the_first_screen_says_what_the_record_says(page):
    table = "\n".join(line for line in text_of(page).splitlines() if line.startswith("|"))
    changes = {name: RECORD[name]["median_change_percent"] for name in NAMES}
    board = {
        name: ", ".join(f"{percent(changes[name]['rms_torque_error_Nm'][a])} %" for a in "xy")
        for name in ("board_9cm", "board_4cm")
    }
    pitch = f"{percent(changes['step_down']['max_inclination_deg']['y'])} %"
    for paper, here in (
        ("−63 %", pitch),
        ("−21 %, −31 %", board["board_9cm"]),
        ("−3 %, −9 %", board["board_4cm"]),
    ):
        assert f"| {paper} | {here} |" in table


def test_the_record_of_the_gains_has_all_trials():
    record = json.loads(text_of("docs/experiments/tuning.json"))
    assert len(record["trials"]) == 40


def test_the_table_of_gains_has_the_defaults():
    scenario, checked = lola.load_scenario("stand"), 0
    for row in (
        text_of("docs/howto/tuning.md")
        .split("\n## What they are\n")[1]
        .split("\n## ")[0]
        .splitlines()
    ):
        names, said = re.findall(r"`([\w.]+)`", row.partition(" | ")[0]), row.split(" | ")[1:2]
        if not (row.startswith("|") and names) or row.startswith("| U,"):
            continue
        values = re.findall(r"(-?[\d.]+)(?: (\S+?))?(?:,|$)", said[0])
        assert len(values) == len(names)
        section = names[0].rpartition(".")[0]
        for name, (value, unit) in zip(names, values, strict=True):
            at = scenario
            for part in (name if "." in name else f"{section}.{name}").split("."):
                at = getattr(at, part)
            assert at == pytest.approx(float(value) * (0.01 if unit == "cm" else 1.0)), name
            checked += 1
    assert checked >= 10


def test_tests_of_claims_are_run_and_told():
    right = "tests/theory/test_noise.py"
    single = "tests/theory/test_contact_model.py::test_springs_in_series_are_softer_than_either"
    outcome = run_tests([Claim("", "", (right, single, "tests/test_nothing.py"), (), "")])
    assert outcome == {right: False, single: False, "tests/test_nothing.py": False}
    assert run_tests([Claim("", "", (right, single), (), "")]) == {right: True, single: True}


def test_the_command_says_what_does_not_hold(monkeypatch):
    chosen = [
        Claim("a", "holds", ("tests/a.py",), (), "each run"),
        Claim("b", "does not", ("tests/a.py", "tests/b.py"), ("lola list",), "2026-01-01"),
        Claim("c", "by hand", (), ("lola bench",), "2026-01-01"),
    ]
    monkeypatch.setattr(claims_module, "claims", lambda: chosen)
    monkeypatch.setattr(
        claims_module, "run_tests", lambda _: {"tests/a.py": True, "tests/b.py": False}
    )
    done = CliRunner().invoke(app, ["claims", "--json"])
    assert json.loads(done.stdout) == {"holds": True, "does not": False, "by hand": None}
    assert done.exit_code == 1
    assert "lola bench" in CliRunner().invoke(app, ["claims"]).stdout


def test_without_a_checkout_there_are_no_claims(monkeypatch, tmp_path):
    monkeypatch.setattr(claims_module, "CHECKOUT", tmp_path)
    with pytest.raises(LolaError, match="needs a checkout"):
        claims()
