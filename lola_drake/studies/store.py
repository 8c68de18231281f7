"""The file of a study: a SQLite database with a row for each run.

Every row is a transaction of its own, so a study that is killed keeps all that is done, another
process may read while one writes, and two may write. A run's scenario is kept as what it changes of
its software's defaults, which are kept once: together they are the whole of it.
"""

import json
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from lola_drake.errors import ResultError, short
from lola_drake.studies.row import Row, Summary

APPLICATION = 0x4C4F4C41
"""By which SQLite files of ours are known ("LOLA")."""

VERSION = 1
"""Of the tables; another one is refused."""

PATIENCE = 60.0
"""How long to wait for another process that is writing (s)."""

TABLES = (
    """CREATE TABLE software (
        id INTEGER PRIMARY KEY,
        digest TEXT NOT NULL UNIQUE,
        versions TEXT NOT NULL,
        defaults TEXT NOT NULL)""",
    """CREATE TABLE runs (
        id INTEGER PRIMARY KEY,
        key TEXT NOT NULL UNIQUE,
        software INTEGER NOT NULL REFERENCES software,
        name TEXT NOT NULL,
        variant TEXT NOT NULL,
        seed INTEGER NOT NULL,
        changes TEXT NOT NULL,
        outcome TEXT NOT NULL,
        summary TEXT NOT NULL,
        wall_time REAL,
        worker TEXT NOT NULL,
        tries INTEGER NOT NULL,
        finished TEXT NOT NULL)""",
    """CREATE TABLE orders (
        id INTEGER PRIMARY KEY,
        wanted INTEGER NOT NULL,
        there INTEGER NOT NULL,
        runs INTEGER NOT NULL,
        began TEXT NOT NULL)""",
)

SOFTWARE = """
    INSERT INTO software (digest, versions, defaults) VALUES (?, ?, ?)
    ON CONFLICT (digest) DO NOTHING
"""

RUN = """
    INSERT INTO runs (key, software, name, variant, seed, changes, summary, outcome, wall_time,
                      worker, tries, finished)
    VALUES (?, (SELECT id FROM software WHERE digest = ?), ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
    ON CONFLICT (key) DO UPDATE SET
        outcome = excluded.outcome, summary = excluded.summary, wall_time = excluded.wall_time,
        worker = excluded.worker, tries = excluded.tries, finished = excluded.finished
    WHERE runs.outcome = 'lost'
"""


