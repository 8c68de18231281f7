"""The MCAP export: what other tools read is what was recorded."""

import json
import sys

import numpy as np
import pytest
from mcap.reader import make_reader

from lola_drake.atomic_file import OutputError
from lola_drake.logged import LOGGED
from lola_drake.mcap_export import export_mcap, message_schema, message_template

KILOMETRE = np.nextafter(1000.123456789, 2000.0)


@pytest.fixture(scope="module")
def run(make_result):
    result = make_result(steps=0)
    result.signals["joint_position"][:, 5] = -0.25
    result.signals["torso_pose"][:, 2] = 1.1
    result.signals["com_position"][10, 0] = np.nan
    result.signals["com_position"][20, 0] = np.inf
    result.signals["com_position"][30, 0] = KILOMETRE
    result.signals["torso_pose"][40, :2] = KILOMETRE, -KILOMETRE
    return result


@pytest.fixture(scope="module")
def content(run, tmp_path_factory):
    path = export_mcap(run, tmp_path_factory.mktemp("mcap") / "run.mcap", rate=100)
    with path.open("rb") as stream:
        reader = make_reader(stream)
        messages = {}
        for schema, channel, message in reader.iter_messages():
            entry = (message.log_time, json.loads(message.data))
            messages.setdefault(channel.topic, (schema, []))[1].append(entry)
        return messages, {record.name: record.metadata for record in reader.iter_metadata()}


def test_every_signal_is_a_topic_at_the_rate_asked_for(run, content):
    messages, _ = content
    assert set(messages) == {f"/{name}" for name in run.signals} | {"/tf"}
    _, pose = messages["/torso_pose"]
    assert len(pose) == len(run.times[::10])
    assert [time for time, _ in pose[:3]] == [0, 10_000_000, 20_000_000]


def test_values_keep_their_names(content):
    messages, _ = content
    _, joints = messages["/joint_position"]
    assert joints[0][1]["q"]["tkfr"] == -0.25
    _, gait = messages["/gait_phase"]
    assert gait[0][1]["support"] == {"l": 1, "r": 1} and gait[0][1]["step_index"] == 0


def test_what_is_not_a_number_is_null(content):
    _, com = content[0]["/com_position"]
    assert com[1][1]["p"] == com[2][1]["p"] == {"x": None, "y": 0, "z": 0}


def test_numbers_are_exact_to_the_last_bit(content):
    """A kilometre from the origin, where six digits would be a metre."""
    messages, _ = content
    assert messages["/com_position"][1][3][1]["p"]["x"] == KILOMETRE
    assert messages["/torso_pose"][1][4][1]["p"]["x"] == KILOMETRE
    (poses,) = (entry["transforms"] for time, entry in messages["/tf"][1] if time == 40_000_000)
    (torso,) = (each for each in poses if each["child_frame_id"] == "torso")
    assert (torso["translation"]["x"], torso["translation"]["y"]) == (KILOMETRE, -KILOMETRE)


def test_messages_are_written_in_the_order_of_time(run, tmp_path):
    with export_mcap(run, tmp_path / "run.mcap", rate=1000 / 3).open("rb") as stream:
        times = [m.log_time for *_, m in make_reader(stream).iter_messages(log_time_order=False)]
    assert times == sorted(times)


@pytest.mark.parametrize("rate", [400, 999, 1001, 0, -1, 1e-300, float("nan"), float("inf")])
def test_a_rate_that_is_not_exact_is_refused(run, tmp_path, rate):
    with pytest.raises(OutputError, match="there are 1000, 500, 333.3333"):
        export_mcap(run, tmp_path / "run.mcap", rate=rate)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("signal", LOGGED.values(), ids=lambda signal: signal.name)
def test_schemas_describe_the_messages(signal):
    message = json.loads(message_template(signal) % tuple(range(signal.size)))
    properties = message_schema(signal)["properties"]
    assert list(message) == list(properties)
    units = []
    for name, value in message.items():
        entries = properties[name].get("properties", {name: properties[name]})
        assert list(entries) == (list(value) if isinstance(value, dict) else [name])
        units += [entry["description"].split(" in ")[0] for entry in entries.values()]
    assert tuple(units) == signal.entry_units()


def test_foxglove_gets_the_pose_of_every_link(content):
    schema, poses = content[0]["/tf"]
    assert schema.name == "foxglove.FrameTransforms"
    transforms = {each["child_frame_id"]: each for each in poses[0][1]["transforms"]}
    assert transforms["torso"]["translation"] == {"x": 0.0, "y": 0.0, "z": 1.1}
    assert transforms["foot_l"]["translation"]["z"] < 0.1
    assert transforms["torso"]["parent_frame_id"] == "world"


def test_the_file_says_what_was_run(run, content):
    metadata = content[1]["run"]
    assert metadata["seed"] == str(run.scenario.seed) and "variant: dyn" in metadata["scenario"]
    assert json.loads(metadata["versions"]) == run.versions


def test_a_missing_package_is_said_in_one_line(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(OutputError, match="pip install"):
        export_mcap(run, tmp_path / "run.mcap")
    assert not list(tmp_path.iterdir())
