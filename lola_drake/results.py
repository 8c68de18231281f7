"""The record of one run: its signals and metrics, saved to a folder and loaded again."""

import importlib.metadata
import json
import math
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lola_drake.atomic_file import (
    SCENARIO,
    SIGNALS,
    SUMMARY,
    reason,
    whole_folder,
)
from lola_drake.atomic_file import check_folder as check_folder
from lola_drake.disturbances import disturbances
from lola_drake.errors import ResultError, short, shown
from lola_drake.limits import Limits
from lola_drake.logged import LOGGED
from lola_drake.metrics import metrics
from lola_drake.record import ROWS, RecordedSignals, Recorder, between, read_signals
from lola_drake.robot import Kinematics
from lola_drake.scenario import Scenario, dump_scenario, load_scenario
from lola_drake.typed_yaml import leaves

UNFINISHED = "it is still running, or its process was killed"
"""The error of a record whose run has not come to any end."""


def software_versions() -> dict[str, str]:
    """Return the versions of all software that a run's numbers depend on."""
    versions = {"python": platform.python_version()}
    for package in ("lola_drake", "drake", "mujoco", "numpy", "scipy"):
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
        signals: By the names of `logged.LOGGED`, each of shape (n, size); those of a folder
            are read when they are asked for.
        completed: Whether the run reached the end of its scenario; a fall and an interruption
            end it early.
        fall_time: When the robot fell (s), None if it did not.
        wall_time: How long the simulation took (s).
        versions: Of the software.
        error: What ended the run in one line, where it was neither a fall nor its user.
        engine: What ran it, see `simulate`; None if its record does not say.
    """

    scenario: Scenario
    times: np.ndarray
    signals: Mapping[str, np.ndarray]
    completed: bool
    fall_time: float | None
    wall_time: float
    versions: dict[str, str] = field(default_factory=software_versions)
    error: str | None = None
    engine: str | None = None

    def __repr__(self):
        scenario = self.scenario
        return f"<Result of {scenario.name} ({scenario.variant}): {self.end}>"

    @property
    def interrupted(self) -> bool:
        """Return whether its user has ended the run."""
        return not self.completed and self.fall_time is None and self.error is None

    @property
    def end(self) -> str:
        """Return how the run ended, in a few words."""
        at = f"at {self.duration:.3f} s"
        if self.fall_time is not None:
            return f"fell at {self.fall_time:.3f} s"
        if self.error is not None:
            return f"failed {at}: {self.error}"
        return f"interrupted {at}" if self.interrupted else f"completed {at}"

    def __post_init__(self):
        if isinstance(self.signals, RecordedSignals):
            return  # Looked at when they were found.
        for name, values in self.signals.items():
            shape = (len(self.times), LOGGED[name].size)
            if values.shape != shape:
                raise ValueError(f"{name} has shape {values.shape} instead of {shape}")

    def _repr_html_(self) -> str:
        name, variant = self.scenario.name, self.scenario.variant
        told = {"scenario", "variant", "seed", "versions", "completed", "fell", "fall_time_s"}
        told |= {"error", "engine", "law", "disturbances"}
        cells = "".join(
            f"<tr><td style='text-align: left'>{escape(key)}</td><td>{_short(value)}</td></tr>"
            for key, value in leaves(self.summary).items()
            if key.split(".")[0] not in told
        )
        return f"<b>{escape(name)}</b> ({variant}): {self.end}<table>{cells}</table>"

    @property
    def duration(self) -> float:
        """Return the time that was simulated (s)."""
        return float(self.times[-1]) if len(self.times) else 0.0

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Return the metrics of the run; after a fall nothing counts any more."""
        fall_time = math.inf if self.fall_time is None else self.fall_time
        standing = int(np.searchsorted(self.times, fall_time, "right"))
        signals = between(self.signals, 0, standing)
        return _finite(metrics(self.times[:standing], signals, run_limits(self.scenario)))

    @property
    def summary(self) -> dict[str, Any]:
        """Return the content of summary.json."""
        return {
            "scenario": self.scenario.name,
            "variant": self.scenario.variant,
            "law": self.scenario.active_control().law,
            "seed": self.scenario.seed,
            "duration_s": self.duration,
            "completed": bool(self.completed),
            "fell": self.fall_time is not None,
            "fall_time_s": self.fall_time,
            "error": self.error,
            "engine": self.engine,
            "disturbances": disturbances(self.scenario),
            **self.metrics,
            "wall_time_s": self.wall_time,
            "real_time_factor": self.duration / self.wall_time if self.wall_time else None,
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


def run_limits(scenario: Scenario) -> Limits:
    """Return the limits of LOLA's joints and of the scenario's ground."""
    robot = Kinematics()
    lower, upper = robot.position_limits
    return Limits(lower, upper, robot.velocity_limits, robot.effort_limits, scenario.terrain)


def load_result(folder: str | Path) -> Result:
    """Return the run that `Result.save` wrote into a folder; what else lies there is left alone.

    Args:
        folder: Such as `runs/walk_flat`.

    Raises:
        ResultError: If there is no run in the folder, or it cannot be read.
    """
    folder = Path(folder)
    name = short(str(folder), 120)
    try:
        summary = _read_summary(folder / SUMMARY)
        times, signals = read_signals(folder / SIGNALS)
        return Result(
            scenario=load_scenario(folder / SCENARIO), times=times, signals=signals, **summary
        )
    except FileNotFoundError:
        raise ResultError(f"{name}: holds no run") from None
    except (OSError, LookupError, ValueError, RuntimeError, MemoryError, TypeError) as error:
        raise ResultError(f"{name}: cannot be read, {reason(error)}") from None


def _read_summary(path: Path) -> dict[str, Any]:
    """Return what a run needs of its summary; the rest follows from the signals."""
    content = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict):
        raise ValueError(f"{path.name} is no summary")
    versions = content.get("versions", {})
    kept = {
        "completed": content.get("completed"),
        "fall_time": content.get("fall_time_s"),
        "wall_time": content.get("wall_time_s"),
        "error": content.get("error"),
        "engine": content.get("engine"),
    }
    right = {
        "completed": isinstance(kept["completed"], bool),
        "fall_time": kept["fall_time"] is None or _is_time(kept["fall_time"]),
        "wall_time": _is_time(kept["wall_time"]),
        "error": kept["error"] is None or isinstance(kept["error"], str),
        "engine": kept["engine"] is None or isinstance(kept["engine"], str),
        "versions": isinstance(versions, dict),
    }
    for name, fits in right.items():
        if not fits:
            value = versions if name == "versions" else kept[name]
            raise ValueError(f"{path.name}: {name} is {shown(value)}")
    return kept | {"versions": {str(name): str(text) for name, text in versions.items()}}