class Store:
    """A study's file.

    Attributes:
        file: its path.
    """

    def __init__(self, file: str | Path, *, must_exist: bool = False):
        """Open a file; ResultError if it cannot be used.

        Args:
            file: of the study, which is made unless it is there.
            must_exist: whether to refuse one that is not.
        """
        self.file = Path(file)
        if must_exist and not self.file.is_file():
            raise ResultError(f"{self._name}: no such study")
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ResultError(f"{self._name}: cannot be used, {error.strerror}") from None
        if self.file.is_dir():
            raise ResultError(f"{self._name}: cannot be used, it is a folder")
        with self._told():
            self._database = sqlite3.connect(self.file, PATIENCE, isolation_level=None)
            self._prepare()

    @property
    def _name(self) -> str:
        return short(str(self.file), 120)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Say in one line what is wrong with the file."""
        try:
            yield
        except sqlite3.Error as error:
            strange = "not a database" in str(error)
            told = "holds something that is not a study" if strange else f"cannot be used, {error}"
            raise ResultError(f"{self._name}: {told}") from None

    def _prepare(self) -> None:
        """Make the tables of an empty file; refuse what is not ours."""
        if self._pragma("schema_version") == 0:
            with self.transaction():
                # Another process may have been quicker.
                if self._pragma("schema_version") == 0:
                    for table in TABLES:
                        self._database.execute(table)
                    self._database.execute(f"PRAGMA application_id = {APPLICATION}")
                    self._database.execute(f"PRAGMA user_version = {VERSION}")
        if self._pragma("application_id") != APPLICATION:
            raise ResultError(f"{self._name}: holds something that is not a study")
        version = self._pragma("user_version")
        if version != VERSION:
            raise ResultError(
                f"{self._name}: is a study of version {version}, and this software reads version "
                f"{VERSION} alone; choose another file"
            )

    def _pragma(self, name: str) -> int:
        return self._database.execute(f"PRAGMA {name}").fetchone()[0]

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Do all or nothing of what is written meanwhile."""
        with self._told():
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                # Where the disk is full, SQLite has done it already.
                if self._database.in_transaction:
                    self._database.execute("ROLLBACK")
                raise
            self._database.execute("COMMIT")

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    # -- writing ----------------------------------------------------------------------------------

    def order(self, wanted: int, there: int) -> None:
        """Note that so many runs are wanted, of which so many are there."""
        with self.transaction():
            self._database.execute(
                "INSERT INTO orders (wanted, there, runs, began) "
                "SELECT ?, ?, (SELECT count(*) FROM runs), ?",
                (wanted, there, datetime.now(UTC).isoformat(timespec="seconds")),
            )

    def keep(self, *rows: Row) -> None:
        """Keep all of some runs, or none; what is there already stays, unless it was lost."""
        with self.transaction():
            for row in rows:
                self._insert(row)

    def _insert(self, row: Row) -> None:
        told = {name: value for name, value in row.summary.items() if name != "versions"}
        versions, defaults, changes, summary = (
            json.dumps(value, allow_nan=False)
            for value in (row.versions, row.defaults, row.changes, told)
        )
        self._database.execute(SOFTWARE, (row.software, versions, defaults))
        known = (told["scenario"], told["variant"], told["seed"], changes, summary, row.outcome)
        made = (told.get("wall_time_s"), row.worker, row.tries, row.finished)
        self._database.execute(RUN, (row.key, row.software, *known, *made))

    # -- reading ----------------------------------------------------------------------------------

    def known(self, keys: Iterable[str]) -> set[str]:
        """Return which of some runs are there, and were not lost."""
        return {key for (key,) in self._of(keys, "key", "AND outcome <> 'lost'")}

    def numbers(self, keys: Iterable[str]) -> dict[str, int]:
        """Return the numbers of the rows of some runs, as far as they are there."""
        return dict(self._of(keys, "key, id"))

    def summaries(self, keys: Iterable[str]) -> dict[str, Summary]:
        """Return the summaries of some runs, as far as they are there."""
        versions = dict(self.execute("SELECT id, versions FROM software"))
        versions = {number: json.loads(text) for number, text in versions.items()}
        return {
            key: json.loads(text) | {"versions": versions[software]}
            for key, text, software in self._of(keys, "key, summary, software")
        }

    def _of(self, keys: Iterable[str], columns: str, also: str = "") -> sqlite3.Cursor:
        query = f"SELECT {columns} FROM runs WHERE key IN (SELECT value FROM json_each(?)) {also}"
        return self.execute(query, (json.dumps(list(keys)),))

    def rows(self, where: str = "1", *values: object, order: str = "id") -> Iterator[Row]:
        """Yield rows.

        Args:
            where: a condition of SQL over the columns of `runs`.
            *values: of its question marks.
            order: by which column; with a limit, if need be.
        """
        software = {
            number: (digest, json.loads(versions), json.loads(defaults))
            for number, digest, versions, defaults in self.execute(
                "SELECT id, digest, versions, defaults FROM software"
            )
        }
        columns = "key, software, changes, summary, outcome, worker, tries, finished, id"
        query = f"SELECT {columns} FROM runs WHERE {where} ORDER BY {order}"
        for key, of, changes, summary, outcome, *rest in self.execute(query, values):
            digest, versions, defaults = software[of]
            whole = json.loads(summary) | {"versions": versions}
            told = versions, defaults, json.loads(changes), outcome, whole
            yield Row(key, digest, *told, *rest)

    def row(self, number: int) -> Row:
        """Return a row by its number; ResultError if there is none."""
        for row in self.rows("id = ?", number):
            return row
        raise ResultError(f"{self._name}: has no run {number}")

    def execute(self, query: str, values: Iterable[object] = ()) -> sqlite3.Cursor:
        """Return what a query of SQL gives."""
        with self._told():
            return self._database.execute(query, tuple(values))
