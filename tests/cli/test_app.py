"""The `lola` command, with a stand-in for the simulation."""

import json
import re
import subprocess
import sys
import threading

import pytest
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.cli.common import progress_bar
from lola_drake.results import load_result


def test_list_has_one_line_for_each_scenario(lola):
    lines = lola("list").stdout.splitlines()
    scenarios = json.loads(lola("list", "--json").stdout)
    assert [line.split()[0] for line in lines] == list(scenarios)
    assert all(line.endswith(scenarios[line.split()[0]]) for line in lines)


def test_list_does_not_wait_for_drake():
    code = (
        "import sys\nfrom lola_drake.cli.app import app\n"
        "app(['list'], standalone_mode=False)\nassert 'pydrake' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_simulate_writes_a_run_and_says_where(lola, tmp_path):
    done = lola("simulate", "stand")
    assert done.exit_code == 0
    assert done.stdout.endswith("written to runs/stand\n")
    assert "max_inclination_deg" in done.stdout
    assert load_result(tmp_path / "runs" / "stand").scenario.name == "stand"


def test_pictures_are_drawn_unless_unwanted(lola):
    lola("simulate", "stand")
    lola("simulate", "stand", "-o", "plain", "--no-pictures")
    assert [str(folder) for folder in lola.drawn] == ["runs/stand"]


def test_options_change_the_scenario(lola):
    done = lola(
        *("simulate", "stand", "--set", "duration=2", "--set", "control.com_dynamics.gain=0.5"),
        *("--seed", "9", "--variant", "ref", "-o", "here"),
    )
    assert done.exit_code == 0
    (scenario,) = lola.runs
    assert (scenario.duration, scenario.seed, scenario.variant) == (2.0, 9, "ref")
    assert scenario.control.com_dynamics.gain == 0.5
    assert load_result("here").scenario == scenario


def test_json_is_alone_on_stdout(lola, tmp_path):
    done = lola("simulate", "stand", "--json")
    saved = (tmp_path / "runs" / "stand" / "summary.json").read_text()
    assert json.loads(done.stdout) == json.loads(saved)


def test_quiet_says_nothing(lola):
    done = lola("simulate", "stand", "--quiet")
    assert (done.exit_code, done.output) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stnd"], "lola: stnd: no such scenario, did you mean stand?"),
        (["gone.yaml"], "lola: gone.yaml: No such file or directory"),
        (["stand", "--set", "sed=1"], "lola: override of stand: sed: no such key, did you mean"),
        (["stand", "--set", "seed=x"], "lola: override of stand: seed: 'x' is not allowed"),
        (["stand", "--variant", "best"], "lola: override of stand: variant: 'best' is not"),
        (["stand", "--seed", "-1"], "lola: override of stand: seed: -1 is not allowed"),
    ],
)
def test_bad_input_is_one_line_and_code_2(lola, tmp_path, arguments, message):
    done = lola("simulate", *arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith(message) and done.stderr.count("\n") == 1
    assert not done.stdout and not lola.runs and not list(tmp_path.iterdir())


def test_an_existing_run_is_noticed_before_simulating(lola):
    lola("simulate", "stand", "--seed", "1")
    done = lola("simulate", "stand", "--seed", "2")
    assert done.exit_code == 2 and "holds a run already" in done.stderr
    assert done.stderr.count("\n") == 1 and len(lola.runs) == 1
    assert lola("simulate", "stand", "--seed", "3", "--force").exit_code == 0
    assert load_result("runs/stand").scenario.seed == 3


def test_a_fall_is_a_result(lola):
    lola.outcome.update(completed=False, fall_time=3.0)
    done = lola("simulate", "stand", "--json")
    assert done.exit_code == 0
    assert json.loads(done.stdout)["fell"] is True


def test_an_interrupted_run_is_saved(lola):
    lola.outcome.update(completed=False)
    done = lola("simulate", "stand")
    assert done.exit_code == 130
    assert not load_result("runs/stand").completed


@pytest.mark.parametrize("thread", [True, False])
def test_a_progress_bar_has_a_thread_only_where_it_should(thread):
    before = set(threading.enumerate())
    with progress_bar("walk", 2.0, thread=thread) as advance:
        advance(1.0)
        assert len(set(threading.enumerate()) - before) == thread


def test_the_version_is_that_of_the_package(lola):
    done = lola("--version")
    assert (done.exit_code, done.stderr) == (0, "")
    assert re.fullmatch(r"lola_drake(, not installed| \d+\.\d+.*)\n", done.stdout)


def test_there_is_completion_for_shells(lola):
    assert {"--install-completion", "--show-completion"} <= set(lola("--help").stdout.split())


def test_the_seed_of_a_comparison_is_that_of_its_runs(lola):
    assert lola("compare", "stand", "--jobs", "1", "--no-pictures", "--seed", "11").exit_code == 0
    assert [load_result(f"runs/compare_stand/{v}").scenario.seed for v in ("ref", "dyn")] == [
        11
    ] * 2


def test_a_diagram_is_that_of_a_changed_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["diagram", "--set", "control.law=two_dof", "--depth", "2"])
    assert done.exit_code == 0 and "TwoDof" in (tmp_path / "simulation.svg").read_text()


SMALL = "lola: d.svg: on one sheet of A4 its names are "


@pytest.mark.parametrize(
    ("options", "code", "told"),
    [
        (["--depth", "9"], 2, ["lola: depth 9: lola has no more than 2 to open"]),
        (["--depth", "2", "--system", "plant"], 2, ["lola: depth 2: plant has no more than 0 to "]),
        (["--depth", "2"], 0, [SMALL]),
        (["--system", "plant"], 0, []),
    ],
)
def test_a_diagram_says_when_there_are_no_more_levels_and_when_its_names_are_small(
    tmp_path, monkeypatch, options, code, told
):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["diagram", "stand", "-o", "d.svg", *options])
    assert done.exit_code == code and done.stdout == ("" if code else "d.svg\n")
    assert [path.name for path in tmp_path.iterdir()] == ([] if code else ["d.svg"])
    lines = done.stderr.splitlines()
    assert len(lines) == len(told) and all(map(str.startswith, lines, told)), lines
