"""compare, reproduce and tune, with a stand-in for the simulation."""

import json
import sys
import types

import numpy as np
import pytest
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.interruption import HEARD
from lola_drake.reports import run_report
from lola_drake.results import load_result
from lola_drake.studies import tuning
from lola_drake.workers import inline


@pytest.fixture
def lola(make_result, monkeypatch, tmp_path):
    """Return a function that runs the command in an empty folder; `dyn` inclines half as much."""
    monkeypatch.chdir(tmp_path)
    runs = []

    def simulate(scenario, folder=None):
        runs.append(scenario)
        heights = [obstacle.height for obstacle in scenario.ground.obstacles]
        fell = scenario.variant == "ref" and 0.085 in heights
        fall = {"completed": False, "fall_time": 1.5} if fell else {}
        result = make_result(scenario, steps=2, **fall)
        inclination = np.radians(1.0 if scenario.variant == "dyn" else 2.0)
        result.signals["torso_pose"][1200:1400, 3:5] = inclination
        if folder is not None:
            result.save(folder)
        return result

    # The pages have tests of their own, and need the whole simulation for their diagram.
    monkeypatch.setattr(run_report, "report_page", lambda *given: "a page")
    monkeypatch.setattr(run_report, "packed_replay", lambda *results: "a replay")
    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)
    monkeypatch.setattr("lola_drake.workers.Processes", lambda jobs: inline)

    def run(*arguments):
        return CliRunner().invoke(app, [*arguments, "--jobs", "1"])

    run.runs = runs
    return run


def test_compare_writes_runs_numbers_figure_and_report(lola, tmp_path):
    done = lola("compare", "step_down")
    assert done.exit_code == 0, done.output
    folder = tmp_path / "runs" / "compare_step_down"
    assert {path.name for path in folder.iterdir()} == {
        "compare.json",
        "comparison.svg",
        "comparison.png",
        "report.html",
        "ref",
        "dyn",
    }
    content = json.loads((folder / "compare.json").read_text())
    assert content["change_percent"]["max_inclination_deg"] == pytest.approx({"x": -50, "y": -50})
    assert load_result(folder / "dyn").scenario.variant == "dyn"
    assert "-50.0" in done.stdout and "steps at the limit of friction" in done.stdout


def test_compare_without_pictures_writes_no_report(lola, tmp_path):
    assert lola("compare", "step_down", "--no-pictures").exit_code == 0
    assert not (tmp_path / "runs" / "compare_step_down" / "report.html").exists()


def test_compare_takes_variants_and_changes(lola):
    done = lola(
        "compare", "step_down", "--variants", "original,ref,dyn", "--set", "seed=5", "--json"
    )
    content = json.loads(done.stdout)
    assert list(content["variants"]) == ["original", "ref", "dyn"]
    assert content["change_percent"]["max_inclination_deg"] == pytest.approx({"x": 0, "y": 0})
    assert {run.seed for run in lola.runs} == {5}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stp_down"], "did you mean step_down?"),
        (["step_down", "--variants", "ref,best"], "variant: 'best' is not allowed"),
        (["step_down", "--variants", "ref"], "at least two, all different"),
        (["step_down", "--variants", "ref,ref"], "at least two, all different"),
    ],
)
def test_bad_input_is_one_line_and_code_2(lola, tmp_path, arguments, message):
    done = lola("compare", *arguments)
    assert done.exit_code == 2
    assert message in done.stderr and done.stderr.count("\n") == 1
    assert not lola.runs and not list(tmp_path.iterdir())


def test_a_comparison_is_replaced_only_when_forced(lola, tmp_path):
    lola("compare", "step_down", "-o", "here")
    done = lola("compare", "step_down", "-o", "here")
    assert done.exit_code == 2 and "holds a comparison already" in done.stderr
    assert lola("compare", "step_down", "-o", "here", "--force").exit_code == 0
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("dear")
    done = lola("compare", "step_down", "-o", "other", "--force")
    assert done.exit_code == 2 and "something that is not a comparison" in done.stderr


