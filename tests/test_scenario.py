"""Scenarios: files, overrides, variants."""

import dataclasses
import re

import numpy as np
import pytest

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.paths import scenario_paths
from lola_drake.scenario import (
    Control,
    Ground,
    Obstacle,
    Scenario,
    ScenarioError,
    differences,
    dump_scenario,
    load_scenario,
    override,
)
from lola_drake.walk import StepGroup, TimedCommand, Walk


def write(folder, text):
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", scenario_paths())
def test_shipped_scenario_loads_dumps_and_loads_again(name, tmp_path):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert load_scenario(write(tmp_path, dump_scenario(scenario))) == scenario
    assert override(Scenario(), differences(scenario)) == scenario


def test_file_changes_what_it_names_and_nothing_else(tmp_path):
    path = write(tmp_path, "seed: 3\nground: {stiffness: 4e5, obstacles: [{height: 0.05}]}")
    scenario = load_scenario(path)
    assert differences(scenario).keys() == {
        "name",
        "seed",
        "ground.stiffness",
        "ground.obstacles",
    }
    assert scenario.name == "mine"
    assert scenario.ground == Ground(stiffness=4e5, obstacles=(Obstacle(height=0.05),))


def test_dump_names_every_value():
    text = dump_scenario(Scenario())
    for field in dataclasses.fields(Scenario):
        assert re.search(rf"^{field.name}:", text, re.MULTILINE)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("duraton: 3", "duraton: no such key, did you mean duration?"),
        ("duration: 0", "duration: 0 is not allowed, it must be a number >= 0.001 and <= 3600 s"),
        ("duration: .nan", "duration: nan is not allowed"),
        ("seed: -1", "seed: -1 is not allowed, it must be a whole number >= 0"),
        ("variant: best", "variant: 'best' is not allowed, it must be one of ref, dyn"),
        ("name: ../x", "name: '../x' is not allowed"),
        ("walk: {steps: [{count: 0}]}", "walk.steps[0].count: 0 is not allowed"),
        ("walk: {steps: [{}], command: [{}]}", "walk.command: [0.0] is not allowed"),
        ("walk: {command: [{time: 2}, {time: 1}]}", "walk.command: [2.0, 1.0] is not allowed"),
        ("ground: {obstacles: [{}, {}]}", "ground.obstacles: ['board', 'board'] is not allowed"),
        ("control: {com_dynamic: {}}", "control.com_dynamic: no such key, did you mean com_dyn"),
        ("control: {com_dynamics: {gain: 2}}", "control.com_dynamics.gain: 2 is not allowed"),
        ("seed: 1\nseed: 2", "line 2: the key 'seed' appears twice"),
        ("seed: [", "line 1: "),
    ],
)
def test_error_in_a_file_is_one_line_that_says_where(text, message, tmp_path):
    path = write(tmp_path, text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)


def test_error_for_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(ScenarioError, match="gone.yaml: No such file"):
        load_scenario(tmp_path / "gone.yaml")
    with pytest.raises(ScenarioError, match="Is a directory"):
        load_scenario(tmp_path)
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(ScenarioError, match="bytes.yaml: not a text file"):
        load_scenario(tmp_path / "bytes.yaml")


def test_unknown_name_suggests_known_ones():
    with pytest.raises(ScenarioError, match="walk_flt: no such scenario, did you mean walk_flat"):
        load_scenario("walk_flt")


def test_overrides_as_texts_and_as_mapping_agree():
    texts = ["seed=4", "control.com_dynamics.gain=5e-1", "walk.steps=[{count: 2, length: 0.3}]"]
    mapping = {
        "seed": np.int64(4),
        "control.com_dynamics.gain": np.float64(0.5),
        "walk.steps": (StepGroup(count=2, length=0.3),),
    }
    scenario = load_scenario("stand", texts)
    assert scenario == load_scenario("stand", mapping)
    assert (scenario.seed, scenario.control.com_dynamics.gain) == (4, 0.5)
    assert scenario.walk.steps == (StepGroup(count=2, length=0.3),)


