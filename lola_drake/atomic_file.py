"""Files that are written wholly or not at all, and the error when they cannot be."""

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lola_drake.errors import OutputError


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
        raise OutputError(f"{path}: cannot be written, {error.strerror or error}") from None
    finally:
        try:
            partial.unlink(missing_ok=True)
        except OSError:
            pass
