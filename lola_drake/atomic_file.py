"""Files and folders that are written wholly or not at all, and whether they can be."""

import itertools
import json
import os
import re
import shutil
import uuid
from collections.abc import Iterator, Set
from contextlib import contextmanager, suppress
from pathlib import Path

from lola_drake.errors import LolaError, OutputError, ResultError, short

SUMMARY, SIGNALS, SCENARIO = "summary.json", "signals.h5", "scenario.yaml"
RUN_FILES = frozenset({SUMMARY, SIGNALS, SCENARIO})
"""By which a run's folder is known."""


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a path to write to, which becomes `path` when everything has been written.

    A missing folder is made. The ending stays the same, for those who look at it.

    Raises:
        OutputError: If the file cannot be written; what was there before is then still there.
    """
    path = Path(path)
    partial = path.with_name(f".{uuid.uuid4().hex}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        partial.replace(path)
    except OSError as error:
        raise OutputError(f"{_named(path)}: cannot be written, {reason(error)}") from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def write_json(content: object, path: str | Path) -> None:
    """Write plain data as JSON, wholly or not at all."""
    with whole_file(path) as file:
        file.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def check_file(path: str | Path, *, force: bool = False) -> Path:
    """Return a path to which a file can be written, before there is anything to write.

    Args:
        path: Of the file; must not be there yet, unless `force`.
        force: Whether it may be replaced.

    Raises:
        OutputError: If it cannot be written.
    """
    path = Path(path)
    name = _named(path)
    try:
        if path.is_dir():
            raise OutputError(f"{name}: a folder, not the name of a file")
        if path.exists() and not force:
            raise OutputError(f"{name}: is there already, choose another name or --force")
        _try_out(path)
    except (OSError, ValueError) as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"{name}: cannot be written, {reason(error)}") from None
    return path


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
        raise ResultError(f"{_named(folder)}: cannot be written, {reason(error)}") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@contextmanager
def growing_folder(
    folder: str | Path, *, force: bool, files: Set[str] = RUN_FILES, what: str = "run"
) -> Iterator[Path]:
    """Give a folder to write into, which takes the place of `folder` in the end.

    Until then it is called FOLDER.part. If its process is killed, or something goes wrong, it stays
    with what has been written, as soon as that is a whole one of its kind.

    Raises:
        ResultError: If the folder cannot be used (see `check_folder`) or written.
    """
    folder = check_folder(folder, force=force, files=files, what=what)
    part = _made_beside(folder)
    try:
        yield part
        # Meanwhile somebody else may have written there.
        check_folder(folder, force=force, files=files, what=what)
        _replace(folder, part)
    except (OSError, RuntimeError, LolaError) as error:
        told = isinstance(error, LolaError)
        text = str(error) if told else f"{_named(folder)}: cannot be written, {reason(error)}"
        raise ResultError(text + _kept(part, files)) from None
    except BaseException:
        _kept(part, files)
        raise


def _kept(part: Path, files: Set[str]) -> str:
    """Say that a folder is kept if it is a whole one of its kind, or take it away."""
    if files <= set(os.listdir(part)):
        return f"; what was recorded is kept in {_named(part)}"
    shutil.rmtree(part, ignore_errors=True)
    return ""


def _made_beside(folder: Path) -> Path:
    """Make FOLDER.part, or FOLDER.part2 where that is there already, and so on."""
    for i in itertools.count(1):
        part = folder.with_name(f"{folder.name}.part{i if i > 1 else ''}")
        try:
            part.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise ResultError(f"{_named(folder)}: cannot be written, {reason(error)}") from None
        return part
    raise AssertionError


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
    name = _named(folder)
    try:
        folder = Path(folder).resolve()
        name = _named(folder)
        here = Path.cwd()
        if folder == here or folder in here.parents or os.path.ismount(folder):
            # Replacing it would pull the ground from under the user's shell.
            raise ResultError(f"{name}: is in use as a whole, choose a folder in it")
        content = set(os.listdir(folder)) if folder.exists() else set()
        if content and not files <= content:
            raise ResultError(
                f"{name}: holds something that is not a {what}, choose another folder"
            )
        if content and not force:
            raise ResultError(f"{name}: holds a {what} already, choose another folder or --force")
        _try_out(folder)
    except (OSError, ValueError) as error:
        if isinstance(error, ResultError):
            raise
        raise ResultError(f"{name}: cannot be written, {reason(error)}") from None
    return folder


def _try_out(path: Path) -> None:
    """Make a folder beside a path, and take it away again with all that was made for it."""
    parent = path.absolute().parent
    made = [folder for folder in (parent, *parent.parents) if not folder.exists()]
    trial = parent / f".{path.name}-{uuid.uuid4().hex}-old"
    try:
        trial.mkdir(parents=True)
    finally:
        for folder in (trial, *made):
            with suppress(OSError):
                folder.rmdir()


def _replace(folder: Path, partial: Path) -> None:
    retired = partial.with_name(partial.name + "-old")
    if folder.exists():
        folder.rename(retired)
    partial.rename(folder)
    shutil.rmtree(retired, ignore_errors=True)


def _named(path: str | Path) -> str:
    return short(str(path), 120)


def reason(error: BaseException) -> str:
    """Return what went wrong in a few words; HDF5 hides it in the middle of a long text."""
    in_hdf5 = re.search(r"error message = '([^']*)'", str(error))
    if in_hdf5:
        return in_hdf5[1]
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return short(" ".join(text.split()), 120)
