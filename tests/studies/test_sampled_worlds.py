"""Sampled worlds: the same for the same seed, within their ranges, and nothing else changed."""

import dataclasses

import numpy as np
import pytest

from lola_drake.scenario import Obstacle, ScenarioError, differences, load_scenario, override
from lola_drake.studies.sampled_worlds import sample_world

SEEDS = range(200)


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("step_down")


@pytest.fixture(scope="module")
def worlds(scenario):
    return [sample_world(scenario, seed) for seed in SEEDS]


def test_a_seed_is_a_world(scenario, worlds):
    assert sample_world(scenario, 3) == worlds[3]
    assert len({world.ground.friction for world in worlds}) == len(SEEDS)


def test_all_variants_live_in_the_same_world(scenario, worlds):
    other = sample_world(override(scenario, {"variant": "ref"}), 5)
    assert differences(other, worlds[5]) == {"variant": "ref"}


def test_only_the_world_differs(scenario, worlds):
    changed = set().union(*(differences(world, scenario) for world in worlds))
    assert changed == {
        "seed",
        "ground.friction",
        "ground.stiffness",
        "ground.obstacles",
        "control.servos.delay_ticks",
        "sensors.imu.delay_ticks",
    }


def spread(values):
    return np.min(values), np.max(values)


def test_the_ranges_are_used_and_kept(scenario, worlds):
    low, high = spread([world.ground.friction for world in worlds])
    assert 0.6 <= low < 0.61 and 0.99 < high <= 1.0
    low, high = spread([world.ground.stiffness / scenario.ground.stiffness for world in worlds])
    assert 0.7 <= low < 0.72 and 1.28 < high <= 1.3
    assert {world.control.servos.delay_ticks for world in worlds} == {1, 2}
    assert {world.sensors.imu.delay_ticks for world in worlds} == {2, 3, 4}
    assert [world.seed for world in worlds] == list(SEEDS)


def test_obstacles_move_within_their_free_range_and_keep_their_size(scenario, worlds):
    (platform,) = scenario.ground.obstacles
    moved = [world.ground.obstacles[0] for world in worlds]
    low, high = spread([other.position[0] - platform.position[0] for other in moved])
    assert platform.free_shift[0] <= low < -0.02 and 0.02 < high <= platform.free_shift[1]
    assert {dataclasses.replace(other, position=platform.position) for other in moved} == {platform}


def test_the_seed_of_the_scenario_does_not_matter(scenario, worlds):
    assert sample_world(override(scenario, {"seed": 77}), 9) == worlds[9]


def test_a_turned_obstacle_moves_along_its_length():
    board = Obstacle(position=(1.0, 2.0), heading_deg=90.0)
    assert board.shifted(0.1).position == pytest.approx((1.0, 2.1))


@pytest.mark.parametrize("name", ["step_down", "board_4cm", "board_9cm"])
def test_the_experiments_say_what_is_free(name):
    (obstacle,) = load_scenario(name).ground.obstacles
    assert obstacle.free_shift[0] < 0.0 < obstacle.free_shift[1]


def test_stairs_and_footholds_move_and_fields_are_drawn_anew():
    stairs = load_scenario("stairs_blind")
    field = load_scenario("rough_field")
    half = load_scenario("half_board")
    for base in (stairs, half):
        boards = [sample_world(base, seed).terrain.boards for seed in SEEDS]
        moved = (
            np.array([found[0].position[0] for found in boards])
            - base.terrain.boards[0].position[0]
        )
        low, high = (base.ground.stairs or base.ground.footholds)[0].free_shift
        assert low <= moved.min() < moved.max() <= high and np.ptp(moved) > 0.5 * (high - low)
        assert {found[0].size for found in boards} == {base.terrain.boards[0].size}
    seeds = [sample_world(field, seed).ground.fields[0].seed for seed in SEEDS]
    assert len(set(seeds)) == len(seeds)
    assert seeds == [sample_world(field, seed).ground.fields[0].seed for seed in SEEDS]
    assert sample_world(field, 1).ground.obstacles == field.ground.obstacles


@pytest.mark.parametrize(
    ("seed", "drawn"),
    [
        (0, (0.8547846749285817, 258561.60847749663, 0.14374867619680973, 1, 2)),
        (1003, (0.6751029473074533, 256207.04583938795, 0.16643396635944255, 2, 3)),
    ],
)
def test_the_worlds_of_the_readme_stay_the_same(scenario, seed, drawn):
    """Whoever changes this draws other worlds than those of which the README's figures tell."""
    world = sample_world(scenario, seed)
    found = (
        world.ground.friction,
        world.ground.stiffness,
        world.ground.obstacles[0].position[0],
        world.control.servos.delay_ticks,
        world.sensors.imu.delay_ticks,
    )
    assert found == drawn


@pytest.fixture(scope="module")
def extended(scenario):
    wider = override(scenario, {"worlds.extended": True})
    return [sample_world(wider, seed) for seed in SEEDS]


def test_extended_worlds_are_the_same_and_more(worlds, extended):
    changed = set().union(*map(differences, extended, worlds))
    assert changed == {
        "worlds.extended",
        "start.y",
        "start.heading_deg",
        "control.servos.missed",
        "model_errors.mass",
        "model_errors.inertia",
        "model_errors.pad_stiffness",
        "model_errors.pad_height",
        "model_errors.servo_gain",
    }


def test_extended_worlds_keep_their_ranges(extended):
    for name, low, high in (
        ("mass", 0.95, 1.05),
        ("inertia", 0.95, 1.05),
        ("pad_stiffness", 0.9, 1.1),
        ("pad_height", -5e-4, 5e-4),
        ("servo_gain", 0.9, 1.1),
    ):
        least, most = spread([getattr(world.model_errors, name) for world in extended])
        reach = 0.03 * (high - low)
        assert low <= least < low + reach and high - reach < most <= high, name
    least, most = spread([world.start.heading_deg for world in extended])
    assert -0.3 <= least < -0.28 and 0.28 < most <= 0.3
    counts = [len(world.control.servos.missed) for world in extended]
    assert 2.0 < np.mean(counts) / extended[0].duration / 0.25 < 2.0 + 1.0


def test_ranges_can_be_set(scenario):
    narrow = override(scenario, {"worlds.friction": [0.5, 0.5], "worlds.bus_delay": [3, 3]})
    world = sample_world(narrow, 4)
    assert (world.ground.friction, world.control.servos.delay_ticks) == (0.5, 3)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("friction", [0.9, 0.6], "from a number to one as large"),
        ("bus_delay", [1, 1.5], "two whole numbers"),
        ("mass", [0.1, 1.0], "mass"),
    ],
)
def test_other_ranges_are_refused(scenario, key, value, message):
    with pytest.raises(ScenarioError, match=message):
        override(scenario, {f"worlds.{key}": value})
