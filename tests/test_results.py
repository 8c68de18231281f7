"""The record of a run: summary, files, and what happens when saving fails."""

import dataclasses
import json
import resource

import h5py
import numpy as np
import pytest

from lola_drake.atomic_file import check_file
from lola_drake.errors import OutputError
from lola_drake.logged import LOGGED
from lola_drake.results import ResultError, check_folder, load_result
from lola_drake.scenario import Scenario, load_scenario

FIXED_NAMES = [
    "scenario",
    "variant",
    "seed",
    "duration_s",
    "completed",
    "fell",
    "fall_time_s",
    "distance_m",
    "mean_speed_m_per_s",
    "max_inclination_deg",
    "rms_torque_error_Nm",
    "rms_torque_error_modified_Nm",
    "max_foot_force_N",
    "wall_time_s",
    "real_time_factor",
    "versions",
]


def test_summary_has_the_names_that_stay(make_result):
    summary = make_result(Scenario(name="mine", seed=7, variant="ref")).summary
    assert set(FIXED_NAMES) <= set(summary)
    assert [summary[name] for name in FIXED_NAMES[:3]] == ["mine", "ref", 7]
    assert summary["duration_s"] == pytest.approx(6.8, abs=2e-3)
    assert summary["real_time_factor"] == pytest.approx(1.7, abs=1e-3)
    assert (summary["completed"], summary["fell"], summary["fall_time_s"]) == (True, False, None)
    assert summary["max_inclination_deg"].keys() == {"x", "y"}
    assert summary["rms_torque_error_Nm"].keys() == {"x", "y"}
    assert summary["rms_torque_error_modified_Nm"].keys() == {"x", "y"}
    assert {"lola_drake", "drake", "numpy", "python"} <= summary["versions"].keys()


def test_after_a_fall_nothing_counts(make_result):
    result = make_result(completed=False, fall_time=3.0)
    result.signals["torso_pose"][result.times > 3.0, 3:] = 1.5
    result.signals["ground_force"][result.times > 3.0, 2] = 1e5
    assert result.summary["fell"] and result.summary["fall_time_s"] == 3.0
    assert result.metrics["max_inclination_deg"] == {"x": 0.0, "y": 0.0}
    assert result.metrics["max_foot_force_N"] == 600.0


@pytest.mark.parametrize("samples", [0, 1, 700])
def test_an_interrupted_run_has_a_summary(make_result, samples):
    whole = make_result(completed=False)
    signals = {name: values[:samples] for name, values in whole.signals.items()}
    result = dataclasses.replace(whole, times=whole.times[:samples], signals=signals)
    assert json.loads(json.dumps(result.summary, allow_nan=False)) == result.summary


def test_numbers_that_json_cannot_hold_become_null(make_result):
    result = make_result()
    result.signals["contact_wrench_l"][2000] = np.nan
    assert result.summary["rms_torque_error_Nm"] == {"x": None, "y": None}


def test_numpy_numbers_are_plain_in_the_summary(make_result):
    result = make_result(
        completed=np.bool_(False), fall_time=np.float64(2.0), wall_time=np.float64(4.0)
    )
    assert json.loads(json.dumps(result.summary)) == result.summary


def test_a_signal_of_wrong_size_is_refused(make_result):
    result = make_result()
    with pytest.raises(ValueError, match="torso_pose has shape"):
        dataclasses.replace(result, signals=result.signals | {"torso_pose": np.zeros((3, 6))})


def test_saved_run_loads_as_it_was(make_result, tmp_path):
    scenario = load_scenario("walk_flat", ["seed=5", "control.com_dynamics.gain=0.7"])
    result = make_result(scenario, completed=False, fall_time=4.5)
    rng = np.random.default_rng(0)
    for values in result.signals.values():
        values += rng.standard_normal(values.shape)
    folder = result.save(tmp_path / "deep" / "run")
    again = load_result(folder)
    assert again.scenario == scenario
    np.testing.assert_array_equal(again.times, result.times)
    assert again.signals.keys() == result.signals.keys()
    for name, values in result.signals.items():
        np.testing.assert_array_equal(again.signals[name], values)
    assert again.summary == result.summary
    assert json.loads((folder / "summary.json").read_text()) == result.summary
    assert load_scenario(folder / "scenario.yaml") == scenario


