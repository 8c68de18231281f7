"""The record of one run: its signals and metrics, saved to a folder and loaded again."""

import importlib.metadata
import json
import math
import os
import platform
import re
import shutil
import uuid
from collections.abc import Iterator, Set
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path

import h5py
import numpy as np

from lola_drake.logged import LOGGED
from lola_drake.metrics import Limits, metrics
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario, dump_scenario, load_scenario
from lola_drake.typed_yaml import leaves

SUMMARY, SIGNALS, SCENARIO = "summary.json", "signals.h5", "scenario.yaml"
RUN_FILES = frozenset({SUMMARY, SIGNALS, SCENARIO})


class ResultError(ValueError):
    """A run that cannot be saved or loaded; the message is one line that says why."""


def software_versions() -> dict[str, str]:
    """Return the versions of all software that a run's numbers depend on."""
    versions = {"python": platform.python_version()}
    for package in ("lola_drake", "drake", "numpy", "scipy"):
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """One run.

    Attributes:
        scenario: What was run.
        times: Simulated time of each sample (s), shape (n,).
        signals: By the names of `logged.LOGGED`, each of shape (n, size).
        completed: Whether the run reached the end of its scenario; a fall and an interruption
            end it early.
        fall_time: When the robot fell (s), None if it did not.
        wall_time: How long the simulation took (s).
        versions: Of the software.
    """

    scenario: Scenario
    times: np.ndarray
    signals: dict[str, np.ndarray]
    completed: bool
    fall_time: float | None
    wall_time: float
    versions: dict[str, str] = field(default_factory=software_versions)

    def __post_init__(self):
        for name, values in self.signals.items():
            shape = (len(self.times), LOGGED[name].size)
            if values.shape != shape:
                raise ValueError(f"{name} has shape {values.shape} instead of {shape}")

    def __repr__(self) -> str:
        name, variant = self.scenario.name, self.scenario.variant
        return f"<Result {name} ({variant}, seed {self.scenario.seed}): {self._ending()}>"

    def _repr_html_(self) -> str:
        name, variant = self.scenario.name, self.scenario.variant
        told = {"scenario", "variant", "seed", "versions", "completed", "fell", "fall_time_s"}
        cells = "".join(
            f"<tr><td style='text-align: left'>{escape(key)}</td><td>{_short(value)}</td></tr>"
            for key, value in leaves(self.summary).items()
            if key.split(".")[0] not in told
        )
        return f"<b>{escape(name)}</b> ({variant}): {self._ending()}<table>{cells}</table>"

    def _ending(self) -> str:
        if self.fall_time is not None:
            return f"fell at {self.fall_time:.2f} s"
        return f"{self.duration:.3g} s, " + ("completed" if self.completed else "interrupted")

    @property
    def duration(self) -> float:
        """Return the time that was simulated (s)."""
        return float(self.times[-1]) if len(self.times) else 0.0

    @cached_property
    def metrics(self) -> dict[str, object]:
        """Return the metrics of the run; after a fall nothing counts any more."""
        fall_time = math.inf if self.fall_time is None else self.fall_time
        standing = self.times <= fall_time
        signals = {name: values[standing] for name, values in self.signals.items()}
        limits = run_limits(self.scenario)
        return _finite(metrics(self.times[standing], signals, limits))

    @property
    def summary(self) -> dict[str, object]:
        """Return the content of summary.json."""
        return {
            "scenario": self.scenario.name,
            "variant": self.scenario.variant,
            "seed": self.scenario.seed,
            "duration_s": self.duration,
            "completed": bool(self.completed),
            "fell": self.fall_time is not None,
            "fall_time_s": self.fall_time,
            **self.metrics,
            "wall_time_s": self.wall_time,
            "real_time_factor": self.duration / self.wall_time,
            "versions": self.versions,
        }

    def save(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the run into a folder of its own, wholly or not at all.

        Args:
            folder: Must not hold anything, unless `force`.
            force: Replace the run that the folder holds.

        Raises:
            ResultError: If the folder cannot be used or written; it is then as it was.
        """
        with whole_folder(folder, force=force) as partial:
            _write(self, partial)
        return Path(folder).resolve()


@contextmanager
def whole_folder(
    folder: str | Path, *, force: bool, files: Set[str] = RUN_FILES, what: str = "run"
) -> Iterator[Path]:
    """Give a folder to write into, which takes the place of `folder` when all is written.

    Raises:
        ResultError: If the folder cannot be used (see `check_folder`) or written; it is then as
            it was.
    """
    folder = check_folder(folder, force=force, files=files, what=what)
    partial = folder.with_name(f".{folder.name}-{uuid.uuid4().hex}")
    try:
        partial.mkdir(parents=True)
        yield partial
        _replace(folder, partial)
    except (OSError, RuntimeError) as error:
        raise ResultError(f"{folder}: cannot be written, {_reason(error)}") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def run_limits(scenario: Scenario) -> Limits:
    """Return the limits of LOLA's joints and of the scenario's ground."""
    robot = Kinematics()
    lower, upper = robot.position_limits
    friction = scenario.ground.friction
    return Limits(lower, upper, robot.velocity_limits, robot.effort_limits, friction)


def check_folder(
    folder: str | Path, *, force: bool = False, files: Set[str] = RUN_FILES, what: str = "run"
) -> Path:
    """Return the folder's full path if it can be written; ResultError if not.

    Args:
        folder: Must not hold anything, unless `force`.
        force: Whether it may be replaced if it holds what is going to be written.
        files: By which files that is known.
        what: How it is called in errors.
    """
    folder = Path(folder).resolve()
    try:
        content = os.listdir(folder)
    except FileNotFoundError:
        content = []
    except OSError as error:
        raise ResultError(f"{folder}: {error.strerror}") from None
    if content and not files <= set(content):
        raise ResultError(f"{folder}: holds something that is not a {what}, choose another folder")
    if content and not force:
        raise ResultError(f"{folder}: holds a {what} already, choose another folder or force it")
    existing = next(parent for parent in folder.parents if parent.exists())
    if not os.access(existing, os.W_OK | os.X_OK):
        raise ResultError(f"{folder}: cannot be written, no permission in {existing}")
    return folder


def load_result(folder: str | Path) -> Result:
    """Return the run that `Result.save` wrote into a folder.

    Raises:
        ResultError: If there is no run in the folder, or it cannot be read.
    """
    folder = Path(folder)
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        with h5py.File(folder / SIGNALS) as file:
            signals = {name: dataset[:] for name, dataset in file.items()}
        return Result(
            scenario=load_scenario(folder / SCENARIO),
            times=signals.pop("time"),
            signals=signals,
            completed=summary["completed"],
            fall_time=summary["fall_time_s"],
            wall_time=summary["wall_time_s"],
            versions=summary["versions"],
        )
    except FileNotFoundError:
        raise ResultError(f"{folder}: holds no run") from None
    except (OSError, KeyError, ValueError) as error:
        raise ResultError(f"{folder}: cannot be read, {_reason(error)}") from None


def _write(result: Result, folder: Path) -> None:
    scenario = dump_scenario(result.scenario)
    summary = json.dumps(result.summary, indent=2, allow_nan=False)
    (folder / SCENARIO).write_text(scenario, encoding="utf-8")
    (folder / SUMMARY).write_text(summary + "\n", encoding="utf-8")
    with h5py.File(folder / SIGNALS, "w") as file:
        file.attrs["scenario"] = scenario
        file.attrs["seed"] = result.scenario.seed
        file.attrs["versions"] = json.dumps(result.versions)
        file["time"] = result.times
        file["time"].attrs["units"] = "s"
        for name, values in result.signals.items():
            # Plain: compression saves a fifth and takes thirty times as long.
            file[name] = values
            attributes, signal = file[name].attrs, LOGGED[name]
            attributes["description"] = signal.doc
            attributes["names"] = signal.entry_names()
            attributes["units"] = signal.entry_units()
            attributes["frames"] = signal.entry_frames()


def _replace(folder: Path, partial: Path) -> None:
    retired = partial.with_name(partial.name + "-old")
    if folder.exists():
        folder.rename(retired)
    partial.rename(folder)
    shutil.rmtree(retired, ignore_errors=True)


def _finite(value: object) -> object:
    """Return the value with None for every number that JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _short(value: object) -> str:
    return "–" if value is None else f"{value:.4g}"


def _reason(error: Exception) -> str:
    """Return what went wrong in a few words; HDF5 hides it in the middle of a long text."""
    in_hdf5 = re.search(r"error message = '([^']*)'", str(error))
    if in_hdf5:
        return in_hdf5[1]
    return getattr(error, "strerror", None) or " ".join(str(error).split())
