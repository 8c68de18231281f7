"""Records that something has happened to, for `fuzz.py records`: who loads one gets one line.

Each is made of a whole record by overwriting, cutting or emptying a part of one of its files, or
by another value of one of its keys, and is then read by a process of its own, since a damaged file
may keep HDF5 for ever.
"""

import json
import multiprocessing
import os
import shutil
import warnings
from pathlib import Path

import h5py
import numpy as np

from lola_drake.errors import LolaError
from lola_drake.logged import LOGGED
from lola_drake.record import PATIENCE
from lola_drake.results import Result, load_result, recording
from lola_drake.scenario import Scenario

LONGEST = PATIENCE + 100.0
"""After this (s) what reads a record counts as hanging; a page of it takes its time."""

VALUES = (
    None,
    True,
    -1,
    0,
    10**400,
    float("nan"),
    float("inf"),
    1e300,
    "",
    "x" * 5000,
    [],
    {},
    [1],
)


def make_records(folder: Path) -> list[Path]:
    """Write a short record, and one of a run that was killed; return both."""
    times = np.arange(1100) / 1000
    random = np.random.default_rng(0)
    signals = {n: random.standard_normal((len(times), s.size)) for n, s in LOGGED.items()}
    for name in signals:
        if name.endswith("_pose") or name == "gait_phase":
            signals[name] *= 0.01
    whole = Result(Scenario(), times, signals, True, None, 1.0)
    process = multiprocessing.get_context("fork").Process(
        target=_killed, args=(whole, folder / "k")
    )
    process.start()
    process.join()
    return [whole.save(folder / "whole"), folder / "k"]


def _killed(result: Result, folder: Path) -> None:
    folder.mkdir()
    with recording(folder, result.scenario) as recorder:
        recorder.append(result.times, result.signals)
        os._exit(0)


def damage(folder: Path, random: np.random.Generator) -> str:
    """Do something to a record; return what."""
    kinds = (_bytes, _bytes, _bytes, _key, _key, _dataset)
    return kinds[random.integers(len(kinds))](folder, random)


def _bytes(folder: Path, random: np.random.Generator) -> str:
    path = folder / str(
        random.choice(["signals.h5", "signals.h5", "summary.json", "scenario.yaml"])
    )
    data = bytearray(path.read_bytes())
    # HDF5's own data are where a file begins, numbers everywhere.
    end = min(len(data), int(random.choice([2000, 20_000, 200_000, len(data)])))
    at, count = int(random.integers(end)), int(random.integers(1, 64))
    kind = random.integers(4)
    if kind == 0:
        data[at] ^= 1 << random.integers(8)
    elif kind == 1:
        data[at : at + count] = random.bytes(count)
    elif kind == 2:
        del data[at : at + count]
    else:
        del data[at:]
    path.write_bytes(data)
    return f"{path.name}: {('a bit', 'overwritten', 'cut out', 'cut off')[kind]} at {at}, {count}"


def _key(folder: Path, random: np.random.Generator) -> str:
    path = folder / "summary.json"
    content = json.loads(path.read_text())
    key, value = str(random.choice(list(content))), VALUES[random.integers(len(VALUES))]
    if random.integers(4) == 0:
        del content[key]
        value = "nothing"
    else:
        content[key] = value
    path.write_text(json.dumps(content))
    return f"summary.json: {key} is {str(value)[:30]}"


def _dataset(folder: Path, random: np.random.Generator) -> str:
    name = str(random.choice(["time", *LOGGED]))
    values = (
        *(np.nan, "noon", np.zeros(0), np.zeros((3, 3)), np.full((1100, 3), np.nan), None),
        *(h5py.SoftLink("/nowhere"), h5py.ExternalLink("/dev/zero", "/x"), h5py.SoftLink("/")),
    )
    value = values[random.integers(len(values))]
    try:
        with h5py.File(folder / "signals.h5", "a") as file:
            old = file.pop(name)
            if value is None:
                numbers = old[()]
                numbers[random.integers(len(numbers), size=9)] = random.choice(
                    [np.nan, np.inf, 1e300, -1e300]
                )
                value = numbers
            file[name] = value
    except OSError:
        return "nothing: the writer of this one was killed"
    return f"signals.h5: {name} is {str(value)[:40]!r}"


def tried(folder: Path, uses: int, longest: float = LONGEST) -> str:
    """Load, export and report a record in a process of its own; return what is wrong with that.

    Args:
        folder: Of the record.
        uses: 0: load it and ask for its numbers; 1: export it, too; 2: report it, too.
        longest: After which time it hangs (s).
    """
    fork = multiprocessing.get_context("fork")
    here, there = fork.Pipe(duplex=False)
    process = fork.Process(target=_use, args=(folder, uses, there))
    process.start()
    there.close()
    process.join(longest)
    if process.is_alive():
        process.kill()
        process.join()
        return "hangs"
    return here.recv() if here.poll() else f"ended with {process.exitcode}"


def _use(folder: Path, uses: int, told) -> None:
    warnings.simplefilter("ignore")
    wrong = ""
    steps = (_load, _export, _report)[: uses + 1]
    for step in steps:
        try:
            step(folder)
        except LolaError as error:
            text = str(error)
            if "\n" in text or not text.isprintable() or len(text) > 400:
                wrong = f"{step.__name__[1:]}: no line: {text[:300]!r}"
        except BaseException as error:
            wrong = f"{step.__name__[1:]}: {type(error).__name__}: {str(error)[:200]}"
    told.send(wrong)


def _load(folder: Path) -> None:
    result = load_result(folder)
    json.dumps(result.summary, allow_nan=False)
    for values in result.signals.values():
        values.sum()


def _export(folder: Path) -> None:
    from lola_drake.mcap_export import export_mcap

    export_mcap(load_result(folder), folder / "signals.mcap", rate=100.0)


def _report(folder: Path) -> None:
    from lola_drake.reports.run_report import write_report

    write_report([load_result(folder)], folder / "report.html")


def try_records(count: int, seed: int, folder: Path) -> int:
    """Damage so many records; print those that are not answered as they must be, and count them."""
    records = make_records(folder)
    wrong = 0
    for number in range(seed, seed + count):
        random = np.random.default_rng(number)
        copy = folder / "copy"
        shutil.copytree(records[int(random.integers(4) == 0)], copy)
        what = damage(copy, random)
        told = tried(copy, int(random.choice([0, 1, 2], p=[0.7, 0.2, 0.1])))
        shutil.rmtree(copy)
        if told:
            wrong += 1
            print(number, what, "->", told, flush=True)
    return wrong
