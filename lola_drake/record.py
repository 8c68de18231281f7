"""The signals of a run on the disk: written while it runs, read when they are asked for.

The file is written in HDF5's way for one writer and many readers, so that it can be read at any
moment, also after the writing process was killed.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np

from lola_drake.atomic_file import SIGNALS, reason
from lola_drake.errors import ResultError, short
from lola_drake.logged import LOGGED
from lola_drake.scenario import Scenario, dump_scenario

ROWS = 1000
"""Samples that are written at a time (a second of them)."""

OVERHEAD = 500_000
"""What a record needs on the disk beside its numbers (bytes)."""

MOST_NUMBERS = 500_000_000
"""More than this a signal of the longest run does not have."""

PATIENCE = 20.0
"""For so long (s) HDF5 may search in a file that its writer has not closed."""

_LOOK_THROUGH = """
import sys, h5py
with h5py.File(sys.argv[1], "r", swmr=True) as file:
    for found in map(file.get, sys.argv[2:]):
        if isinstance(found, h5py.Dataset):
            found.id.get_num_chunks()
"""

_PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""A quarter less for a tenth of a simulation's time, in what MATLAB and Julia read, too."""


class Recorder:
    """Writes the signals of a run into a file, piece by piece."""

    def __init__(self, path: Path, scenario: Scenario, versions: Mapping[str, str]):
        """Begin a file; what it is about stands in its attributes.

        Raises:
            OSError: If it cannot be written.
        """
        self.path = path
        _try_out(path)
        self._file = h5py.File(path, "w", libver="latest", rdcc_nbytes=0)
        self._reserve(0)
        self._file.attrs["scenario"] = dump_scenario(scenario)
        self._file.attrs["seed"] = scenario.seed
        self._file.attrs["versions"] = json.dumps(dict(versions))
        self._times = self._dataset("time")
        self._times.attrs["units"] = "s"
        self._signals = {name: self._dataset(name, s.size) for name, s in LOGGED.items()}
        for name, signal in LOGGED.items():
            attributes = self._signals[name].attrs
            attributes["description"] = signal.doc
            attributes["names"] = signal.entry_names()
            attributes["units"] = signal.entry_units()
            attributes["frames"] = signal.entry_frames()
        self._file.swmr_mode = True

    def _dataset(self, name: str, *columns: int) -> h5py.Dataset:
        return self._file.create_dataset(
            name,
            shape=(0, *columns),
            maxshape=(None, *columns),
            chunks=(ROWS, *columns),
            dtype="f8",
            **_PACKED,
        )

    def append(self, times: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Write further samples.

        Args:
            times: of the samples (s), shape (n,).
            signals: by the names of `logged.LOGGED`, each of shape (n, size).

        Raises:
            OSError: If there is no room for all of them; what was written before stays.
        """
        first = len(self._times)
        last = first + len(times)
        new_chunks = -(-last // ROWS) - first // ROWS
        self._reserve(8 * ROWS * new_chunks * (1 + sum(s.size for s in LOGGED.values())))
        for name, dataset in self._signals.items():
            dataset.resize(last, axis=0)
            dataset[first:] = signals[name]
        # A reader takes as many samples as there are times.
        self._file.flush()
        self._times.resize(last, axis=0)
        self._times[first:] = times
        self._file.flush()

    def _reserve(self, size: int) -> None:
        """Fail where a disk has not so much space: in the middle of a file HDF5 dies of that."""
        if hasattr(os, "posix_fallocate"):
            number = self._file.id.get_vfd_handle()
            used = sum(dataset.id.get_storage_size() for dataset in self._file.values())
            there, needed = os.fstat(number).st_size, used + used // 50 + size + OVERHEAD
            if needed > there:
                os.posix_fallocate(number, there, needed - there)

    def finished(self) -> tuple[np.ndarray, "RecordedSignals"]:
        """End the file, and return the times (s) and signals in it."""
        self.close()
        return read_signals(self.path)

    def close(self) -> None:
        """End the file; nothing can be written any more."""
        with suppress(OSError, RuntimeError):
            if self._file:
                self._file.close()
                # Opened once more, HDF5 gives back what was reserved and not used.
                h5py.File(self.path, "r+").close()


def _try_out(path: Path) -> None:
    """Fail before HDF5 has begun a file for which there is no room."""
    if hasattr(os, "posix_fallocate"):
        with path.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, OVERHEAD)
        path.unlink()


class RecordedSignals(Mapping[str, np.ndarray]):
    """The signals in a file, by the names of `logged.LOGGED`, or some rows of them.

    Each is read anew whenever it is asked for, so that they need no memory before; who changes
    what they got changes no record.
    """

    def __init__(self, path: Path, rows: slice):
        """Say which rows of which file."""
        self._path, self._rows = path, rows

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a signal, shape (n, size); ResultError if its file is not there any more."""
        if name not in LOGGED:
            raise KeyError(name)
        try:
            with open_signals(self._path) as file:
                return np.asarray(file[name][self._rows], dtype=float)
        except (OSError, KeyError, RuntimeError) as error:
            raise ResultError(f"{short(str(self._path), 120)}: {reason(error)}") from None

    def __iter__(self) -> Iterator[str]:
        """Yield the names of all signals."""
        return iter(LOGGED)

    def __len__(self) -> int:
        """Return how many signals there are."""
        return len(LOGGED)

    def move(self, folder: Path) -> None:
        """Say that the file lies in another folder now."""
        self._path = folder / self._path.name

    def between(self, first: int, last: int) -> "RecordedSignals":
        """Return some of these rows."""
        start, stop = self._rows.start, self._rows.stop
        return RecordedSignals(self._path, slice(start + first, min(start + last, stop)))


def between(signals: Mapping[str, np.ndarray], first: int, last: int) -> Mapping[str, np.ndarray]:
    """Return some rows of signals, wherever they are."""
    if isinstance(signals, RecordedSignals):
        return signals.between(first, last)
    return {name: values[first:last] for name, values in signals.items()}


def open_signals(path: Path) -> h5py.File:
    """Open a file of signals for reading, also while it is written, or if its writer was killed."""
    try:
        return h5py.File(path, "r", rdcc_nbytes=0)
    except OSError as error:
        if "open for write" not in str(error):
            raise
        there = path.stat()
        _try_to_read(path, there.st_mtime_ns, there.st_size)
        return h5py.File(path, "r", swmr=True, rdcc_nbytes=0)


@lru_cache(maxsize=64)
def _try_to_read(path: Path, *state: int) -> None:
    """Look whether HDF5 comes to an end with a file that its writer has not closed.

    For one writer and many readers it tries again where a checksum is wrong, after waits that
    double a hundred times: where the file is damaged it does not return, nor can it be stopped in
    this process. So another one looks through all that has a checksum; numbers have none.

    Args:
        path: of the file.
        state: what tells the file from what it was before.

    Raises:
        OSError: If it is damaged.
    """
    command = [sys.executable, "-c", _LOOK_THROUGH, str(path), "time", *LOGGED]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    try:
        looked = subprocess.run(command, env=environment, capture_output=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        raise OSError(f"{path.name} is damaged, HDF5 finds no end in it") from None
    if looked.returncode:
        raise OSError(f"{path.name} is damaged where its run was writing")


def read_signals(path: Path) -> tuple[np.ndarray, RecordedSignals]:
    """Return times (s) and signals of a record; what a user has added is passed over.

    Raises:
        ValueError: If the file lacks something of a run.
    """
    with open_signals(path) as file:
        times = np.asarray(_dataset(file, "time", 1)[()], dtype=float)
        if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise ValueError(f"{path.name}: the times do not grow")
        for name, signal in LOGGED.items():
            shape = _dataset(file, name, 2).shape
            # Of a run that was killed some signals may have more samples than there are times.
            if shape[0] < len(times) or shape[1] != signal.size:
                raise ValueError(f"{path.name}: {name} has the shape {shape}")
    return times, RecordedSignals(path, slice(0, len(times)))


def _dataset(file: h5py.File, name: str, dimensions: int) -> h5py.Dataset:
    found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        raise ValueError(f"{SIGNALS} lacks {name}")
    numeric = found.dtype.kind in "fiu" and found.shape is not None
    if not numeric or len(found.shape) != dimensions or found.size > MOST_NUMBERS:
        raise ValueError(f"{SIGNALS}: {name} holds no numbers of a run")
    return found
