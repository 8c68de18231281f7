"""Records that are on the disk while a run goes on: the same as in memory, whatever ends it."""

import json
import resource
import signal
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from fuzz_records import make_records

import lola_drake as lola
from lola_drake import metrics, record
from lola_drake.atomic_file import growing_folder
from lola_drake.record import ROWS, RecordedSignals, open_signals
from lola_drake.results import UNFINISHED, load_result
from lola_drake.scenario import Scenario, load_scenario, override
from lola_drake.simulation import simulate, start
from lola_drake.view3d.live import push

SHORT = Scenario(duration=1.1)
"""More than is written at a time."""


def same_signals(one, other):
    np.testing.assert_array_equal(one.times, other.times)
    for name, values in one.signals.items():
        np.testing.assert_array_equal(values, other.signals[name])


@pytest.fixture(scope="module")
def in_memory():
    return simulate(SHORT)


def test_a_record_on_the_disk_is_that_in_memory(in_memory, tmp_path):
    seen = []

    def look(now):
        if now > 1.05 and not seen:
            seen.append(sorted(path.name for path in tmp_path.iterdir()))

    result = simulate(SHORT, look, folder=tmp_path / "run")
    assert seen == [["run.part"]]
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert {p.name for p in (tmp_path / "run").iterdir()} == {
        "scenario.yaml",
        "signals.h5",
        "summary.json",
    }
    for read in (result, load_result(tmp_path / "run")):
        assert read.completed and read.engine == "fused" and read.metrics == in_memory.metrics
        same_signals(in_memory, read)


def test_what_is_on_the_disk_is_not_in_memory_any_more(tmp_path):
    run = start(SHORT)
    log = run.diagram.GetSubsystemByName("log")
    left = []

    class Recorder:
        def append(self, times, signals):
            left.append((len(times), len(signals["torso_pose"])))

    for until in (0.5, 1.01, 1.05):
        run.advance(until)
        run.write(Recorder())
        left.append(log.FindLog(run.context).num_samples() // 10)
    assert left == [50, (ROWS, ROWS), 0, 4]


def test_where_a_drive_reaches_its_limit_no_sample_is_lost_or_doubled(tmp_path):
    """From there on the run goes on in another diagram with another log."""
    stand = override(load_scenario("stand"), {"duration": 1.3})
    diagrams = set()

    def attend(run):
        if run.time > 0.9 and len(diagrams) == 1:
            push(run, np.array([0.0, 120.0]))
        diagrams.add(id(run.diagram))
        return 0.013

    result = simulate(stand, attend=attend, folder=tmp_path / "run")
    assert len(diagrams) == 2 and result.duration > 1.0
    np.testing.assert_allclose(np.diff(result.times), 1e-3, rtol=1e-9)
    diagrams.clear()
    same_signals(simulate(stand, attend=attend), result)


@pytest.mark.parametrize("samples", [0, 999, ROWS, ROWS + 1, 6800])
def test_metrics_are_the_same_in_any_pieces(make_result, tmp_path, monkeypatch, samples):
    whole = make_result(steps=6)
    rng = np.random.default_rng(1)
    signals = {n: v[:samples] + rng.standard_normal((samples, 1)) for n, v in whole.signals.items()}
    signals["gait_phase"] = whole.signals["gait_phase"][:samples]
    result = type(whole)(whole.scenario, whole.times[:samples], signals, False, None, 1.0)
    expected = result.metrics
    monkeypatch.setattr(metrics, "BLOCK", 700)
    assert load_result(result.save(tmp_path / "run")).metrics == expected


def test_a_part_of_the_rows_is_read_alone(make_result, tmp_path):
    result = make_result(steps=1)
    result.signals["torso_pose"][:] = np.arange(len(result.times))[:, None]
    signals = load_result(result.save(tmp_path / "run")).signals
    assert isinstance(signals, RecordedSignals) and len(dict(signals)) == len(signals)
    assert signals.between(5, 9).between(1, 100)["torso_pose"][:, 2].tolist() == [6, 7, 8]
    with pytest.raises(KeyError):
        signals["torso"]


def test_a_record_that_is_taken_away_is_one_line(make_result, tmp_path):
    result = load_result(make_result(steps=0).save(tmp_path / "run"))
    (tmp_path / "run" / "signals.h5").unlink()
    with pytest.raises(lola.ResultError, match=r"signals.h5: .*No such file"):
        result.signals["torso_pose"]


KILLED = """
import os, signal, sys
from lola_drake.scenario import Scenario, override
from lola_drake.simulation import simulate
def progress(now):
    if now > 2.1:
        os.kill(os.getpid(), signal.SIGKILL)
simulate(Scenario(duration=5.0), progress, folder=sys.argv[1])
"""


def test_a_killed_run_leaves_a_record_that_says_what_it_is(tmp_path):
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "run")])
    assert done.returncode == -signal.SIGKILL
    assert [path.name for path in tmp_path.iterdir()] == ["run.part"]
    result = load_result(tmp_path / "run.part")
    assert result.times[-1] == pytest.approx(1.999) and result.error == UNFINISHED
    assert not result.completed and not result.interrupted
    assert json.loads((tmp_path / "run.part" / "summary.json").read_text())["error"] == UNFINISHED
    assert len(result.signals["torso_pose"]) == 2 * ROWS
    assert np.ptp(result.signals["torso_pose"][:, 2]) < 0.01
    # The next run does not touch it.
    again = simulate(Scenario(duration=0.01), folder=tmp_path / "run")
    assert again.completed and load_result(tmp_path / "run.part").error == UNFINISHED


