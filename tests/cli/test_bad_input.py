"""Every bad input is one line that names key, value and what is allowed; nothing is left."""

import json
import os
import subprocess
import sys

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.scenario_keys import settings as known_settings


def refused(done, folder):
    """Return the one line of a command that was refused; only its own file lies there."""
    assert done.exit_code == 2, done.output
    assert not done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith("lola: ") and line.isprintable() and len(line) <= 200, len(line)
    assert {path.name for path in folder.iterdir()} <= {"my.yaml"}
    return line


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("duration: 1:30", "duration: '1:30' is not allowed, it must be a number"),
        ("duration: 1e300", "duration: 1e+300 is not allowed"),
        ("duration: 2017-06-01", "duration: '2017-06-01' is not allowed"),
        ("duration: 1_000", "duration: '1_000' is not allowed"),
        ("duration: 0x10", "duration: '0x10' is not allowed"),
        ("duration: !!timestamp nope", "the tag tag:yaml.org,2002:timestamp is not wanted"),
        ("duration: !!float nope", "the tag tag:yaml.org,2002:float is not wanted"),
        ("duration: !!binary x", "the tag tag:yaml.org,2002:binary is not wanted"),
        ("seed: 010", "seed: '010' is not allowed, it must be a whole number"),
        ("seed: 999999999999999999999999999999", "seed: 1e+30 is not allowed"),
        (f"seed: {'9' * 5000}", "seed: inf is not allowed"),
        ("sensors: {ideal: yes}", "sensors.ideal: 'yes' is not allowed, it must be true or false"),
        ('name: "\\ud800"', "name: '\\ud800' is not allowed"),
        ('name: "a\\nb"', "name: 'a\\nb' is not allowed"),
        ('name: "\\e[2J"', "name: '\\x1b[2J' is not allowed"),
        ('name: "\\u202e"', "name: '\\u202e' is not allowed"),
        (f"name: {'x' * 5000}", "it must be plain text of at most 50 characters"),
        ('name: ""', "name: '' is not allowed"),
        ("name: -x", "name: '-x' is not allowed"),
        ('"\\ud800": 1', "no such key"),
        (f"{'x' * 100}: 1", "no such key"),
        ("ground: {obstacles: [{name: floor}]}", "ground.obstacles[0].name: 'floor'"),
        ('ground: {obstacles: [{name: ""}]}', "ground.obstacles[0].name: ''"),
        ('ground: {obstacles: [{name: "a\\nb"}]}', "ground.obstacles[0].name: 'a\\nb'"),
        ("ground: {obstacles: [{size: [1e300, 1e300]}]}", "ground.obstacles[0].size[0]: 1e+300"),
        ("ground: {obstacles: [{position: [1e300, 0]}]}", "obstacles[0].position[0]: 1e+300"),
        (
            "ground: {obstacles: [{name: a, position: [3, 0]}, {name: b, position: [3.1, 0]}]}",
            "ground.obstacles: ['a', 'b'] is not allowed, it must be boards beside each other",
        ),
        ("ground: {obstacles: [{position: [0, 0.6]}]}", "start: [0.0, 0.0, 0.0] is not allowed"),
        ("ground: {obstacles: [{size: [0.2, 0.1]}]}", "start: [0.0, 0.0, 0.0] is not allowed"),
        ("ground: {dissipation: 1e300}", "ground.dissipation: 1e+300 is not allowed"),
        ("control: {force: {time_constant: 1e300}}", "control.force.time_constant: 1e+300"),
        ("walk: {command: [{v_x: 1e300}]}", "walk.command[0].v_x: 1e+300 is not allowed"),
        ("walk: {command: [{v_x: 0.7}]}", "walk.command[0].v_x: 0.7 is not allowed"),
        ("walk: {command: [{v_x: 1.0}]}", "<= 0.562 with pattern.step_time 0.8 s"),
        ("walk: {command: [{v_x: 5}]}", "walk.command[0].v_x: 5 is not allowed"),
        ("walk: {command: [{v_y: 0.3}]}", "walk.command[0].v_y: 0.3 is not allowed"),
        ("walk: {command: [{turn_rate: 1.5}]}", "walk.command[0].turn_rate: 1.5 is not allowed"),
        ("walk: {steps: [{count: 1000000000}]}", "walk.steps[0].count: 1000000000"),
        ("walk: {command: [{v_x: 0.5, v_y: 0.18}]}", "walk.command[0]: [0.5, 0.18, 0.0]"),
        ("walk: {command: [{v_y: 0.18, turn_rate: 0.4}]}", "(v_y/0.187)^2 + (turn_rate/0.491)^2"),
        ("walk: {steps: [{length: 0.4, sideways: 0.3}]}", "walk.steps[0]: [0.4, 0.3, 0.0]"),
        ("walk: {steps: [{}, {sideways: 0.2, turn_deg: 45}]}", "walk.steps[1]: [0.0, 0.2, 45.0]"),
        ("walk: {steps: [{height: 0.3}]}", "walk.steps[0].height: 0.3 is not allowed"),
        (f"walk: {{steps: [{'{},' * 101}]}}", "walk.steps: [{}, {}"),
        ("pattern: {double_support: 0.8}", "pattern.double_support: 0.8 is not allowed, it must"),
        ("pattern: {double_support: 0.9}", "it must be <= step_time - 0.2 s = 0.6 s"),
        ("sensors: {contact: {open_force: 20}}", "sensors.contact.open_force: 20"),
    ],
)
def test_a_scenario_that_cannot_be_is_refused(lola, tmp_path, text, message):
    (tmp_path / "my.yaml").write_text(text, encoding="utf-8")
    assert message in refused(lola("simulate", "my.yaml"), tmp_path)
    assert not lola.runs