def test_signals_carry_names_units_and_frames(make_result, tmp_path):
    folder = make_result(Scenario(seed=3)).save(tmp_path / "run")
    with h5py.File(folder / "signals.h5") as file:
        assert file.attrs["seed"] == 3
        assert "duration: 10.0" in file.attrs["scenario"]
        assert "drake" in json.loads(file.attrs["versions"])
        assert file.keys() == LOGGED.keys() | {"time"}
        attributes = file["torso_pose"].attrs
        assert list(attributes["names"][2:4]) == ["p.z", "rpy.roll"]
        assert list(attributes["units"][2:4]) == ["m", "rad"]
        assert list(attributes["frames"][2:4]) == ["W", "W"]
        for name, signal in LOGGED.items():
            assert len(file[name].attrs["names"]) == signal.size == file[name].shape[1]


def test_an_existing_run_is_replaced_only_by_force(make_result, tmp_path):
    make_result(Scenario(seed=1)).save(tmp_path / "run")
    with pytest.raises(ResultError, match="holds a run already"):
        make_result(Scenario(seed=2)).save(tmp_path / "run")
    assert load_result(tmp_path / "run").scenario.seed == 1
    make_result(Scenario(seed=2)).save(tmp_path / "run", force=True)
    assert load_result(tmp_path / "run").scenario.seed == 2
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_force_never_replaces_anything_but_a_run(make_result, tmp_path):
    (tmp_path / "summary.json").write_text("mine")
    with pytest.raises(ResultError, match="not a run"):
        make_result().save(tmp_path, force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


def test_an_empty_folder_is_used(make_result, tmp_path):
    assert load_result(make_result().save(tmp_path)).completed


def test_a_file_in_the_way_is_one_clear_line(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "run"):
        with pytest.raises(ResultError, match="Not a directory$"):
            check_folder(folder)


def test_a_folder_without_permission_is_one_clear_line(tmp_path, monkeypatch):
    def mkdir(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.mkdir", mkdir)
    with pytest.raises(ResultError, match="b: cannot be written, Permission denied$"):
        check_folder(tmp_path / "a" / "b")


def test_trying_a_folder_out_leaves_nothing(tmp_path):
    check_folder(tmp_path / "a" / "b")
    check_file(tmp_path / "c" / "d.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("folder", [".", "", "..", "/"])
def test_the_working_directory_is_never_swapped_away(tmp_path, monkeypatch, folder):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ResultError, match="in use as a whole"):
        check_folder(folder, force=True)


@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
def test_a_name_that_no_disk_takes_is_one_line(tmp_path, name):
    with pytest.raises(ResultError, match="cannot be written"):
        check_folder(tmp_path / name)
    with pytest.raises(OutputError, match="cannot be written"):
        check_file(tmp_path / name)


def test_a_file_is_replaced_only_by_force(tmp_path):
    (tmp_path / "page.html").write_text("mine")
    with pytest.raises(OutputError, match="is there already"):
        check_file(tmp_path / "page.html")
    assert check_file(tmp_path / "page.html", force=True) == tmp_path / "page.html"
    with pytest.raises(OutputError, match="a folder"):
        check_file(tmp_path, force=True)


def test_a_full_disk_leaves_nothing_behind(make_result, tmp_path):
    make_result(Scenario(seed=1)).save(tmp_path / "run")
    unlimited = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, unlimited[1]))
    try:
        with pytest.raises(ResultError, match="run: cannot be written, File too large$"):
            make_result().save(tmp_path / "run", force=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, unlimited)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert load_result(tmp_path / "run").scenario.seed == 1


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("summary.json", None, "holds no run"),
        ("signals.h5", None, "holds no run"),
        ("summary.json", "{", "cannot be read"),
        ("summary.json", "{}", "cannot be read"),
        ("signals.h5", "x", "cannot be read"),
        ("scenario.yaml", "seed: x", "cannot be read"),
    ],
)
def test_a_damaged_run_is_one_clear_line(make_result, tmp_path, name, content, message):
    folder = make_result(steps=1).save(tmp_path / "run")
    (folder / name).unlink()
    if content is not None:
        (folder / name).write_text(content)
    with pytest.raises(ResultError, match=message) as caught:
        load_result(folder)
    assert "\n" not in str(caught.value)