def test_reproduce_goes_on_where_it_was(lola, tmp_path):
    first = lola("reproduce", "--samples", "1", "--json")
    count = len(lola.runs)
    second = lola("reproduce", "--samples", "2", "--json")
    assert (count, len(lola.runs)) == (8, 16)
    assert {e["worlds"] for e in json.loads(first.stdout)["experiments"].values()} == {1}
    content = json.loads(second.stdout)
    assert {e["worlds"] for e in content["experiments"].values()} == {2}
    folder = tmp_path / "runs" / "reproduction"
    assert json.loads((folder / "reproduction.json").read_text()) == content
    assert {"runs.sqlite", "reproduction.svg", "reproduction.png"} < {
        p.name for p in folder.iterdir()
    }
    assert content["experiments"]["step_down_8cm5"]["falls"] == {"ref": 2, "dyn": 0}


def test_reproduce_in_extended_worlds(lola):
    done = lola("reproduce", "--samples", "1", "--extended", "--json")
    experiments = json.loads(done.stdout)["experiments"]
    assert all(e["changes"]["worlds.extended"] for e in experiments.values())
    assert {run.worlds.extended for run in lola.runs} == {True}
    assert all(run.model_errors.servo_gain != 1.0 for run in lola.runs)


def test_reproduce_prints_paper_against_simulation(lola):
    done = lola("reproduce", "--samples", "2")
    assert done.exit_code == 0, done.output
    lines = [line for line in done.stdout.splitlines() if "max |φ_y|" in line]
    assert "-63" in lines[2] and "-50.0" in lines[2]
    assert "falls: ref 2 of 2, dyn 0 of 2" in done.stdout


def test_a_stopped_study_says_that_nothing_is_lost(lola, make_result, monkeypatch, tmp_path):
    whole, done = sys.modules["lola_drake.simulation"].simulate, []

    def simulate(scenario):
        done.append(scenario)
        if len(done) != 3:
            return whole(scenario)
        HEARD.set()
        return make_result(scenario, completed=False)

    monkeypatch.setattr(sys.modules["lola_drake.simulation"], "simulate", simulate)
    stopped = lola("reproduce")
    assert stopped.exit_code == 130
    assert stopped.stderr.splitlines()[-1].startswith("lola: stopped; what is done is kept in runs")
    assert not (tmp_path / "runs" / "reproduction" / "reproduction.json").exists()
    assert lola("reproduce").exit_code == 0
    assert len(done) == 3 + 6


def test_tune_writes_its_record(lola, tmp_path):
    done = lola("tune", "--samples", "2", "--budget", "3")
    assert done.exit_code == 0, done.output
    content = json.loads((tmp_path / "runs" / "tuning" / "tuning.json").read_text())
    assert len(content["trials"]) == 3 and content["seeds"] == [1000, 1001]
    assert len(lola.runs) == 3 * 2 * (len(tuning.SCENARIOS) + 1)
    assert {run.variant for run in lola.runs} == {"ref"}
    assert content["chosen"] == content["start"]
    assert "pattern.double_support (s)" in done.stdout


SPREAD = {"min": 1.0, "median": 2.0}
BENCH = {
    "scenario": "walk_flat",
    "repeats": 3,
    "engine": "fused",
    "closed_loop_over_plant": SPREAD,
    "plant_over_implicit": SPREAD,
    "real_time_factor": SPREAD,
    "tick_us": {
        "closed_loop": SPREAD,
        "plant": SPREAD,
        "plant_implicit": SPREAD,
        "own_part": SPREAD,
        "all_blocks": SPREAD,
        "blocks": {},
    },
    "plan_ms": {"new_plan": SPREAD, "phase_reset": SPREAD},
    "import_s": SPREAD,
    "build_s": SPREAD,
    "peak_memory_mb": 1.0,
}
SCALING = {
    "cost_60_s_over_10_s": SPREAD,
    "two_processes_over_one": SPREAD,
    "memory_mb": {"after_10_s": 170.0},
}


