"""The long form of the fuzzing: python tests/fuzz.py [COUNT] [SEED].

Makes valid scenarios over the whole of the documented ranges and runs them for a moment. Each must
be completed or fall, with finite numbers and without a warning of NumPy.
"""

import sys
import warnings

import numpy as np

from lola_drake.scenario import Scenario, ScenarioError, differences, override
from lola_drake.scenario_keys import Setting, settings
from lola_drake.simulation import simulate

FIXED = {"duration", "walk.start_time", "pattern.first_double_support", "name", "description"}
CHANGED = 12
"""Settings of one scenario that are not at their defaults."""


def value_of(setting: Setting, random: np.random.Generator) -> object:
    """Return a value anywhere in a setting's range, its ends among them."""
    if isinstance(setting.default, bool):
        return bool(random.integers(2))
    low = setting.minimum if setting.above is None else np.nextafter(setting.above, np.inf)
    ends, inside = [low, setting.maximum], random.uniform(low, setting.maximum)
    if low > 0 and random.integers(2):
        inside = float(np.exp(random.uniform(np.log(low), np.log(setting.maximum))))
    value = ends[random.integers(2)] if random.integers(4) == 0 else inside
    return int(value) if isinstance(setting.default, int) else float(value)


def valid_scenario(random: np.random.Generator) -> Scenario:
    """Return a scenario that walks at once, with some settings anywhere in their ranges."""
    known = [s for s in settings() if s.key not in FIXED and "[]" not in s.key]
    known = [s for s in known if isinstance(s.default, (int, float))]
    while True:
        step = {
            "count": 3,
            "length": random.uniform(-0.55, 0.55),
            "turn_deg": random.uniform(-9, 9),
        }
        changes = {
            "duration": 1.2,
            "variant": str(random.choice(["ref", "dyn", "original"])),
            "walk.start_time": 0.0,
            "pattern.first_double_support": 0.3,
            "walk.steps": [step],
        }
        chosen = random.choice(len(known), CHANGED, replace=False)
        changes |= {known[i].key: value_of(known[i], random) for i in chosen}
        try:
            return override(Scenario(), changes)
        except ScenarioError:
            continue


def main(count: int = 20, seed: int = 0) -> None:
    """Run so many scenarios; print those that are not as they must be."""
    warnings.simplefilter("error")
    ends: dict[str, int] = {}
    for number in range(seed, seed + count):
        scenario = valid_scenario(np.random.default_rng(number))
        try:
            result = simulate(scenario)
            fine = result.error is None and all(map(np.isfinite, numbers(result.summary)))
            end = result.end
        except Exception as error:
            fine, end = False, f"{type(error).__name__}: {error}"
        if not fine:
            print(number, end, differences(scenario), flush=True)
        ends[end.split()[0]] = ends.get(end.split()[0], 0) + 1
    print(ends)


def numbers(value: object) -> list[float]:
    """Return all numbers in nested plain data."""
    if isinstance(value, dict):
        return [number for entry in value.values() for number in numbers(entry)]
    return [value] if isinstance(value, float) else []


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