def _is_time(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return 0 <= value <= 1e9


@contextmanager
def recording(folder: Path, scenario: Scenario) -> Iterator[Recorder]:
    """Give what writes the signals of a run into a folder, which at once is that of a run.

    Until there is a summary of the whole (see `write_summary`), it says that it has not ended.

    Raises:
        OSError: If it cannot be written.
    """
    nothing = {name: np.zeros((0, signal.size)) for name, signal in LOGGED.items()}
    begun = Result(scenario, np.zeros(0), nothing, False, None, 0.0, error=UNFINISHED)
    recorder = Recorder(folder / SIGNALS, scenario, begun.versions)
    try:
        (folder / SCENARIO).write_text(dump_scenario(scenario), encoding="utf-8")
        write_summary(begun, folder)
        yield recorder
    finally:
        recorder.close()


def _write(result: Result, folder: Path) -> None:
    with recording(folder, result.scenario) as recorder:
        for first in range(0, len(result.times), ROWS):
            rows = slice(first, first + ROWS)
            recorder.append(result.times[rows], between(result.signals, rows.start, rows.stop))
    write_summary(result, folder)


def write_summary(result: Result, folder: Path) -> None:
    """Write how a run ended to its signals in a folder, in place of what stands there."""
    text = json.dumps(result.summary, indent=2, allow_nan=False) + "\n"
    partial = folder / f".{SUMMARY}"
    partial.write_text(text, encoding="utf-8")
    partial.replace(folder / SUMMARY)


def _finite(value: Any) -> Any:
    """Return the value with None for every number that JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _short(value: object) -> str:
    return "–" if value is None else f"{value:.4g}"
