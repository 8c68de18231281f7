"""The long form of the fuzzing: python tests/fuzz.py KIND [COUNT] [SEED].

`valid` makes scenarios over the whole of the documented ranges and runs them for a moment. Each
must be completed or fall, with finite numbers and without a warning of NumPy.

`bad` makes scenarios with one thing in them that cannot be. Each must be refused by the command in
one line that names the key, the value and what is allowed, and leave nothing on the disk.

`records` damages records of runs, see `fuzz_records`. Each must be loaded, exported and reported,
or refused in one line.

`frames` sends what is no message, or one that nobody has asked for, to the page of a simulation,
see `fuzz_frames`. It must go on, and come to its end.
"""

import json
import os
import sys
import tempfile
import types
import warnings
from pathlib import Path

import numpy as np

from lola_drake.scenario import Scenario, ScenarioError, differences, override
from lola_drake.scenario_keys import Setting, settings
from lola_drake.simulation import simulate

FIXED = {"duration", "walk.start_time", "pattern.first_double_support", "name", "description"}
UNDER_ONE_FOOT = [{"position": [0.0, 0.6], "height": 0.05}]
"""A board for which the start is to blame."""

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


def bad_scenario(random: np.random.Generator) -> tuple[str, str]:
    """Return the key that is to blame, and the text of a scenario that cannot be for it."""
    known = [s for s in settings() if "[]" not in s.key and s.maximum is not None]
    setting = known[random.integers(len(known))]
    kinds = (_beyond, _no_number, _unknown_key, _no_structure, _list_entry, _against_another)
    key, value = kinds[random.integers(len(kinds))](setting, random)
    data: dict[str, object] = {}
    if value is UNDER_ONE_FOOT:
        return key, json.dumps({"ground": {"obstacles": value}})
    *folders, last = key.split(".")
    place = data
    for name in folders:
        place = place.setdefault(name, {})
    place[last] = value
    return key, json.dumps(data)


