"""Fixtures that several test modules share."""

import lola_drake  # noqa: F401  # before numpy: it says how many threads that uses

# isort: split

import signal

import numpy as np
import pytest
from hypothesis import settings

from lola_drake.logged import LOGGED
from lola_drake.scenario import Scenario
from lola_drake.signals import FEET, GAIT_PHASE, GROUND_FORCE

# No test times anything, and a failure found once is found again.
settings.register_profile("lola", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("lola")

# A shell starts what runs in its background deaf to Ctrl-C, which some tests send.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def make_result():
    """Return a function that makes the record of a made-up walk, without any simulation.

    The torso advances by 0.4 m in each of its steps of 0.8 s and sways by 3 cm.
    """
    from lola_drake.results import Result

    def make(scenario: Scenario | None = None, *, steps: int = 6, **changes) -> Result:
        times = np.arange(1000 + 800 * steps + 1000) / 1000
        signals = {name: np.zeros((len(times), signal.size)) for name, signal in LOGGED.items()}
        phase = np.clip((times - 1.0) / 0.8, 0.0, steps)
        swing = (phase % 1 > 0.25) & (phase < steps)
        signals["torso_pose"][:, 0] = 0.4 * phase
        signals["torso_pose"][:, 1] = 0.03 * np.sin(np.pi * (phase + 0.5)) - 0.03
        signals["gait_phase"][:, GAIT_PHASE.index("step_index")] = np.floor(phase)
        support = signals["gait_phase"][:, GAIT_PHASE.slice("support")]
        support[:] = 1.0
        for k, foot in enumerate(FEET):
            support[:, k] -= swing & (np.floor(phase) % 2 == k)
            vertical = GROUND_FORCE.slice(f"F_{foot}").stop - 1
            signals["ground_force"][:, vertical] = 600 * support[:, k]
        outcome = {"completed": True, "fall_time": None, "wall_time": 4.0} | changes
        return Result(scenario=scenario or Scenario(), times=times, signals=signals, **outcome)

    return make


@pytest.fixture(scope="session")
def play_pattern():
    """Return a function that plays a walking pattern alone, tick by tick.

    It takes the steps (forward, left, turn, up) or None, when they start, the command by time, and
    parameters of the pattern; it returns the signals by name, one row per tick.
    """
    from ticking import Ticking

    from lola_drake.blocks.walking_pattern import WalkingPattern, WalkingPatternParams
    from lola_drake.robot import Kinematics, leg_model

    legs = leg_model(Kinematics())

    def play(ticks, *, steps=None, start_time=0.0, command=lambda time: np.zeros(3), **params):
        params = WalkingPatternParams(**params)
        walking = WalkingPattern(params, legs, steps=steps, start_time=start_time)
        pattern = Ticking(walking)
        pattern.fix("contact", np.ones(8))
        outputs = pattern.block.outputs
        rows = {name: np.empty((ticks, signal.size)) for name, signal in outputs.items()}
        for k in range(ticks):
            pattern.fix("walk_command", command(pattern.context.get_time()))
            for name in rows:
                rows[name][k] = pattern.output(name)
            pattern.step()
        return rows

    return play


@pytest.fixture(scope="session")
def straight_walk(play_pattern):
    """Return the signals of a pattern that starts, takes five steps and stands again."""
    return play_pattern(7500, steps=np.tile([0.3333, 0.0, 0.0, 0.0], (5, 1)))


@pytest.fixture(scope="session")
def standing():
    """Return the equilibrium of the closed loop on both feet."""
    from lola_drake.linear.studies.operating_points import situation
    from lola_drake.scenario import load_scenario

    return situation(load_scenario("stand"), "stand")


@pytest.fixture(scope="session")
def on_left():
    """Return the equilibrium of the closed loop on the left foot."""
    from lola_drake.linear.studies.operating_points import situation
    from lola_drake.scenario import load_scenario

    return situation(load_scenario("stand"), "left")
