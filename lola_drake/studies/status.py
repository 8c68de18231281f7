"""How far a study is, and its last runs."""

from datetime import datetime

from lola_drake.errors import ResultError, shown
from lola_drake.studies.row import OUTCOMES, Row
from lola_drake.studies.store import Store


def status(store: Store) -> dict[str, object]:
    """Return how many runs there are, how they ended, and how far the last order is."""
    counts = dict(store.execute("SELECT outcome, count(*) FROM runs GROUP BY outcome"))
    runs = sum(counts.values())
    order = store.execute("SELECT * FROM orders ORDER BY id DESC LIMIT 1").fetchone()
    found: dict[str, object] = {
        "file": str(store.file),
        "runs": runs,
        "outcomes": {name: counts.get(name, 0) for name in OUTCOMES},
        "last_order": None,
        "runs_per_hour": None,
    }
    if order is None:
        return found
    _, wanted, there, before, began = order
    made, hours = runs - before, _hours(began, _last(store))
    last = {"began": began, "wanted": wanted, "done": there + made}
    rate = made / hours if made and hours > 0 else None
    return found | {"last_order": last, "runs_per_hour": rate}


WORST = """
    CASE outcome WHEN 'completed' THEN 2 WHEN 'fell' THEN 1 ELSE 0 END,
    json_extract(summary, '$.fall_time_s'),
    max(json_extract(summary, '$.max_inclination_deg.x'),
        json_extract(summary, '$.max_inclination_deg.y')) DESC
"""
"""The order of the worst runs: who failed, the earliest falls, the most inclined."""


def listed_runs(
    store: Store, count: int, outcome: str | None = None, *, worst: bool = False
) -> list[dict[str, object]]:
    """Return the last runs of a study, the last one first, or the worst ones.

    Args:
        store: the study's file.
        count: the most of them.
        outcome: one of `OUTCOMES`, or None for all.
        worst: those that failed, then the falls, the earliest first, then the most inclined.
    """
    if outcome not in (None, *OUTCOMES):
        raise ResultError(f"outcome: {shown(outcome)}, there are {', '.join(OUTCOMES)}")
    where = ("outcome = ?", outcome) if outcome else ("1",)
    order = WORST if worst else "id DESC"
    return [_listed(row, store) for row in store.rows(*where, order=f"{order} LIMIT {count}")]


def _listed(row: Row, store: Store) -> dict[str, object]:
    told = ("scenario", "variant", "seed", "fall_time_s", "error")
    return {
        "run": row.number,
        **{name: row.summary[name] for name in told},
        "fall_events": row.summary.get("fall_events", []),
        "max_inclination_deg": row.summary.get("max_inclination_deg"),
        "outcome": row.outcome,
        "tries": row.tries,
        "worker": row.worker,
        "finished": row.finished,
        "command": f"lola study replay {store.file} {row.number}",
    }


def _last(store: Store) -> str:
    return store.execute("SELECT max(finished) FROM runs").fetchone()[0] or ""


def _hours(began: str, ended: str) -> float:
    if not ended:
        return 0.0
    taken = datetime.fromisoformat(ended) - datetime.fromisoformat(began)
    return taken.total_seconds() / 3600
