"""The short form of the fuzzing and of the kills; the long ones are `fuzz.py` and `kills.py`."""

import shutil
import signal

import fuzz
import fuzz_frames
import fuzz_records
import numpy as np
import pytest
from kills import kill
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.simulation import simulate


@pytest.mark.parametrize("seed", range(40))
def test_a_bad_scenario_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, seed):
    monkeypatch.chdir(tmp_path)
    key, text = fuzz.bad_scenario(np.random.default_rng(seed))
    (tmp_path / "my.yaml").write_text(text, encoding="utf-8")
    assert fuzz.complaint(CliRunner().invoke(app, ["simulate", "my.yaml"]), key) == ""
    assert [path.name for path in tmp_path.iterdir()] == ["my.yaml"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(2))
def test_a_valid_scenario_ends_with_finite_numbers(seed):
    result = simulate(fuzz.valid_scenario(np.random.default_rng(seed)))
    assert result.completed or result.fall_time is not None, result.end
    assert np.isfinite(fuzz.numbers(result.summary)).all()


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    return fuzz_records.make_records(tmp_path_factory.mktemp("records"))


@pytest.mark.parametrize("seed", range(16))
def test_a_damaged_record_is_read_or_refused_in_one_line(records, tmp_path, seed):
    shutil.copytree(records[int(seed % 4 == 0)], tmp_path / "run")
    what = fuzz_records.damage(tmp_path / "run", np.random.default_rng(seed))
    uses = {3: 1, 6: 2}.get(seed, 0)
    assert fuzz_records.tried(tmp_path / "run", uses) == "", what


def test_no_frame_ends_a_simulation(capsys):
    assert fuzz_frames.try_frames(60) == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "number", "after"),
    [
        ("simulate", signal.SIGINT, 0.3),
        ("simulate", signal.SIGTERM, 1.5),
        ("simulate", signal.SIGKILL, 2.5),
        ("simulate", signal.SIGINT, 3.5),
        ("force", signal.SIGKILL, 2.5),
        ("compare", signal.SIGINT, 1.0),
        ("compare", signal.SIGTERM, 4.0),
        ("compare", signal.SIGKILL, 5.0),
    ],
)
def test_what_a_killed_command_leaves_says_what_it_is(tmp_path, name, number, after):
    assert kill(name, number, after, tmp_path) == []