def changed_summary(**changes):
    def change(folder):
        summary = json.loads((folder / "summary.json").read_text())
        (folder / "summary.json").write_text(json.dumps(summary | changes))

    return change


def in_signals(change):
    def changed(folder):
        with h5py.File(folder / "signals.h5", "a") as file:
            change(file)

    return changed


def put(name, value):
    def change(file):
        file.pop(name, None)
        file[name] = value

    return in_signals(change)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda folder: (folder / "summary.json").write_text("[]"), "is no summary"),
        (lambda folder: (folder / "summary.json").write_text("[" * 100000), "cannot be read"),
        (changed_summary(fall_time_s="soon"), "fall_time is 'soon'"),
        (changed_summary(fall_time_s=float("nan")), "fall_time is nan"),
        (changed_summary(fall_time_s=-5), "fall_time is -5"),
        (changed_summary(completed="yes"), "completed is 'yes'"),
        (changed_summary(versions=[]), r"versions is \[\]"),
        (changed_summary(wall_time_s=None), "wall_time is None"),
        (lambda folder: (folder / "signals.h5").write_bytes(b""), "cannot be read"),
        (in_signals(lambda file: file.pop("torso_pose")), "lacks torso_pose"),
        (in_signals(lambda file: file.pop("time")), "lacks time"),
        (put("time", "noon"), "time holds no numbers"),
        (put("torso_pose", np.zeros((3, 6))), "torso_pose has the shape"),
        (put("time", np.zeros(2800)), "the times do not grow"),
        (put("imu", 1.0) and put("torso_pose", h5py.SoftLink("/nowhere")), "lacks torso_pose"),
    ],
)
def test_what_a_record_needs_is_said_in_one_line(make_result, tmp_path, damage, message):
    folder = make_result(steps=1).save(tmp_path / "run")
    damage(folder)
    with pytest.raises(ResultError, match=message) as caught:
        load_result(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "extend",
    [
        put("own", np.zeros(3)),
        put("link", h5py.SoftLink("/nowhere")),
        in_signals(lambda file: file.create_group("mine").create_dataset("x", data=1)),
        changed_summary(remark="mine", versions={"drake": 2}),
        changed_summary(wall_time_s=0),
    ],
)
def test_what_a_user_adds_to_a_record_does_no_harm(make_result, tmp_path, extend):
    folder = make_result(steps=1).save(tmp_path / "run")
    extend(folder)
    assert load_result(folder).signals.keys() == LOGGED.keys()
    assert "real_time_factor" in load_result(folder).summary


def test_a_run_before_half_a_second_says_no_numbers(make_result):
    whole = make_result(completed=False, fall_time=0.3)
    said = {name: value for name, value in whole.metrics.items() if value is not None}
    numbers = {name for name, value in said.items() if not isinstance(value, dict)}
    assert numbers == {"distance_m", "mean_speed_m_per_s", "steps_with_feet_colliding"}
    nested = [value for value in said.values() if isinstance(value, dict)]
    assert nested and all(entry is None for value in nested for entry in value.values())


def test_a_result_is_shown_in_one_short_line(make_result):
    assert repr(make_result(error="the solver failed", completed=False)).endswith(
        "failed at 6.799 s: the solver failed>"
    )
    assert len(repr(make_result())) < 100
