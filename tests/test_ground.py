"""What lies on the floor: boards, slopes, stairs, fields, footholds, and what is refused."""

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from lola_drake.ground import Ground
from lola_drake.obstacles import Field, Obstacle, Stairs
from lola_drake.parameters import ParameterError
from lola_drake.partial_footholds import Foothold, Footprint
from lola_drake.scenario import Scenario, ScenarioError, load_scenario
from lola_drake.theory.rectangles import Rectangle, common

TILTED = Obstacle("tilted", (1.0, 2.0), heading_deg=30.0, height=0.2, pitch_deg=-8.0, roll_deg=5.0)
FEET = [Footprint("l", 1.0, 0.115, 0.0), Footprint("r", 1.3, -0.115, 0.0)]


def test_a_board_is_inclined_as_roll_pitch_and_heading_say():
    rotation = RollPitchYaw(*np.radians([5.0, -8.0, 30.0])).ToRotationMatrix().matrix()
    assert TILTED.normal == pytest.approx(rotation[:, 2])
    for along, across in ((0.1, 0.0), (0.0, 0.4), (-0.15, 0.2)):
        x, y, z = [1.0, 2.0, 0.2] + rotation @ [along, across, 0.0]
        assert TILTED.height_at(x, y) == pytest.approx(z)


def test_negative_pitch_rises_ahead_and_positive_roll_to_the_left():
    up = Obstacle(pitch_deg=-10.0, height=0.1)
    assert up.height_at(0.2, 0.0) == pytest.approx(0.1 + 0.2 * np.tan(np.radians(10.0)))
    left = Obstacle(roll_deg=10.0, height=0.1)
    assert left.height_at(0.0, 0.2) == pytest.approx(0.1 + 0.2 * np.tan(np.radians(10.0)))


def test_the_surface_is_that_of_the_highest_board_or_the_floor():
    ground = Ground(friction=0.5, obstacles=(TILTED, Obstacle("low", (3.0, 0.0), height=0.05)))
    ice = Obstacle("ice", (5.0, 0.0), height=0.01, relative_friction=0.2)
    steep = Obstacle("steep", (8.0, 0.0), size=(2.0, 1.0), height=0.01, pitch_deg=10.0)
    ground = Ground(friction=0.5, obstacles=(*ground.obstacles, ice, steep))
    points = np.array([[1.0, 2.0], [3.0, 0.0], [5.0, 0.0], [8.9, 0.0], [0.0, 0.0], [np.nan, 0.0]])
    at = ground.surface(points)
    assert at.height[:-1] == pytest.approx([0.2, 0.05, 0.01, 0.0, 0.0])
    assert at.friction[:-1] == pytest.approx([0.5, 0.5, 0.1, 0.5, 0.5])
    assert at.normal[0] == pytest.approx(TILTED.normal)
    assert at.normal[[1, 3, 4]] == pytest.approx(np.tile([0.0, 0.0, 1.0], (3, 1)))
    assert [ground.height_at(x, y) for x, y in points[:-1]] == pytest.approx(at.height[:-1])


def test_stairs_go_up_and_down_again():
    stairs = Stairs(position=(1.0, 0.5), heading_deg=90.0, rises=3, rise=0.04, tread=0.3)
    ground = Ground(stairs=(stairs,))
    places = [-0.01, 0.01, 0.29, 0.31, 0.61, 1.26, 1.28, 1.57, 1.86, 1.88]
    heights = [ground.height_at(1.0, 0.5 + place) for place in places]
    assert heights == pytest.approx([0, 0.04, 0.04, 0.08, 0.12, 0.12, 0.08, 0.04, 0.04, 0])
    assert ground.height_at(1.61, 0.7) == 0.0 and ground.height_at(0.41, 0.7) == 0.04


def test_a_field_is_drawn_from_its_seed_and_covers_its_size():
    field = Field(position=(1.0, 0.0), size=(2.0, 0.9), board=(0.4, 0.3), spread=0.03, tilt_deg=3)
    again, other = Ground(fields=(field,)), Ground(fields=(Field("b", (9.0, 0.0), seed=1),))
    assert len(field.boards) == 15
    heights = np.array([board.height for board in field.boards])
    assert np.ptp(heights) > 0.03 and np.all(np.abs(heights - 0.04) <= 0.03)
    tilts = np.array([(b.pitch_deg, b.roll_deg) for b in field.boards])
    assert np.abs(tilts).max() <= 3.0 and np.abs(tilts).min(axis=0).max() > 0.0
    assert again.boards == field.boards and len({b.height for b in other.boards}) > 50
    x, y = np.meshgrid(np.linspace(1.01, 2.99, 30), np.linspace(-0.44, 0.44, 30))
    assert again.surface(np.column_stack([x.ravel(), y.ravel()])).height.min() > 0.0