def _beyond(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    """Return a number outside its range, by little or by much."""
    low = setting.minimum if setting.above is None else setting.above
    reach = setting.maximum - low
    far = float(10.0 ** random.uniform(-3, 300))
    by = min(max(reach * far, 1.0 if isinstance(setting.default, int) else 1e-9), 1e300)
    if random.integers(2):
        value = setting.maximum + by
    else:
        value = low - by
    whole = isinstance(setting.default, int) and abs(value) < 1e15
    return setting.key, int(value) if whole else float(value)


def _no_number(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    text = "".join(chr(random.integers(32, 0x2FFF)) for _ in range(random.integers(1, 400)))
    values = (text, None, True, [], {}, [1.0], {"a": 1}, float("nan"), float("inf"), "1:30", "1_0")
    return setting.key, values[random.integers(len(values))]


def _unknown_key(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    *folders, last = setting.key.split(".")
    at = random.integers(len(last))
    return ".".join([*folders, last[:at] + "q" + last[at:]]), 1.0


def _no_structure(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    folder = setting.key.split(".")[0]
    return (folder, [1, 2]) if "." in setting.key else (f"{folder}.deeper", 1.0)


def _list_entry(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    entries = (
        ("walk.steps", [{"count": 0}]),
        ("walk.steps", [{"length": float(random.uniform(0.56, 1e6))}]),
        ("walk.steps", [{}] * int(random.integers(101, 999))),
        ("walk.command", [{"v_x": float(random.uniform(0.75, 1e6))}]),
        ("walk.command", [{"time": 1.0}, {"time": float(random.uniform(-5, 1.0))}]),
        ("ground.obstacles", [{"size": [float(random.uniform(-9, 0)), 1.0]}]),
        ("ground.obstacles", [{"size": [1.0]}]),
        ("ground.obstacles", [{"name": "a\x1bb", "position": [3.0, 0.0]}]),
        ("ground.obstacles", [{"position": [9.0, 0.0]}] * 2),
        ("ground.obstacles", random.standard_normal(int(random.integers(1, 50))).tolist()),
    )
    return entries[random.integers(len(entries))]


def _against_another(setting: Setting, random: np.random.Generator) -> tuple[str, object]:
    """Return a value that is in its range, and that another key's does not allow."""
    entries = (
        ("pattern.double_support", float(random.uniform(0.61, 0.9))),
        ("pattern.com_height", 0.92 + float(random.uniform(0.001, 1.0))),
        ("sensors.contact.open_force", float(random.uniform(20.0, 60.0))),
        ("start", UNDER_ONE_FOOT),
    )
    return entries[random.integers(len(entries))]


def refuse(count: int, seed: int) -> None:
    """Make so many bad scenarios; print those that are not refused as they must be."""
    from typer.testing import CliRunner

    from lola_drake.cli.app import app

    def never(*_, **__):
        raise AssertionError("it runs")

    sys.modules["lola_drake.simulation"] = types.SimpleNamespace(simulate=never)
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for number in range(seed, seed + count):
            key, text = bad_scenario(np.random.default_rng(number))
            Path("my.yaml").write_text(text, encoding="utf-8")
            told = complaint(CliRunner().invoke(app, ["simulate", "my.yaml"]), key)
            if told or os.listdir() != ["my.yaml"]:
                wrong += 1
                print(number, text[:200], told, os.listdir(), flush=True)
        os.chdir("/")
    print(f"{count} bad scenarios, {wrong} of them not refused as they must be")


def complaint(done, key: str) -> str:
    """Return what is wrong with how a command has refused a key, or nothing."""
    lines = done.stderr.splitlines()
    if done.exit_code != 2 or done.stdout or len(lines) != 1:
        return f"exit code {done.exit_code}, {lines[:3]}, {done.exception!r}"
    (line,) = lines
    if len(line) > 200 or not line.isprintable():
        return f"{len(line)} characters: {line!r}"
    names = key.split(".")
    found = any(name in line for name in names[-2:])
    allowed = any(text in line for text in ("it must be", "no such key", "did you mean"))
    return "" if found and allowed else f"does not say enough: {line}"


def run(count: int, seed: int) -> None:
    """Run so many scenarios; print those that are not as they must be."""
    warnings.simplefilter("error")
    ends: dict[str, int] = {}
    wrong = 0
    for number in range(seed, seed + count):
        scenario = valid_scenario(np.random.default_rng(number))
        try:
            result = simulate(scenario)
            fine = result.completed or result.fall_time is not None
            fine = fine and all(map(np.isfinite, numbers(result.summary)))
            end = result.end
        except Exception as error:
            fine, end = False, f"{type(error).__name__}: {error}"
        if not fine:
            print(number, end, differences(scenario), flush=True)
        wrong += not fine
        ends[end.split()[0]] = ends.get(end.split()[0], 0) + 1
    print(f"{count} valid scenarios, {wrong} of them not as they must be: {ends}")


def numbers(value: object) -> list[float]:
    """Return all numbers in nested plain data."""
    if isinstance(value, dict):
        return [number for entry in value.values() for number in numbers(entry)]
    return [value] if isinstance(value, float) else []


def damage_records(count: int, seed: int) -> None:
    """Damage so many records; print those that are not answered as they must be."""
    from fuzz_records import try_records

    with tempfile.TemporaryDirectory() as folder:
        wrong = try_records(count, seed, Path(folder))
    print(f"{count} damaged records, {wrong} of them not answered as they must be")


def send_frames(count: int, seed: int) -> None:
    """Send so many frames to simulations; print those that do not come to their end."""
    from fuzz_frames import try_frames

    wrong = try_frames(count, seed)
    print(f"{count} frames, {wrong} simulations ended by them")


def main(kind: str = "valid", count: str = "20", seed: str = "0") -> None:
    """Do one of them."""
    kinds = {"valid": run, "bad": refuse, "records": damage_records, "frames": send_frames}
    kinds[kind](int(count), int(seed))


if __name__ == "__main__":
    main(*sys.argv[1:])