def test_override_reaches_into_lists():
    scenario = Scenario(ground=Ground(obstacles=(Obstacle("a"), Obstacle("b", (3.0, 0.0)))))
    higher = override(scenario, ["ground.obstacles.1.height=0.09", "ground.obstacles[0].size[1]=2"])
    assert [obstacle.height for obstacle in higher.ground.obstacles] == [0.04, 0.09]
    assert higher.ground.obstacles[0].size == (0.4, 2.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("seed", "'seed' is not of the form key=value"),
        ("=1", "'=1' is not of the form key=value"),
        ("sed=1", "sed: no such key, did you mean seed?"),
        ("seed.x=1", "seed.x: no such key, there is nothing below it"),
        ("control.forc.time_constant=1", "control.forc: no such key, did you mean force?"),
        ("seed=-1", "seed: -1 is not allowed, it must be a whole number >= 0"),
        (
            "duration=inf",
            "duration: 'inf' is not allowed, it must be a number >= 0.001 and <= 3600 s",
        ),
        ("ground.obstacles.0.height=1", "ground.obstacles.0: no such key"),
        ("start=[", "line 1: "),
    ],
)
def test_error_in_an_override_is_one_line(text, message):
    with pytest.raises(ScenarioError) as caught:
        load_scenario("stand", [text])
    assert str(caught.value).startswith(f"override of stand: {message}")
    assert "\n" not in str(caught.value)


def test_overrides_are_checked_together():
    steps = Scenario(walk=Walk(steps=(StepGroup(),)))
    command = Scenario(walk=Walk(command=(TimedCommand(v_x=0.1),)))
    assert override(steps, differences(command, steps)) == command
    assert override(command, differences(steps, command)) == steps


def test_servos_are_refused_that_are_too_stiff_only_with_their_error():
    stiff = {"control.servos.position_gain": 300.0}
    assert override(Scenario(), stiff | {"model_errors.servo_gain": 1.5}).real_servos()
    allowed = "such that control.servos.position_gain times it is a number >= 1 and <= 500"
    with pytest.raises(ScenarioError, match=f"model_errors.servo_gain: 2.0 .* {allowed}"):
        override(Scenario(), stiff | {"model_errors.servo_gain": 2.0})


def test_ref_is_the_gain_zero():
    scenario = override(Scenario(), {"control.com_dynamics.gain": 0.8, "variant": "ref"})
    assert scenario.active_control().com_dynamics.gain == 0.0
    other = override(scenario, {"variant": "dyn"})
    assert other.active_control() == other.control
    assert other.control.com_dynamics.gain == 0.8


def test_original_is_the_predecessors_law_without_com_dynamics():
    control = Scenario(variant="original").active_control()
    assert (control.law, control.com_dynamics.gain) == ("configuration_space", 0.0)
    allowed = "configuration_space in the variant original, or left as it is"
    with pytest.raises(ScenarioError, match=f"control.law: 'damping' .* {allowed}"):
        override(Scenario(variant="original"), {"control.law": "damping"})


@pytest.mark.parametrize("switch", ["sensed_area", "exact_angles"])
def test_switches_of_the_papers_law_are_refused_with_another_one(switch):
    key = f"control.force.{switch}"
    with pytest.raises(ScenarioError, match=f"{key}: True is not allowed.* force law damping"):
        override(Scenario(), {key: True, "control.law": "damping"})
    with pytest.raises(ScenarioError, match="in the variant original"):
        override(Scenario(variant="original"), {key: True})


@pytest.mark.parametrize("law", FORCE_LAWS)
def test_every_force_law_has_its_section(law):
    control = Control(law=law)
    assert type(control.of_law()) is FORCE_LAWS[law].Params
    expected = law if hasattr(control, law) else "force"
    assert control.of_law() is getattr(control, expected)


@pytest.mark.parametrize("predecessor", ["variant=original", "control.law=configuration_space"])
def test_height_adaptation_is_refused_where_no_foot_has_a_modification(predecessor):
    with pytest.raises(ScenarioError, match="pattern.height_adaptation: True is not allowed"):
        load_scenario("stand", ["pattern.height_adaptation=true", predecessor])
