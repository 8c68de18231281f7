"""The arena: trials that get harder, in which a law of the feet's forces is held against others.

A trial is a walk with something unexpected in it, of one size. Nothing is told to the controller.
The worlds are those of `sample_world`, with seeds that nothing else draws: no law is tuned on them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import radians, tan

from lola_drake.scenario import Scenario, load_scenario
from lola_drake.studies.sampled_worlds import sample_world

FIRST_SEED = 5000
"""Of the worlds: those of the reproduction begin at 0, of tuning at 1000, of survival at 2000."""

STEP = 1 / 3
"""Length of a step (m); with 0.8 s a step that are the paper's 1.5 km/h."""

Settings = Mapping[str, object]


@dataclass(frozen=True)
class Trial:
    """A walk with something unexpected in it, of some sizes.

    Attributes:
        title: what the robot meets.
        unit: of the sizes.
        sizes: from easy to hard.
        settings: returns what the walk has of a size.
        steps: how many steps it takes.
        quick: the sizes of a quick evaluation.
        direction_deg: of a push, 0 forward and 90 to the left; None if it is none.
    """

    title: str
    unit: str
    sizes: tuple[float, ...]
    settings: Callable[[float], Settings]
    steps: int = 6
    quick: tuple[float, ...] = ()
    direction_deg: float | None = None

    def world(self, size: float, seed: int, law: Settings) -> Scenario:
        """Return the trial of a size in the world of a seed, with the settings of a contender."""
        walk = {
            "walk.start_time": 0.5,
            "walk.steps": [{"count": self.steps, "length": STEP}],
            "duration": 2.0 + 0.8 * self.steps,
            "pattern.step_height": 0.12,
            "pattern.phase_reset": True,
        }
        settings = {**walk, **self.settings(size), **law}
        return sample_world(load_scenario("walk_flat", settings), seed)


def _edge(cm: float) -> Settings:
    """Step off a platform: the third foothold is the first beyond its edge."""
    edge = {"position": [-0.1666, 0.0], "size": [2.0, 1.2], "free_shift": [-0.025, 0.025]}
    return {"ground.obstacles": [{"name": "platform", "height": cm / 100, **edge}]}


def _foothold(part: str) -> Callable[[float], Settings]:
    """Step on a board under a part of the third foothold."""
    board = {"name": "board", "step": 3, "part": part, "free_shift": [-0.01, 0.01]}
    return lambda cm: {"ground.footholds": [{**board, "height": cm / 100}]}


def _from_platform(height: float, /, **beyond: object) -> dict[str, list]:
    """Return a platform to start on, and a board of 4.5 m behind its edge."""
    platform = {"name": "platform", "position": [-0.5, 0.0], "size": [2.0, 1.2], "height": height}
    board = {"name": "board", "position": [2.75, 0.0], "size": [4.5, 1.2], **beyond}
    return {"ground.obstacles": [platform, board]}


def _up(deg: float) -> Settings:
    height = 2.25 * tan(radians(deg))
    slope = {"name": "slope", "position": [2.75, 0.0], "size": [4.5, 1.2], "height": height}
    return {"ground.obstacles": [{**slope, "pitch_deg": -deg}]}


def _down(deg: float) -> Settings:
    height = 2.25 * tan(radians(deg))
    return _from_platform(2 * height, height=height, pitch_deg=deg)


def _across(deg: float) -> Settings:
    return _from_platform(0.3, height=0.3, roll_deg=deg)


def _softer(times: float) -> Settings:
    return _from_platform(0.2, height=0.2, relative_stiffness=1 / times)


def _slippery(percent: float) -> Settings:
    return _from_platform(0.02, height=0.02, relative_friction=1 - percent / 100)


def _stairs(cm: float) -> Settings:
    """Three rises, a landing, and down again; each foot stands wholly on a step."""
    stairs = {"name": "stairs", "position": [0.8267, 0.0], "rise": cm / 100, "rises": 3}
    treads = {"tread": STEP, "landing": 2 * STEP, "free_shift": [-0.02, 0.02]}
    return {"ground.stairs": [{**stairs, **treads}]}


def _field(cm: float) -> Settings:
    height = 0.06
    start = {"name": "start", "position": [-0.5, 0.0], "size": [2.0, 1.2], "height": height}
    field = {"name": "field", "position": [0.5, 0.0], "size": [6.0, 1.2], "board": [0.4, 0.3]}
    return {
        "ground.obstacles": [start],
        "ground.fields": [{**field, "height": height, "spread": cm / 100}],
    }


def _push(direction_deg: float) -> Trial:
    """A push on the torso in the middle of a step."""

    def settings(impulse: float) -> Settings:
        push = {"time": 3.0, "duration": 0.1, "direction_deg": direction_deg, "impulse": impulse}
        return {"pushes": [push]}

    return Trial(
        title=f"push, {direction_deg:g}°",
        unit="Ns",
        sizes=(6, 9, 12, 15, 18, 21, 24, 28, 32, 36, 40, 45, 50),
        settings=settings,
        quick=(12, 18) if direction_deg in (90, 180) else (),
        direction_deg=direction_deg,
    )


TRIALS = (
    Trial("edge, down", "cm", (4, 6, 8, 10, 12, 14), _edge, quick=(6, 10, 14)),
    Trial("board", "cm", (4, 6, 8, 10, 12, 14), _foothold("whole"), quick=(6, 10, 14)),
    *(
        Trial(f"board under the {part} half", "cm", (2, 3, 4, 5, 6, 7, 8), _foothold(part))
        for part in ("front", "heel", "inner", "outer")
    ),
    Trial("slope, up", "deg", (4, 8, 12, 16, 20), _up, steps=10),
    Trial("slope, down", "deg", (4, 8, 12, 16, 20), _down, steps=10),
    Trial("slope, across", "deg", (4, 8, 12, 16, 20), _across, steps=10),
    Trial("stairs, three up and down", "cm", (3, 4, 5, 6, 7, 8), _stairs, steps=10),
    Trial("field of boards, ±", "cm", (1, 2, 3, 4, 5), _field, steps=14),
    Trial("softer ground", "times", (4, 8, 16, 24, 32), _softer, steps=10),
    Trial("friction lost", "%", (80, 90, 95, 97, 99), _slippery, steps=10),
    *map(_push, range(0, 360, 45)),
)
"""From the paper's experiments to what it did not try."""

QUICK = tuple(replace(trial, sizes=trial.quick) for trial in TRIALS if trial.quick)
"""What a law can be put through in two minutes."""