def test_errors_point_to_the_keys(lola, tmp_path):
    line = refused(lola("simulate", "stand", "--set", "control.force.position_gain=-1"), tmp_path)
    assert line.endswith("; see: lola keys control.force")
    line = refused(lola("simulate", "stand", "--set", "control.forc.x=-1"), tmp_path)
    assert line.endswith("did you mean force?; see: lola keys control")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["simulate"], "Missing argument"),
        (["simulate", "stand", "--seed", "x"], "--seed"),
        (["simulate", "stand", "--sed", "1"], "No such option"),
        (["simulate", "stand", "--seed", "9" * 30], "seed: "),
        (["simulate", "stand", "-o", "."], "choose a folder in it"),
        (["simulate", "stand", "-o", ""], "choose a folder in it"),
        (["map", "gains", "--torso", "inf"], "--torso"),
        (["map", "gains", "--torso-damping", "0.1"], "are those of a --torso HZ"),
        (["map", "gains", "--jobs", "100000"], "--jobs"),
        (["sweep", "stand", "--vary", "seed=1,2", "--worlds", "9" * 9], "--worlds"),
        (["reproduce", "--samples", "9" * 12], "--samples"),
        (["bench", "--repeats", "1000000"], "--repeats"),
        (["simulate", "stand", "--host", "*"], "--host is where the page of --meshcat"),
        (["diagram", "--all", "--system", "plant"], "--all draws every picture"),
        (["diagram", "step_down", "--all"], "--all draws every picture"),
        (["diagram", "--depth", "-1"], "--depth"),
        (["nothing"], "No such command"),
        (["keys", "grund"], "grund: no such key, did you mean ground?"),
        (["export", "gone"], "say in which format"),
        (["export", "gone", "--mcap"], "gone: holds no run"),
    ],
)
def test_a_wrong_option_is_one_line(lola, tmp_path, arguments, message):
    assert message in refused(lola(*arguments), tmp_path)


@pytest.mark.parametrize("command", [["simulate", "stand", "--meshcat"], ["walk"]])
def test_a_host_that_is_not_here_is_one_line(lola, tmp_path, command):
    line = refused(lola(*command, "--host", "8.8.8.8"), tmp_path)
    assert "no page can be shown at '8.8.8.8'" in line and not lola.runs


@pytest.mark.parametrize("rate", ["400", "0", "nan", "1001"])
def test_a_rate_that_the_record_does_not_have_is_one_line(make_result, tmp_path, rate):
    folder = make_result(steps=0).save(tmp_path / "deep" / "run")
    command = ["export", str(folder), "--mcap", "--rate", rate]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 2 and len(done.stderr.splitlines()) == 1 and not done.stdout
    allowed = "there are 1000, 500" if rate == "400" else "Input should be"
    assert "rate" in done.stderr and allowed in done.stderr
    assert sorted(path.suffix for path in folder.iterdir()) == [".h5", ".json", ".yaml"]