def test_a_killed_runs_damaged_record_does_not_keep_hdf5_for_ever(tmp_path, monkeypatch):
    """One byte of HDF5's own data is enough; no such wait can be ended from Python."""
    _, folder = make_records(tmp_path)
    assert len(load_result(folder).times) == 1100
    data = bytearray((folder / "signals.h5").read_bytes())
    data[data.index(b"OHDR", 1000) + 20] ^= 1
    (folder / "signals.h5").write_bytes(data)
    monkeypatch.setattr(record, "PATIENCE", 3.0)
    with pytest.raises(lola.ResultError, match="signals.h5 is damaged, HDF5 finds no end in it$"):
        load_result(folder)


def test_a_killed_runs_record_is_looked_through_once(tmp_path, monkeypatch):
    _, folder = make_records(tmp_path)
    looked = []
    run = subprocess.run
    monkeypatch.setattr(subprocess, "run", lambda *a, **k: looked.append(a) or run(*a, **k))
    signals = load_result(folder).signals
    assert signals["torso_pose"].any() and signals["joint_torque"].any() and len(looked) == 1


def test_a_killed_runs_record_that_is_cut_off_is_one_line(tmp_path):
    _, folder = make_records(tmp_path)
    data = (folder / "signals.h5").read_bytes()
    (folder / "signals.h5").write_bytes(data[:1500])
    with pytest.raises(lola.ResultError, match="cannot be read, ") as caught:
        load_result(folder)
    assert "\n" not in str(caught.value)


@contextmanager
def room(size):
    """No file gets larger than so many bytes, as on a disk that is full."""
    unlimited = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, unlimited[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, unlimited)


def test_a_disk_that_gets_full_ends_a_run_with_what_is_recorded(tmp_path):
    with room(4_500_000):
        result = simulate(Scenario(duration=3.0), folder=tmp_path / "run")
    assert result.error == "the record cannot be written, File too large"
    kept = load_result(tmp_path / "run")
    assert kept.error == result.error and not kept.completed
    assert len(kept.times) == len(kept.signals["joint_torque"]) == ROWS
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_disk_that_is_full_from_the_start_is_said_before_anything_runs(tmp_path):
    def never(now):
        raise AssertionError

    with room(100_000), pytest.raises(lola.ResultError, match="cannot be written, File too large$"):
        simulate(SHORT, never, folder=tmp_path / "run")
    assert not list(tmp_path.iterdir())


def test_two_runs_into_one_folder_are_both_kept(tmp_path, make_result):
    def meanwhile(now):
        if now < 0.03:
            make_result(Scenario(seed=5), steps=0).save(tmp_path / "run")

    with pytest.raises(lola.ResultError, match=r"holds a run already.*kept in .*run.part$"):
        simulate(Scenario(duration=0.05), meanwhile, folder=tmp_path / "run")
    assert load_result(tmp_path / "run").scenario.seed == 5
    assert load_result(tmp_path / "run.part").completed


def test_a_record_is_replaced_only_by_force_and_at_the_end(tmp_path, make_result):
    make_result(Scenario(seed=5), steps=0).save(tmp_path / "run")
    with pytest.raises(lola.ResultError, match="holds a run already"):
        simulate(SHORT, folder=tmp_path / "run")
    seen = []

    def look(now):
        seen.append(load_result(tmp_path / "run").scenario.seed)

    simulate(Scenario(duration=0.03, seed=6), look, folder=tmp_path / "run", force=True)
    assert set(seen) == {5} and load_result(tmp_path / "run").scenario.seed == 6


def test_what_is_whole_is_kept_and_what_is_not_is_taken_away(tmp_path):
    for files, kept in (["a", "b"], True), (["a"], False):
        with (
            pytest.raises(ZeroDivisionError),
            growing_folder(tmp_path / "x", force=False, files={"a", "b"}) as part,
        ):
            for name in files:
                (part / name).write_text("")
            raise ZeroDivisionError
        assert part.exists() is kept


def test_a_record_is_readable_while_it_is_written(tmp_path):
    """By any other process, in the way of HDF5."""
    program = "import h5py, sys; print(len(h5py.File(sys.argv[1], 'r', swmr=True)['time']))"
    seen = []

    def look(now):
        if now > 1.05 and not seen:
            path = tmp_path / "run.part" / "signals.h5"
            seen.append(subprocess.check_output([sys.executable, "-c", program, str(path)]))

    simulate(SHORT, look, folder=tmp_path / "run")
    assert seen == [b"1000\n"]


def test_the_engine_is_in_the_summary(tmp_path):
    result = simulate(Scenario(duration=0.01), engine="diagram", folder=tmp_path / "run")
    assert result.summary["engine"] == load_result(tmp_path / "run").engine == "diagram"


def test_nothing_of_what_was_reserved_stays(make_result, tmp_path):
    path = make_result(steps=2).save(tmp_path / "run") / "signals.h5"
    with open_signals(path) as file:
        used = sum(file[name].id.get_storage_size() for name in file)
    assert used < path.stat().st_size < used + 100_000