@pytest.fixture
def lola_bench(monkeypatch, tmp_path):
    """Return a function that runs `lola bench` in an empty folder, without measuring anything."""
    monkeypatch.chdir(tmp_path)
    measured = []

    def stand_in(name, result):
        def measure(repeats, progress, engine="fused"):
            measured.append((name, repeats))
            return dict(result)

        monkeypatch.setattr(f"lola_drake.benchmarks.{name}.{name}", measure)

    def run(*arguments):
        return CliRunner().invoke(app, ["bench", *arguments])

    stand_in("bench", BENCH)
    stand_in("bench_scaling", SCALING)
    run.measured = measured
    return run


def test_bench_measures_what_is_asked_for(lola_bench, tmp_path):
    done = lola_bench("--repeats", "3")
    assert done.exit_code == 0, done.output
    assert lola_bench.measured == [("bench", 3)]
    assert json.loads((tmp_path / "bench.json").read_text()) == BENCH
    done = lola_bench("--scaling", "--json", "-o", "b.json")
    assert json.loads(done.stdout) == BENCH | {"scaling": SCALING}
    assert lola_bench.measured[1:] == [("bench", 5), ("bench_scaling", 5)]


def test_bench_shows_how_long_runs_scale(lola_bench):
    done = lola_bench("--scaling")
    assert "two processes / one" in done.stdout and "170" in done.stdout


def test_bench_says_which_package_is_missing_before_it_measures(lola_bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for name in ("benchmarks.bench_mujoco", "benchmarks.mujoco_twin", "mujoco_model"):
        monkeypatch.delitem(sys.modules, f"lola_drake.{name}", raising=False)
    done = lola_bench("--vs-mujoco")
    assert done.exit_code == 2 and not lola_bench.measured
    assert done.stderr == "lola: MuJoCo needs a package: pip install 'lola_drake[bench]'\n"


def test_sweep_writes_table_figure_and_content(lola, tmp_path):
    vary = ("--vary", "ground.obstacles.0.height=0.055,0.085")
    done = lola("sweep", "step_down", *vary, "--worlds", "2")
    assert done.exit_code == 0, done.output
    folder = tmp_path / "runs" / "sweep_step_down"
    assert {path.name for path in folder.iterdir()} == {
        "runs.sqlite",
        "sweep.json",
        "sweep.svg",
        "sweep.png",
    }
    content = json.loads((folder / "sweep.json").read_text())
    low, high = content["points"]
    assert low["change_percent"]["median"] == pytest.approx(-50.0)
    assert high["variants"]["ref"]["falls"] == 2 and high["variants"]["dyn"]["falls"] == 0
    assert "lola study replay runs/sweep_step_down/runs.sqlite" in done.stdout
    before = len(lola.runs)
    assert json.loads(lola("sweep", "step_down", *vary, "--worlds", "3", "--json").stdout)
    assert len(lola.runs) == before + 4


def test_a_sweep_that_cannot_be_is_one_line_before_anything_runs(lola, tmp_path):
    for arguments, message in (
        (["--vary", "ground.friction=0.5:0.9:4000", "--vary", "duration=1:9:3000"], "12,000,000"),
        (["--vary", "ground.frction=1,2"], "no such key"),
        (["--vary", "ground.friction=-1,1"], "the point ground.friction=-1"),
        (["--vary", "ground.friction=0.7,0.8", "--worlds", "2"], "makes no difference here"),
        (["--vary", "duration=2,3", "--until", "no"], "'no' is not allowed"),
        (["--vary", "duration=2,3", "--variants", "ref,best"], "'best'"),
    ):
        done = lola("sweep", "step_down", *arguments)
        assert done.exit_code == 2 and message in done.stderr and done.stderr.count("\n") == 1
    assert not lola.runs and not list(tmp_path.iterdir())
