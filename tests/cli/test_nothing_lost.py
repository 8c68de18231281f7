"""What is recorded is on the disk before anything can go wrong with what is made of it."""

import errno
import sys
import types
from pathlib import Path

import pytest
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.errors import OutputError
from lola_drake.results import load_result


def one_line(done, code):
    assert done.exit_code == code, done.output
    (line,) = (line for line in done.stderr.splitlines() if line.startswith("lola: "))
    assert "Traceback" not in done.stderr
    return line


@pytest.fixture(autouse=True)
def figures(monkeypatch):
    """Count comparisons' figures in place of drawing them; return what is to be raised."""
    errors = []

    def draw(*_):
        if errors:
            raise errors[0]

    monkeypatch.setattr("lola_drake.studies.variants.save_figure", draw)
    monkeypatch.setattr("lola_drake.studies.variants.variants_figure", draw)
    return errors


@pytest.fixture
def bad_pictures(monkeypatch):
    """Return a function that lets all pictures of a run fail with an error."""

    def fail_with(error):
        def write_pictures(result, folder):
            raise error

        module = types.SimpleNamespace(write_pictures=write_pictures)
        monkeypatch.setitem(sys.modules, "lola_drake.reports.run_report", module)

    return fail_with


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (TypeError("no\nsuch axes"), "TypeError: no such axes; what was recorded is kept in"),
        (OutputError("x.svg: cannot be written"), "lola: x.svg: cannot be written; what was"),
    ],
)
def test_a_picture_that_fails_takes_no_run_along(lola, bad_pictures, error, message):
    bad_pictures(error)
    line = one_line(lola("simulate", "stand"), 2)
    assert message in line and line.endswith("kept in runs/stand")
    assert load_result("runs/stand").completed


def test_a_run_that_failed_is_kept_and_said(lola):
    lola.outcome.update(completed=False, error="the solver gave up")
    line = one_line(lola("simulate", "stand"), 1)
    assert "failed at" in line and "the solver gave up; what was recorded is kept in" in line
    assert load_result("runs/stand").error == "the solver gave up"


def test_where_the_disk_is_full_a_run_says_so_and_leaves_nothing(lola, monkeypatch, tmp_path):
    write = Path.write_text

    def full(path, *arguments, **options):
        if "runs" in path.parts:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, *arguments, **options)

    monkeypatch.setattr(Path, "write_text", full)
    line = one_line(lola("simulate", "stand"), 2)
    assert line.endswith("runs/stand: cannot be written, No space left on device")
    assert not list((tmp_path / "runs").iterdir())


def test_a_comparison_keeps_its_runs_whatever_becomes_of_its_figure(lola, figures):
    figures.append(ValueError("too few colours"))
    line = one_line(lola("compare", "stand", "--jobs", "1"), 2)
    assert line.endswith(
        "ValueError: too few colours; what was recorded is kept in runs/compare_stand"
    )
    assert [load_result(f"runs/compare_stand/{v}").completed for v in ("ref", "dyn")] == [True] * 2
    figures.clear()
    assert lola("compare", "stand", "--jobs", "1", "--force", "--no-pictures").exit_code == 0


COMPARE = ("compare", "stand", "--jobs", "1", "--no-pictures")


@pytest.mark.parametrize("variants", ["ref,dyn", "ref, dyn", " ref ,dyn "])
def test_variants_may_stand_apart(lola, variants):
    assert lola(*COMPARE, "--variants", variants).exit_code == 0


def test_a_comparison_that_is_stopped_is_kept(lola):
    lola.outcome.update(completed=False)
    assert lola("compare", "stand", "--jobs", "1", "--seed", "7").exit_code == 130
    assert load_result("runs/compare_stand/ref").scenario.seed == 7


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["report", "run"], "report.html"),
        (["report", "run", "-o", "a.html", "--video", "film.webp"], "film.webp"),
        (["export", "run", "--mcap"], "run/signals.mcap"),
        (["bench"], "bench.json"),
        (["diagram"], "simulation.svg"),
        (["diagram", "--all", "-o", "d"], "d/README.md"),
    ],
)
def test_nothing_is_replaced_without_force(lola, make_result, monkeypatch, arguments, name):
    module = sys.modules["lola_drake.reports.run_report"]
    module.write_report = None
    sys.modules["lola_drake.simulation"].build_simulation = None
    monkeypatch.setitem(sys.modules, "lola_drake.view3d.video", types.SimpleNamespace(save_video=0))
    drawing = dict.fromkeys(("block_diagram", "save_diagram", "write_all"))
    stand_in = types.SimpleNamespace(**drawing)
    monkeypatch.setitem(sys.modules, "lola_drake.diagram.block_diagram", stand_in)
    for bench in ("bench", "bench_tables"):
        names = {"bench": None, "bench_table": None, "mujoco_tables": None, "scaling_table": None}
        stand_in = types.SimpleNamespace(**names)
        monkeypatch.setitem(sys.modules, f"lola_drake.benchmarks.{bench}", stand_in)
    make_result(steps=0).save("run")
    Path(name).parent.mkdir(exist_ok=True)
    Path(name).write_text("mine")
    assert f"{name}: is there already" in one_line(lola(*arguments), 2)
    assert Path(name).read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["linearize", "contact", "-o", "l"], "l/contact.png"),
        (["map", "gains", "-o", "l"], "l/map_gains.svg"),
        (["poincare", "my.yaml", "-o", "l"], "l/poincare_my.svg"),
    ],
)
def test_no_linear_picture_is_replaced_without_force(monkeypatch, tmp_path, arguments, name):
    monkeypatch.chdir(tmp_path)
    Path("my.yaml").write_text("duration: 1")
    Path("l").mkdir()
    Path(name).write_text("mine")
    assert f"{name}: is there already" in one_line(CliRunner().invoke(app, arguments), 2)
    assert Path(name).read_text() == "mine"
