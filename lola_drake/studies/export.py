"""The runs of a study as one table, for pandas, R, or a spreadsheet: CSV, or Parquet.

A line for each run: what is known of it, then its metrics, then what its scenario changes of the
defaults. Names are those of summary.json and of the scenario, with dots between their parts.
"""

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from pathlib import Path

from lola_drake.atomic_file import whole_file
from lola_drake.errors import OutputError
from lola_drake.studies.store import Store
from lola_drake.typed_yaml import leaves

KNOWN = ("run", "outcome", "worker", "tries", "finished", "software")
"""What is known of a run beside its summary and its scenario."""

METRICS = """
    SELECT replace(substr(entry.fullkey, 3), '"', '') AS metric
    FROM runs, json_tree(summary) AS entry WHERE entry.type <> 'object'
    GROUP BY metric ORDER BY min(runs.id), min(entry.id)
"""

CHANGES = "SELECT DISTINCT entry.key FROM runs, json_each(changes) AS entry ORDER BY entry.key"

BATCH = 5000
"""Lines that are written at a time."""

Line = list[object]


def export(store: Store, file: str | Path) -> int:
    """Write all runs of a study into a file of a kind that its name says; return their number.

    Raises:
        OutputError: If it is of another kind, cannot be written, or needs a package.
    """
    file = Path(file)
    if file.suffix not in WRITERS:
        raise OutputError(f"{file}: must end with {' or '.join(WRITERS)}")
    metrics, changes = _names(store)
    header = [*KNOWN, *metrics, *(f"scenario.{name}" for name in changes)]
    lines = _lines(store, metrics, changes)
    with whole_file(file) as partial:
        return WRITERS[file.suffix](partial, header, lines)


def _names(store: Store) -> list[list[str]]:
    """Return the names of all metrics and of all keys that any run has, in their order."""
    return [[name for (name,) in store.execute(query)] for query in (METRICS, CHANGES)]


def _lines(store: Store, metrics: Iterable[str], changes: Iterable[str]) -> Iterator[Line]:
    for row in store.rows():
        told = leaves({key: value for key, value in row.summary.items() if key != "versions"})
        known = row.number, row.outcome, row.worker, row.tries, row.finished, row.software
        yield [
            *known,
            *(told.get(name) for name in metrics),
            *(_plain(row.changes.get(name)) for name in changes),
        ]


def _plain(value: object) -> object:
    """Return what a cell of a table can hold: lists as JSON."""
    return json.dumps(value) if isinstance(value, (list, dict)) else value


def _write_csv(path: Path, header: list[str], lines: Iterator[Line]) -> int:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        return sum(bool(writer.writerow(line)) for line in lines)


def _write_parquet(path: Path, header: list[str], lines: Iterator[Line]) -> int:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        need = "Parquet needs a package: pip install 'lola_drake[parquet]'"
        raise OutputError(need) from None
    columns: list[list] = [[] for _ in header]
    for batch in iter(lambda: list(islice(lines, BATCH)), []):
        for column, values in zip(columns, zip(*batch, strict=True), strict=True):
            column.extend(values)
    arrays = [_array(column, pyarrow.array) for column in columns]
    pyarrow.parquet.write_table(pyarrow.table(arrays, names=header), path)
    return len(columns[0])


def _array(values: list, make: Callable) -> object:
    """Return a column: of its own type, of floats where whole numbers are among them, or text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} and float in kinds:
        values = [None if value is None else float(value) for value in values]
    elif len(kinds) > 1:
        values = [None if value is None else json.dumps(value) for value in values]
    return make(values)


WRITERS = {".csv": _write_csv, ".parquet": _write_parquet}