@pytest.mark.parametrize(
    "damage",
    [
        ("signals.h5", b""),
        ("signals.h5", b"\x89HDF\r\n\x1a\n" + bytes(500)),
        ("summary.json", b"[]"),
        ("summary.json", b'{"completed": true, "fall_time_s": "soon"}'),
        ("scenario.yaml", b"duration: 1:30"),
    ],
)
@pytest.mark.parametrize("command", [["report"], ["export", "--mcap"]])
def test_a_damaged_record_is_one_line_and_nothing_is_written(
    make_result, monkeypatch, tmp_path, command, damage
):
    folder = make_result(steps=0).save(tmp_path / "run")
    monkeypatch.chdir(tmp_path)
    name, content = damage
    (folder / name).write_bytes(content)
    done = CliRunner().invoke(app, [command[0], "run", *command[1:]])
    (line,) = done.stderr.splitlines()
    assert done.exit_code == 2 and not done.stdout
    assert line.startswith("lola: run: cannot be read, ") and len(line) <= 200
    assert [path.name for path in tmp_path.iterdir()] == ["run"] and len(
        list(folder.iterdir())
    ) == 3


def test_an_empty_file_is_the_scenario_of_all_defaults(lola, tmp_path):
    (tmp_path / "my.yaml").write_text("# nothing\n")
    assert lola("simulate", "my.yaml").exit_code == 0
    assert lola.runs[0].duration == 10.0


def test_keys_tell_all_there_is_to_know(lola):
    rows = json.loads(lola("keys", "--json").stdout)
    assert [row["key"] for row in rows] == [setting.key for setting in known_settings()]
    (row,) = json.loads(lola("keys", "control.force.time_constant", "--json").stdout)
    assert (row["default"], row["unit"], row["minimum"], row["maximum"]) == (0.02, "s", 0.001, 1)
    assert "control.force.time_constant: 0.02 s" in lola("keys", "control.force").stdout


def test_every_number_has_both_bounds():
    for setting in known_settings():
        if setting.unit or isinstance(setting.default, (int, float)):
            if not isinstance(setting.default, (bool, str)):
                assert setting.maximum is not None, setting.key
                assert (setting.minimum is None) != (setting.above is None), setting.key


NUMBERS = [s for s in known_settings() if s.maximum is not None and "[]" not in s.key]
NONSENSE = (
    st.floats(1e7) | st.floats(max_value=-1e7) | st.text(max_size=300) | st.none() | st.booleans()
)


@pytest.mark.usefixtures("lola")
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(NUMBERS), NONSENSE)
def test_whatever_stands_for_a_number_is_refused(tmp_path, setting, value):
    if isinstance(value, float) and setting.maximum >= abs(value) or value == "":
        return
    text = json.dumps(value)
    done = CliRunner().invoke(app, ["simulate", "stand", "--set", f"{setting.key}={text}"])
    assert setting.key in refused(done, tmp_path)


@pytest.mark.usefixtures("lola")
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=300).filter(lambda text: not text.startswith("-")))
def test_any_text_after_set_is_refused(tmp_path, text):
    refused(CliRunner().invoke(app, ["simulate", "stand", "--set", text]), tmp_path)


@pytest.mark.usefixtures("lola")
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.dictionaries(
        st.sampled_from(["walk", "ground", "control", "name", "start"]) | st.text(max_size=9),
        st.recursive(st.integers(10**9) | st.none(), lambda s: st.lists(s, min_size=1)),
        min_size=1,
    )
)
def test_a_structure_that_is_no_scenario_is_refused(tmp_path, data):
    (tmp_path / "my.yaml").write_text(json.dumps(data))
    refused(CliRunner().invoke(app, ["simulate", "my.yaml"]), tmp_path)


def test_a_terminal_without_anything_but_ascii(tmp_path):
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "TERM": "dumb", "COLUMNS": "60"}
    code = (
        "from rich.table import Table\nfrom lola_drake.cli.terminal import any_terminal, show\n"
        "any_terminal()\ntable = Table('φ_x …', 'n' * 70)\ntable.add_row('max |φ_y|', '1 … 2')\n"
        "show(table)\nprint('60° ☃')"
    )
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True)
    assert run.returncode == 0, run.stderr
    shown = run.stdout.decode("ascii")
    assert "max |phi_y|" in shown and "1 .. 2" in shown and "60deg ?" in shown
    assert shown.count("n") == 70 and max(map(len, shown.splitlines())) <= 60
