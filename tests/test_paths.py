"""What comes with the package."""

from lola_drake.paths import list_scenarios, models_dir, scenario_paths


def test_models_are_there():
    assert (models_dir() / "package.xml").is_file()


def test_every_scenario_has_one_line():
    scenarios = list_scenarios()
    assert list(scenarios) == list(scenario_paths())
    assert {"stand", "step_in_place", "walk_flat", "walk_fast", "walk_turn"} <= set(scenarios)
    for description in scenarios.values():
        assert description and "\n" not in description