@pytest.mark.parametrize(
    ("part", "left", "right"),
    [
        ("front", (True, True, False, False), (True, True, False, False)),
        ("heel", (False, False, True, True), (False, False, True, True)),
        ("inner", (False, True, False, True), (True, False, True, False)),
        ("outer", (True, False, True, False), (False, True, False, True)),
        ("front_outer", (True, False, False, False), (False, True, False, False)),
        ("heel_inner", (False, False, False, True), (False, False, True, False)),
        ("whole", (True,) * 4, (True,) * 4),
    ],
)
def test_a_foothold_bears_the_pads_of_its_part(part, left, right):
    """Pads: front left, front right, rear left, rear right of the foot that is put down."""
    foothold = Foothold(step=1, count=2, part=part, height=0.05)
    ground = Ground(footholds=(foothold,)).laid(FEET)
    for foot, expected in zip(FEET, (left, right), strict=True):
        pads = [(foot.x + a * 0.095, foot.y + b * 0.09) for a in (1, -1) for b in (1, -1)]
        heights = [ground.height_at(x, y) for x, y in pads]
        assert heights == pytest.approx([0.05 * bears for bears in expected])


def test_a_foothold_turns_with_the_foot_and_is_moved_as_the_foot_sees_it():
    foot = Footprint("l", 1.0, 2.0, np.pi / 2)
    foothold = Foothold(step=1, part="front", position=(0.1, 0.02))
    (board,) = Ground(footholds=(foothold,)).laid([foot]).boards
    # The middle of the front half is 8.25 cm ahead and, of a left foot, 1.5 cm to the outside.
    assert board.position == pytest.approx((1.0 - 0.035, 2.0 + 0.1825))
    assert board.heading_deg == pytest.approx(90.0)


def test_the_plan_says_where_footholds_are():
    scenario = load_scenario(
        "walk_flat", {"ground.footholds": [{"step": 5, "part": "heel"}], "start.x": 1.0}
    )
    (board,) = scenario.terrain.boards
    # The fifth step is one of the left foot, 5 x 0.3333 m ahead.
    assert board.covers(1.0 + 1.6665 - 0.05, 0.115) and not board.covers(1.0 + 1.6665 + 0.05, 0.115)
    assert scenario.ground.boards == ()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ground.footholds": [{"step": 21}]}, "ground.footholds[0].step: 21 is not allowed"),
        ({"ground.stairs": [{"rises": 50, "rise": 0.1}]}, "ground.stairs[0].rise: 0.1 is not"),
        ({"ground.fields": [{"spread": 0.05}]}, "ground.fields[0].spread: 0.05 is not allowed"),
        ({"ground.fields": [{"board": [0.05, 0.05]}]}, "ground.fields[0].board: [0.05, 0.05] is"),
        ({"ground.fields": [{}], "ground.stairs": [{}]}, "ground.obstacles: ['"),
        ({"ground.obstacles": [{"pitch_deg": 31}]}, "ground.obstacles[0].pitch_deg: 31 is not"),
        ({"ground.obstacles": [{"name": "stairs 1"}], "ground.stairs": [{}]}, "ground.obstacles:"),
    ],
)
def test_what_cannot_lie_there_is_refused_in_one_line(changes, message):
    with pytest.raises(ScenarioError) as caught:
        load_scenario("walk_flat", changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)


SLOPE = {"size": (2.0, 1.0), "pitch_deg": -10.0}


@pytest.mark.parametrize("height", [0.1, 0.3, 0.02])
def test_a_slope_that_runs_through_a_platform_is_refused(height):
    """Where their tops come close, both would carry a foot."""
    platform = Obstacle("platform", size=(1.0, 1.0), height=0.1)
    slope = Obstacle("slope", height=height, **SLOPE)
    if height == 0.3:  # 0.3 m less 0.5 m * tan(10 deg) is well above
        assert Ground(obstacles=(platform, slope)).height_at(0.0, 0.0) == 0.3
        return
    with pytest.raises(ParameterError, match="boards beside each other"):
        Ground(obstacles=(platform, slope))


def test_a_slope_may_end_at_a_platform():
    rise = 2.0 * np.tan(np.radians(10.0))
    slope = Obstacle("slope", (2.0, 0.0), height=rise / 2, **SLOPE)
    platform = Obstacle("platform", (3.5, 0.0), size=(1.0, 1.0), height=rise)
    ground = Ground(obstacles=(slope, platform))
    assert ground.height_at(2.999, 0.0) == pytest.approx(ground.height_at(3.001, 0.0), abs=1e-3)
    assert ground.height_at(1.001, 0.0) == pytest.approx(0.0, abs=1e-3)


def test_a_start_on_an_inclined_board_is_refused():
    board = Obstacle("board", size=(2.0, 2.0), height=0.1)
    assert Scenario(ground=Ground(obstacles=(board,)))
    for inclination in ({"pitch_deg": 1.0}, {"roll_deg": 1.0}):
        tilted = Obstacle("board", size=(2.0, 2.0), height=0.1, **inclination)
        with pytest.raises(ParameterError, match="start"):
            Scenario(ground=Ground(obstacles=(tilted,)))


def test_what_is_common_to_rectangles():
    one = Rectangle(0.0, 0.0, 0.0, 2.0, 1.0)
    corners = np.array(common(one, Rectangle(1.0, 0.5, 0.0, 1.0, 1.0)))
    assert sorted(map(tuple, corners.round(12))) == [(0.5, 0.0), (0.5, 0.5), (1.0, 0.0), (1.0, 0.5)]
    turned = common(one, Rectangle(0.0, 0.0, np.pi / 4, 0.5, 0.5))
    assert np.hypot(*np.array(turned).T) == pytest.approx([0.25 * np.sqrt(2)] * 4)
    assert common(one, Rectangle(5.0, 0.0, 0.3, 1.0, 1.0)) == []
